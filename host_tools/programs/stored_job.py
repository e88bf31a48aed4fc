"""Jobs in the form in which a board stores them.

    packed = pack_job(data)                     # what follows the first line of a file of options/jobs/config.py
    data = gcode_job(path)                  # the lines of a file, numbered; Failure if it is none
"""

import binascii
import os
import re
import zlib
from pathlib import Path

from host_tools.failure import Failure, reason
from host_tools.language import N_
from passo.records import WINDOW_BITS

LISTED = re.compile(r"\[FILE:(.+)\|SIZE:(\d+)\|STORED:(\d+)\|CRC:([0-9a-f]+)\|LANGUAGE:(\w+)\]")  # a row of the answer to $F


def name_by_crc(said, number):
    """Return the name of the job with this CRC-32 in the answer to `$F`, or ""."""
    return next((name for name, _, _, crc, _ in LISTED.findall("\n".join(said)) if int(crc, 16) == number), "")


def pack_job(data):
    """Return `data` deflated, with the window that a board has."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -WINDOW_BITS, 9)
    return packer.compress(data) + packer.flush()


def crc_of(data):
    return binascii.crc32(data)


def name_of(path):
    """Return a job's name for a file: its name in capitals, with '_' for letters that a job's name may not have."""
    from passo.options.jobs.config_names import LONGEST_NAME, NAME_LETTERS

    name = re.sub(f"[^{re.escape(NAME_LETTERS)}]", "_", Path(path).name.upper()).lstrip(".")
    return name[-LONGEST_NAME:]


def gcode_job(path, ended=None):
    """Read a G-code file as a job: a line for each of its lines up to the program's end, without comments and blanks, with the N words of `passo
    stream`, so that status reports and errors name the file's line. `ended`: see program_lines(). Raises Failure, also if no job may have a line."""
    from host_tools.programs import gcode_file

    return gcode_lines(gcode_file.read(path, ended, True))


def gcode_lines(lines):
    """Return [(number, bytes)] of a G-code file as a job's bytes."""
    from host_tools.clients.grbl_wire import number_line

    rows = [b""] * lines[-1][0]
    for number, line in lines:
        rows[number - 1] = number_line(number, line)
    return b"\n".join(rows) + b"\n"


def job_file(language, data):
    """Return `data` as a file of a board's folder of jobs."""
    from passo.options.jobs.config import first_line

    packed = pack_job(data)
    return first_line(language, len(data), crc_of(data), len(packed)) + packed


def write_on_card(card, name, language, data):
    """Write a job on a memory card, whose files lie in the folder `card`; returns its path. Raises Failure."""
    from passo.options.card.config import END_MARK
    from passo.options.jobs.config_names import LONGEST_NAME, name_fits
    from passo.options.jobs.manifest import RULES

    if not name_fits(name):
        raise Failure("{!r} is no job's name: at most {} capitals, digits, '.', '_' and '-'", name, LONGEST_NAME)
    if not card.is_dir():
        raise Failure("there is no folder {}: is the card in, and mounted?", card)
    folder = card / RULES["jobs"]["folder"][1].lstrip("/")
    try:
        folder.mkdir(exist_ok=True)
        path = folder / f"{name}.alt"
        if path.exists():
            path = path.with_suffix(".job")
        with open(path, "wb") as file:
            file.write(job_file(language, data))
            file.flush()
            os.fsync(file.fileno())
            file.write(END_MARK)
        path.with_suffix(".job" if path.suffix == ".alt" else ".alt").unlink(missing_ok=True)
    except OSError as error:
        raise Failure("cannot write {} on {}: {}", name, card, reason(error)) from error
    return path


def pulses_job(path):
    """Read a pulse file as a job: its codes, without blanks. Raises Failure with line and column of the fault."""
    from host_tools.programs.long_pulses import LongFile, codes_of

    LongFile(path, "xyz")
    return codes_of(Path(path).read_bytes())


def plotter_job(path):
    """Read a file of packets as a job. Raises Failure unless each packet is right and is one that a drawing may have. (`passo draw` makes packets of
    an SVG file.)"""
    from passo.protocols.plotter.host import COMMANDS, PACKET

    drawing = {COMMANDS[name] for name in ("REQUEST", "LINE", "MOVE", "END", "ORIGIN", "SPEED")}

    data = Path(path).read_bytes()
    packets = [data[at : at + PACKET] for at in range(0, len(data), PACKET)]
    for number, packet in enumerate(packets, 1):
        if len(packet) != PACKET or sum(packet[:-1]) & 255 != packet[-1]:
            raise Failure("{}: packet {} is no packet of the plotter's language", path, number)
        if packet[0] not in drawing:  # lines about settings, another link's command, jogs
            raise Failure("{}: packet {} is no part of a drawing: {}", path, number, packet.hex(" "))
    return data


# Of each language: the function that makes a job of a file, the unit by which flash is counted, the function that counts these units.
KINDS = {
    "grbl": (gcode_job, N_("line"), lambda data: data.count(b"\n")),
    "pulses": (pulses_job, N_("code"), len),
    "plotter": (plotter_job, N_("packet"), lambda data: len(data) // 6),
}

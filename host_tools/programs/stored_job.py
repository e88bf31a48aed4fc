"""Jobs in the form in which a board stores them.

    packed = pack(data)                     # what follows the first line of a file of config/job_store.py
    data = gcode_job(path)                  # the lines of a file, numbered; Failure if it is none
"""

import binascii
import re
import zlib
from pathlib import Path

from host_tools.failure import Failure
from passo.config.job_keys import LONGEST_NAME, NAME_LETTERS
from passo.config.job_store import WINDOW_BITS


def pack(data):
    """`data` deflated, with the window that a board has."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -WINDOW_BITS, 9)
    return packer.compress(data) + packer.flush()


def crc(data):
    return binascii.crc32(data)


def name_of(path):
    """The name of a file as a job's: capitals, and '_' for what a name may not have."""
    name = re.sub(f"[^{re.escape(NAME_LETTERS)}]", "_", Path(path).name.upper()).lstrip(".")
    return name[-LONGEST_NAME:]


def gcode_job(path):
    """A G-code file as a job: a line for each of its lines, without comments and blanks, numbered by N words as `passo stream`
    numbers them, so that status reports and errors name the file's line."""
    from host_tools.clients.grbl import tagged
    from host_tools.programs import gcode_file

    lines = gcode_file.read(path)
    numbered = not any(b"N" in line.upper() for _, line in lines)
    rows = [b""] * lines[-1][0]
    for number, line in lines:
        rows[number - 1] = tagged(number, line) if numbered else line
    return b"\n".join(rows) + b"\n"


def plotter_job(path):
    """An SVG file's packets are made by `passo draw`; here a file of packets is taken as it is, if each is right."""
    from passo.protocols.plotter.protocol import PACKET

    data = Path(path).read_bytes()
    packets = [data[at : at + PACKET] for at in range(0, len(data), PACKET)]
    for number, packet in enumerate(packets, 1):
        if len(packet) != PACKET or sum(packet[:-1]) & 255 != packet[-1]:
            raise Failure(f"{path}: packet {number} is no packet of the plotter's language")
    return data

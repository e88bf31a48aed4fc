"""The names of the programs that this PC has begun, by the number that a board's journal knows them by: so that messages about a board
whose sender has died name its program.

    program_names.remember_program(lines, "rings.gcode")    # of gcode_file.read(); returns the number
    program_names.remember_name(number, "rings.gcode", 251)      # the last line that moves
    program_names.name_of_number(number)              # (name, that line); ("", 0) if it has been begun elsewhere, or long ago
"""

import json
import mimetypes
import os
from pathlib import Path

from host_tools.programs.resume_line import number_of

KEPT = Path.home() / ".local" / "share" / "passo" / "begun.json"
CARD = "card"  # the program of the test card of `passo engrave`
_MOST = 100


def _read_kept():
    """Return {number as 8 hex digits: [name, last line]} of the file KEPT; {} if there is none that can be read."""
    try:
        known = json.loads(KEPT.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}


def remember_program(lines, name):
    """Remember the name of a program, [(number, bytes)], and its last line with X, Y or Z (0: none); return the program's number."""
    number = number_of(lines)
    moving = [at for at, line in lines if any(letter in line.upper() for letter in b"XYZ")]
    remember_name(number, name, moving[-1] if moving else 0)
    return number


def remember_name(number, name, last):
    """Remember the name of a program and its last line that moves, by its number. The oldest are forgotten. A folder that cannot be written is
    ignored."""
    known = _read_kept()
    known.pop(f"{number:08x}", None)
    known[f"{number:08x}"] = [name, last]
    new = KEPT.with_suffix(".new")
    try:
        KEPT.parent.mkdir(parents=True, exist_ok=True)
        new.write_text(json.dumps(dict(list(known.items())[-_MOST:])), encoding="utf-8")
        os.replace(new, KEPT)
    except OSError:
        pass


def name_of_number(number):
    """Return (name, its last line that moves) of a program's number; ("", 0) if it is not known."""
    kept = _read_kept().get(f"{number:08x}")
    if not isinstance(kept, list) or len(kept) != 2 or not isinstance(kept[0], str) or not isinstance(kept[1], int):
        return "", 0
    return kept[0], kept[1]


def is_engraving(name):
    """True if `name` is what `passo engrave` calls its program: that of a picture, or of its test card."""
    kind = mimetypes.guess_type(name)[0] or ""
    return name == CARD or kind.startswith("image/") and kind != "image/svg+xml"

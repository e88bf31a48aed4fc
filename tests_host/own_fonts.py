"""The fonts of the tests, and of all programs that they start: DejaVu, as matplotlib brings it, whatever is installed on this computer.

    bring()     # sets the environment, before matplotlib is imported or a program is started

fontconfig, and with it rsvg-convert and browsers, reads the file that is written here, and matplotlib makes a list of its own.
"""

import importlib.util
import os
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "build" / "fonts"
_NAMES = {
    "DejaVu Serif": ("serif", "Times New Roman", "Times", "Georgia"), "DejaVu Sans Mono": ("monospace", "Courier New", "Courier"),
    "DejaVu Sans": ("sans-serif", "system-ui", "Arial", "Helvetica", "Verdana"),
}  # fmt: skip
_OTHERS = "STIX", "cm", "LastResort"  # files beside DejaVu's


def _configuration(fonts):
    aliases = "".join(f"<alias binding='same'><family>{name}</family><prefer><family>{font}</family></prefer></alias>\n" for font in _NAMES for name in _NAMES[font])
    rejected = "".join(f"<rejectfont><glob>{fonts}/{begin}*</glob></rejectfont>" for begin in _OTHERS)
    # As everywhere: a family that is not known is a sans-serif.
    last = "<match target='pattern'><edit name='family' mode='append_last'><string>DejaVu Sans</string></edit></match>"
    return (
        "<?xml version='1.0'?><!DOCTYPE fontconfig SYSTEM 'fonts.dtd'>\n"
        f"<fontconfig><dir>{fonts}</dir><cachedir>{FOLDER / 'cache'}</cachedir>\n<selectfont>{rejected}</selectfont>\n{aliases}{last}\n</fontconfig>\n"
    )


def bring():
    found = importlib.util.find_spec("matplotlib")
    if not found:
        return  # nor is there anything that draws letters
    text = _configuration(Path(found.origin).parent / "mpl-data" / "fonts" / "ttf")
    file = FOLDER / "fonts.conf"
    if not file.exists() or file.read_text(encoding="utf-8") != text:
        FOLDER.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=FOLDER, delete=False, encoding="utf-8") as made:
            made.write(text)
        os.replace(made.name, file)
    os.environ |= {"FONTCONFIG_FILE": str(file), "MPLCONFIGDIR": str(FOLDER / "matplotlib"), "MPL_IGNORE_SYSTEM_FONTS": "1"}

"""Finds the project's own files: in a checkout, or beside the package that pip has installed.

    FIRMWARE        the folder that holds passo/, the firmware's package
    MAIN            firmware/main.py
    BOARDS          the folder of the project's board files
    EXAMPLES        that of the files that the documents use
    project_address()   the project's address, or "not published yet"
    version()       "0.1.0": one for tools, firmware and UF2
"""

import tomllib
from importlib import metadata
from pathlib import Path

HOST_TOOLS = Path(__file__).resolve().parent
ROOT = HOST_TOOLS.parent  # of a checkout; of an installation site-packages

if (ROOT / "firmware" / "main.py").is_file():
    FIRMWARE = ROOT / "firmware"
    MAIN = FIRMWARE / "main.py"
    BOARDS = ROOT / "boards"
    EXAMPLES = ROOT / "examples"
else:  # package-dir in pyproject.toml says what lies where
    FIRMWARE = ROOT
    MAIN = HOST_TOOLS / "firmware" / "main.py"
    BOARDS = ROOT / "passo_boards"
    EXAMPLES = ROOT / "passo_examples"


ADDRESS = ""  # of the project, once a release was made; README and tests ask it


def project_address():
    """Return the address of the project, in words for people."""
    return ADDRESS or "not published yet"


def version():
    """Return the version in pyproject.toml; of an installation, the one that pip has noted."""
    if FIRMWARE == ROOT:
        return metadata.version("passo")
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]

"""What a server on the board sends to browsers, as it lies in the board's flash: compressed, in one file, and beside the page what the
page of a PC gets from the PC's own tables. The file's form: passo/web/files.py.

    pack(board, Path("build/torch_pico_w/passo/web/page"))      # [(name, bytes before, bytes packed)]
"""

import gzip
import json

from host_tools.clients import setting_names
from host_tools.resources import FIRMWARE
from passo import error_texts
from passo.web.files import PACK

PAGES = FIRMWARE / "passo" / "web" / "page"
# The small page of the torch's HTTP table; all other files are those of the page.
OF_HTTP = {"torch": ("torch.html", "torch.css", "torch.js", "sha256.js")}
_AS_THEY_ARE = ("torch.html",)  # it is the end of another text
_AXES = 4


def names_of(board):
    """The files of the folder PAGES that a board needs."""
    links = [link for link in board.get("links", []) if board.get("network")]
    small = {name for names in OF_HTTP.values() for name in names}
    names = {name for link in links if link["port"] == "http" for name in OF_HTTP.get(link["protocol"], ())}
    if [link for link in links if link["port"] == "page"]:
        names |= {path.name for path in PAGES.iterdir() if path.name not in small or path.name == "sha256.js"}
    return sorted(names)


def error_list():
    """{number: text} of all errors and alarms."""
    return {str(number): error_texts.text(number) for number in error_texts.numbers()}


def bare(name, text):
    """A script or a sheet of style without indentation, empty lines and lines of comment: bytes of a file that no person reads."""
    if not name.endswith((".js", ".css")):
        return text
    lines = [line.strip() for line in text.split(b"\n")]
    return b"\n".join(line for line in lines if line and not line.startswith(b"//")) + b"\n"


def pack(board, out):
    """Write the files of a board to the folder `out`, if there are any. Returns rows (name, bytes before, bytes packed)."""
    texts = {name: bare(name, (PAGES / name).read_bytes()) for name in names_of(board)}
    if "index.html" in texts:
        texts["errors.json"] = json.dumps(error_list()).encode()
        texts["rules.json"] = json.dumps(setting_names.rules(_AXES)).encode()
    if not texts:
        return []
    out.mkdir(parents=True, exist_ok=True)
    packed = {name: gzip.compress(text, 9, mtime=0) for name, text in texts.items() if name not in _AS_THEY_ARE}
    head = "".join(f"{name} {len(data)}\n" for name, data in packed.items()) + "\n"
    (out / PACK).write_bytes(head.encode() + b"".join(packed.values()))
    for name in texts.keys() - packed.keys():
        (out / name).write_bytes(texts[name])
    return [(name, len(text), len(packed.get(name, text))) for name, text in texts.items()]

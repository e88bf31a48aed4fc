"""Packs the files that a server on the board sends to browsers: compressed, in one file of the board's flash, with the tables that the page of a PC
takes from the PC. The file's form: passo/web/files.py.

    pack_files(board, Path("build/torch_pico_w/passo/web/page"))      # [(name, bytes before, bytes packed)]
"""

import gzip
import json
import re

from host_tools import options
from host_tools.clients import setting_names
from host_tools.failure import Failure
from host_tools.resources import FIRMWARE
from passo.web.files import PACK

PAGES = FIRMWARE / "passo" / "web" / "page"
# The small page of the torch's HTTP table; all other files are those of the page.
OF_HTTP = {"torch": ("torch.html", "torch.css", "torch.js", "sha256.js")}
OF_PC = ("setup_make.js", "card_board.js", "card_prove.js")  # computations of a PC: a board's page lacks these scripts, and says so
ENTRIES = ("panel.js", "setup.js")  # a PC's page loads the second one when it is wanted; a board's one script has both
_OF_G_CODE = "setup"  # files that begin so are the set-up of a machine that takes G-code
_AS_THEY_ARE = ("torch.html",)  # it is the end of another text
_AXES = 4
_IMPORT = re.compile(r'^import (?:\{([^}]*)\} from )?"\./([\w.]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?:async )?(?:function|class|const) (\w+)", re.MULTILINE)
_BEHIND = re.compile(rb"  // [^\"'`]*$")  # a comment behind a line of a script


def names_of(board):
    """Return the files of the folder PAGES that a board needs."""
    links = [link for link in board.get("links", []) if board.get("network")]
    small = {name for names in OF_HTTP.values() for name in names}
    names = {name for link in links if link["port"] == "http" for name in OF_HTTP.get(link["protocol"], ())}
    spoken = [link["protocol"] for link in links if link["port"] == "page"]
    if spoken:
        names |= {path.name for path in PAGES.iterdir() if path.name not in (small - {"sha256.js"}) | set(OF_PC) and ("grbl" in spoken or not path.name.startswith(_OF_G_CODE))}
    return sorted(names)


def error_list():
    """Return {number: text} of all errors and alarms."""
    return {str(number): text for number, text in sorted(options.error_texts().items())}


def strip_comments(name, text):
    """Return a script or a sheet of style without indentation, empty lines and comments: bytes of a file that no person reads."""
    if not name.endswith((".js", ".css")):
        return text
    lines = [_BEHIND.sub(b"", line).strip() for line in text.split(b"\n")]
    return b"\n".join(line for line in lines if line and not line.startswith(b"//")) + b"\n"


def bundle_modules(modules, *entries):
    """Return the page's modules as one script, each in a function of its own: a file less is a request less, and 70 bytes of a board's heap.
    `modules`: {name: text}. Raises Failure if it cannot read a module."""
    done, under_way, made = set(), [], []

    def add_module(name):
        """Add a module behind those that it imports. Raises Failure."""
        if name in under_way:
            raise Failure("{} imports itself, by way of {}", name, ", ".join(under_way))
        if name in done:
            return
        under_way.append(name)
        wanted = _IMPORT.findall(modules[name])
        for _, other in wanted:
            add_module(other)
        under_way.pop()
        done.add(name)
        body = _IMPORT.sub("", modules[name])
        exported = _EXPORT.findall(body)
        body = _EXPORT.sub(lambda found: found[0][len("export ") :], body)
        if re.search(r"^(import|export)\b", body, re.MULTILINE):
            raise Failure("{} imports or exports in a form that the page's bundle does not know", name)
        takes = "".join(f"const {{{names.replace(' as ', ': ')}}} = {_variable_of(other)};\n" for names, other in wanted if names)
        gives = f"return {{ {', '.join(exported)} }};\n" if exported else ""
        made.append(f"const {_variable_of(name)} = (() => {{\n{takes}{body}{gives}}})();\n")

    for entry in entries:
        add_module(entry)
    return "".join(made)


def _variable_of(name):
    """Return the name of the constant that stands for a module in the bundle."""
    return "of_" + name.removesuffix(".js")


def texts_of(board):
    """Return {name: bytes} of the files of a board, before they are packed: the page's modules are one script."""
    texts = {name: strip_comments(name, (PAGES / name).read_bytes()) for name in names_of(board)}
    if "index.html" in texts:
        modules = {name: text.decode() for name, text in texts.items() if name.endswith(".js")}
        alone = {name for link in board["links"] if link["port"] == "http" for name in OF_HTTP.get(link["protocol"], ())}
        texts = {name: text for name, text in texts.items() if name not in modules or name in alone}
        texts["panel.js"] = bundle_modules(modules, *[name for name in ENTRIES if name in modules]).encode()
        texts["pt.json"] = _catalogue_text(board, modules, texts["index.html"].decode()).encode()
    return texts


def page_words():
    """Return the page's catalogue, with the words of options' settings."""
    of_settings = {name for name, *_ in (*options.setting_rows().values(), *options.axis_settings().values())}
    return json.loads((PAGES / "pt.json").read_text(encoding="utf-8")) | {text: said for text, said in options.portuguese_texts().items() if text in of_settings}


def _catalogue_text(board, modules, page):
    """Return the catalogue as JSON, without the words of scripts that the board has not."""
    gone = "".join(path.read_text(encoding="utf-8") for path in PAGES.glob("*.js") if path.name not in names_of(board))
    here = "".join(modules.values()) + page + json.dumps([error_list(), setting_names.all_rules(_AXES)])
    kept = {text: word for text, word in page_words().items() if f'_("{text}"' not in gone or text in here}
    return "{\n" + ",\n".join(f"{json.dumps(text, ensure_ascii=False)}: {json.dumps(word, ensure_ascii=False)}" for text, word in kept.items()) + "\n}\n"


def pack_files(board, out):
    """Write the files of a board to the folder `out`, if there are any. Return rows (name, bytes before, bytes packed)."""
    texts = texts_of(board)
    if "index.html" in texts:
        texts["errors.json"] = json.dumps(error_list()).encode()
        texts["rules.json"] = json.dumps(setting_names.all_rules(_AXES)).encode()
    if not texts:
        return []
    out.mkdir(parents=True, exist_ok=True)
    packed = {name: gzip.compress(text, 9, mtime=0) for name, text in texts.items() if name not in _AS_THEY_ARE}
    head = "".join(f"{name} {len(data)}\n" for name, data in packed.items()) + "\n"
    (out / PACK).write_bytes(head.encode() + b"".join(packed.values()))
    for name in texts.keys() - packed.keys():
        (out / name).write_bytes(texts[name])
    return [(name, len(text), len(packed.get(name, text))) for name, text in texts.items()]

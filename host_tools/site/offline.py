"""Makes the page installable, and loads it without its server: a manifest, and a service worker that keeps the files by their hash.

    offline.make_files({"index.html": b"…", …}, first="cache")       # {name: bytes} to be served beside them
    offline.add_to_page(text)                                           # index.html that names them

`first`: "cache", a static site; "network", a server that may have been updated: the files kept serve while it does not answer. Browsers allow
it at 127.0.0.1 and over HTTPS only; elsewhere the page is as without. New files make another service worker, which keeps those alone.
"""

import hashlib
from pathlib import Path

OWN = Path(__file__).resolve().parent
NAMES = ("manifest.json", "offline.js", "sw.js")
_HEAD = '<link rel="manifest" href="manifest.json">\n<script type="module" src="offline.js"></script>\n'
_MARK = "</title>\n"


def add_to_page(text):
    """Return a page with the manifest and the script of the service worker in its head."""
    return text.replace(_MARK, _MARK + _HEAD, 1)


def make_files(served, first):
    """Return {name: bytes} to be served beside `served`, {name: bytes} of all that the page loads. `first`: "cache" or "network"."""
    digest = hashlib.sha256()
    for name in sorted(served):
        digest.update(name.encode() + b"\0" + served[name] + b"\0")
    made = {name: (OWN / name).read_text(encoding="utf-8") for name in NAMES}
    names = "".join(f'"{name}", ' for name in sorted(served) if name != "index.html")
    for mark, text in (("HASH", digest.hexdigest()[:16]), ("WHICH", first), ('"NAMES"', names + '"./"')):
        made["sw.js"] = made["sw.js"].replace(mark, text)
    return {name: text.encode() for name, text in made.items()}

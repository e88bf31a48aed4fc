"""The page's JavaScript is what Chrome 70 and Safari 12 read: its syntax by acorn, from npm, and no function that they lack.

Without node or npm's registry the syntax is not checked, and the test says so.
"""

import json
import re
import shutil
import subprocess

import pytest

from host_tools.failure import Failure
from host_tools.panel.panel import FOLDER
from host_tools.site import offline
from host_tools.site.npm import Package
from host_tools.site.offline import OWN

ACORN = Package("acorn", "acorn", "8.14.0", "cl669nCJTZBsL97OF4kUQm5g5hC2uihk0NxY3WENAC0TYdILVkAyHymAntgxGkl7K+t0cXIrH5siy5S4XkFycA==")
NODE = shutil.which("node")
SCRIPTS = sorted(path.name for path in FOLDER.glob("*.js"))
OFFLINE = [OWN / name for name in offline.NAMES if name.endswith(".js")]
OF_2018 = 2019  # ECMAScript 2018, and catch without a name, which both have
# Functions of later years that old.js does not add.
LATER = (r"\.replaceAll\(", r"\.at\(-", r"\.matchAll\(", r"Promise\.(any|allSettled)", r"structuredClone", r"ResizeObserver", r"\.flat\(\)", r"\.toggleAttribute\(",
         r"globalThis", r"queueMicrotask", r"\.findLast", r"BigInt", r"\bimport\(", r"\.randomUUID\(", r"\.isConnected")  # fmt: skip
PARSE = """
const acorn = require(process.argv[1]), fs = require("fs"), wrong = [];
for (const file of process.argv.slice(3)) {
  try { acorn.parse(fs.readFileSync(file, "utf8"), { ecmaVersion: Number(process.argv[2]), sourceType: "module" }); }
  catch (error) { wrong.push(file + ": " + error.message); }
}
console.log(JSON.stringify(wrong));
"""


def parsed(files, tmp_path):
    """Return acorn's errors for the files."""
    if not NODE:
        pytest.skip("NO NODE: apt-get install nodejs, to check the page's syntax")
    try:
        text = ACORN.read_files("dist/acorn.js")["dist/acorn.js"]
    except Failure as failure:
        if "cannot fetch" not in str(failure):
            raise
        pytest.skip(f"NO ACORN: {failure}")
    (tmp_path / "acorn.js").write_bytes(text)
    return json.loads(subprocess.run([NODE, "-e", PARSE, str(tmp_path / "acorn.js"), str(OF_2018), *map(str, files)], capture_output=True, check=True).stdout)


def test_browsers_of_2018_read_it(tmp_path):
    assert not parsed([*(FOLDER / name for name in SCRIPTS), *OFFLINE], tmp_path)


@pytest.mark.parametrize("text", ["a?.b", "a ?? b", "await x;", "class A { #b = 1; }", "a ||= b"])
def test_what_came_later_is_found(tmp_path, text):
    (tmp_path / "later.js").write_text(text)
    assert parsed([tmp_path / "later.js"], tmp_path)


@pytest.mark.quick
@pytest.mark.parametrize("path", [*(FOLDER / name for name in SCRIPTS), *OFFLINE], ids=lambda path: path.name)
def test_it_calls_nothing_that_they_lack(path):
    source = path.read_text(encoding="utf-8")
    assert not [word for word in LATER if re.search(word, source)]


@pytest.mark.quick
def test_the_styles_need_nothing_later():
    """No `gap` in a flex box, no min() or clamp(), no `inset` or `aspect-ratio`."""
    for path in FOLDER.glob("p*.css"):
        for rule, body in re.findall(r"([^{}]+)\{([^{}]*)\}", path.read_text(encoding="utf-8")):
            assert not re.search(r"display: (inline-)?flex", body) or not re.search(r"(^|[\s;])gap:", body), rule
            assert not re.search(r"\bmin\(|\bmax\(|\bclamp\(|aspect-ratio|(^|[\s;])inset:", body), rule

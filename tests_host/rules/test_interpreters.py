"""One place starts interpreters: host_tools/interpreter.py, isolated, for the tools and for the tests."""

import re
from pathlib import Path

import pytest
from test_board_command import ROOT

from host_tools import interpreter

pytestmark = pytest.mark.quick
STARTS = r'sys\.executable(?!\)\.(parent|with_name))|"(MICROPYPATH|PYTHONPATH|PYTHONHOME)"|os\.exec[lv]|runpy\.run_path\(str\(found'
ALLOWED = (
    '"Python3_EXECUTABLE": sys.executable', '"PYTHON": sys.executable',  # a build of MicroPython asks for them
    "each != sys.executable", "os.execv({words[0]!r}", "PYTHONPATH=",
)  # fmt: skip


def starts_of(path):
    """Lines of a source that start an interpreter by themselves, or hand on where the user says that its modules are."""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if re.search(STARTS, line) and not any(each in line for each in ALLOWED):
            yield f"{path.relative_to(ROOT)}:{number}: {line.strip()}"


def test_interpreters_are_started_in_one_place():
    """If this fails: [*interpreter.python(), …], interpreter.passo(…), interpreter.environment(…) instead."""
    files = [path for folder in ("host_tools", "tests_host") for path in (ROOT / folder).rglob("*.py")]
    homes = [Path(interpreter.__file__), Path(__file__), ROOT / "tests_host" / "tools" / "test_isolation.py"]
    assert [line for path in files if path.resolve() not in homes for line in starts_of(path)] == []

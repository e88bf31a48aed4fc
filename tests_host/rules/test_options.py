"""Each folder of passo/options can be deleted: boards that do not ask for its key check and have the files that they had; the key is unknown.

`make check` tries two of them by lot, `make test-all` each.
"""

import json
import os
import random
import shutil
import subprocess
import time
import zlib

import pytest

from host_tools import boards, interpreter
from host_tools.build import tree
from host_tools.build.reference import load_manifests
from host_tools.resources import FIRMWARE, ROOT
from passo.config.board_error import OF_INPUT, OF_OUTPUT, Additions, BoardError, options_by_value
from passo.config.boardfile import check

OPTIONS = sorted(load_manifests())
_RUN = os.environ.get("PYTEST_XDIST_TESTRUNUID") or str(time.time())  # the same for all workers
SEED = os.environ.get("PASSO_LOT") or str(zlib.crc32(_RUN.encode()) & 0xFFFF)
LOT = random.Random(SEED).sample(OPTIONS, 2)
# Imports what a PC can; then says of each board: the files of its build, or why its board file is refused.
_ALL_BOARDS = """
import importlib, json, sys
from pathlib import Path
from host_tools import boards, interpreter
from host_tools.build import tree
from host_tools.failure import Failure
for path in tree.module_files(Path(sys.argv[1])):
    if path.parts[1] != "ports" and not path.stem.startswith("port"):
        importlib.import_module(".".join(path.with_suffix("").parts))
found = {}
for name in boards.names():
    try:
        found[name] = sorted(path.as_posix() for path in tree.select_modules(boards.load(name), Path(sys.argv[1])))
    except Failure as failure:
        found[name] = str(failure)
print(json.dumps(found))
"""


def builds(firmware, folder):
    """{board: the files of its build, or the error} with this firmware; `folder`: for the script that finds them."""
    script = folder / "all_boards.py"
    script.write_text(_ALL_BOARDS, encoding="utf-8")
    command = [*interpreter.python(firmware, ROOT), str(script), str(firmware)]
    done = subprocess.run(command, env=interpreter.environment(), cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return builds(FIRMWARE, tmp_path_factory.mktemp("whole"))


def parts(option):
    """The option and those that share its files: they go together."""
    return {option} | {other for other, manifest in load_manifests().items() if option in getattr(manifest, "SHARES", ())}


def spoken(board):
    """The options that the languages of a board's links ask for."""
    paths = [FIRMWARE / "passo" / "protocols" / link["protocol"] / "__init__.py" for link in board["links"]]
    return {option for path in paths for option in tree.options_asked(path.read_text(encoding="utf-8"))}


@pytest.mark.parametrize("option", [pytest.param(option, marks=pytest.mark.quick if option in LOT else pytest.mark.slow) for option in OPTIONS])
def test_an_option_can_be_deleted(option, whole, tmp_path):
    firmware = tmp_path / "firmware"
    shutil.copytree(FIRMWARE, firmware, ignore=shutil.ignore_patterns("__pycache__"))
    gone = parts(option)
    for name in gone:
        shutil.rmtree(firmware / tree.OPTIONS / name)
    left = builds(firmware, tmp_path)
    assert left.keys() == whole.keys()
    for name in boards.names():
        board = boards.load(name)
        asked, by_value = gone & board.keys(), gone & set(options_by_value(board))
        outputs = {each for each in by_value if each.startswith((OF_OUTPUT, OF_INPUT))}
        if outputs:  # one that nothing sees to any more is no fault
            assert set(whole[name]) - set(left[name]) >= {str(tree.OPTIONS / each / tree.MANIFEST) for each in outputs}, (name, SEED)
        elif asked or by_value or gone & spoken(board):
            said = [f"unknown key '{key}'" for key in asked] + [f"asks for the option {each}" for each in by_value | gone & spoken(board)]
            said += [f"'{each.partition('_')[2]}' is none of step_dir" for each in by_value]
            assert isinstance(left[name], str) and any(text in left[name] for text in said), (name, SEED)
        else:
            assert left[name] == whole[name], (name, SEED)


LANGUAGES = sorted(path.parent.name for path in (FIRMWARE / "passo" / "protocols").glob("*/__init__.py") if "NEEDS =" in path.read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.parametrize("language", sorted(set(LANGUAGES) - {"grbl"}))  # whose files the PC's engine is made of
def test_a_language_can_be_deleted(language, whole, tmp_path):
    firmware = tmp_path / "firmware"
    shutil.copytree(FIRMWARE, firmware, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.rmtree(firmware / "passo" / "protocols" / language)
    for path in [*firmware.glob(f"passo/options/*/language_{language}.py"), *firmware.glob(f"passo/protocols/page/{language}.py")]:
        path.unlink()  # files of options and of the page for this language
    left = builds(firmware, tmp_path)
    for name in boards.names():
        if language in [link["protocol"] for link in boards.load(name)["links"]]:
            assert isinstance(left[name], str) and language in left[name], name
        else:
            assert left[name] == whole[name], name


ADDED = sorted(vars(Additions()))  # and those that it had as keys of the board


@pytest.mark.quick
@pytest.mark.parametrize("name", [name for name in boards.names() if set(OPTIONS) & boards.load(name).keys()])
def test_a_board_file_has_no_key_that_only_options_write(name):
    """The same holds for a key that describes their additions; and check() of a checked board changes nothing."""
    board = boards.load(name)
    checked = check(board)
    for key in ["additions", *ADDED]:
        with pytest.raises(BoardError, match=f"unknown key {key!r}"):
            check({**board, key: {}})
    again = check(checked)
    written, rewritten = vars(checked.pop("additions")), vars(again.pop("additions"))
    assert checked == again and str(written) == str(rewritten) and written["value"] is None and not written["extensions"]


@pytest.mark.quick
@pytest.mark.parametrize("option", OPTIONS)
def test_a_key_that_says_nothing_asks_for_nothing(option):
    """A board file may say None: the modules loaded and built are those of a board without the key."""
    board = boards.load("plotter_2014")
    plain, asking = check(board), check({**board, option: None})
    added, asked = vars(plain.pop("additions")), vars(asking.pop("additions"))
    assert asking == plain and asked == added

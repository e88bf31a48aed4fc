"""Each folder of passo/options can be deleted, and each language but grbl: boards that do not ask for it check, and their builds have the files and the bytes
that they had; the key is unknown; tests of the others are collected, and the rules pass.

`make check` tries two options by lot, `make test-all` each in a copy of the repository (without.py); of three by lot it runs what `make check` runs there.
PASSO_LOT=7 draws as seed 7 does; a failure tells its seed.
"""

import json
import os
import random
import shutil
import subprocess
import time
import zlib

import pytest
import without

from host_tools import boards, interpreter
from host_tools.build import tree
from host_tools.build.reference import load_manifests
from host_tools.resources import FIRMWARE, ROOT
from passo.config.board_error import OF_INPUT, OF_OUTPUT, Additions, BoardError, nearest, options_by_value, options_wanted
from passo.config.boardfile import check

OPTIONS = sorted(load_manifests())
_RUN = os.environ.get("PYTEST_XDIST_TESTRUNUID") or str(time.time())  # the same for all workers
SEED = os.environ.get("PASSO_LOT") or str(zlib.crc32(_RUN.encode()) & 0xFFFF)
LOT = random.Random(SEED).sample(OPTIONS, 3)
# Imports what a PC can; then says of each board the files of its build, or why its board file is refused; of boards named the stamp of their builds; of keys named
# the error of a board file that has one.
_ALL_BOARDS = """
import importlib, json, sys, tempfile
from pathlib import Path
from host_tools import boards
from host_tools.build import tree
from host_tools.failure import Failure
from passo.config.board_error import BoardError
from passo.config.boardfile import check
firmware, named, keys = Path(sys.argv[1]), sys.argv[2].split(","), sys.argv[3:]
asked = {path.parent.name: tree.options_asked(path.read_text()) for path in (firmware / "passo" / "protocols").glob("*/__init__.py")}
gone = [name for name in asked if [each for each in asked[name] if not (firmware / tree.OPTIONS / each).is_dir()]]  # languages that ask for what is deleted
for path in tree.module_files(firmware):
    of_language = path.parts[-2] if path.parts[1] == "protocols" and path.parts[-2] != "page" else path.stem.partition("language_")[2] or path.stem
    if path.parts[1] != "ports" and not path.stem.startswith("port") and of_language not in gone:
        importlib.import_module(".".join(path.with_suffix("").parts))
files, stamps, errors = {}, {}, {}
for name in boards.names():
    try:
        board = boards.load(name)
        files[name] = sorted(path.as_posix() for path in tree.select_modules(board, firmware))
    except Failure as failure:
        files[name] = str(failure)
        continue
    for key in keys:
        try:
            check({**board, key: {}})
        except BoardError as error:
            errors[key] = str(error)
    if name in named or named == ["all"]:
        with tempfile.TemporaryDirectory() as folder:
            try:
                tree.build_tree(name, Path(folder), firmware=firmware)
                stamps[name] = (Path(folder) / tree.STAMP).read_text()
            except Failure as failure:
                stamps[name] = str(failure)  # too large for stock MicroPython: it tells the size
print(json.dumps([files, stamps, errors]))
"""


def builds(firmware, folder, named, keys=()):
    """[{board: the files of its build, or the error}, {board: stamp} of the boards named, {key: the error of a board file with it}] with this firmware; `folder`:
    for the script that finds them."""
    script = folder / "all_boards.py"
    script.write_text(_ALL_BOARDS, encoding="utf-8")
    command = [*interpreter.python(firmware, ROOT), str(script), str(firmware), named, *keys]
    done = subprocess.run(command, env=interpreter.environment(), cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def serves_page(name):
    """Whether a board has a page of its own, which has the texts of all options: its build is another one without any of them."""
    return "page" in [link["port"] for link in boards.load(name)["links"]]


# A board of which no option by lot for `make check` takes anything: it is built there.
BUILT = random.Random(SEED).choice([
    name for name in boards.names() if not serves_page(name) and not any(name in without.boards_with(*without.parts(option)) for option in LOT[:2])
] or [""])  # fmt: skip


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return builds(FIRMWARE, tmp_path_factory.mktemp("whole"), BUILT)


def spoken(board):
    """The options that the languages of a board's links ask for."""
    paths = [FIRMWARE / "passo" / "protocols" / link["protocol"] / "__init__.py" for link in board["links"]]
    return {option for path in paths for option in tree.options_asked(path.read_text(encoding="utf-8"))}


@pytest.mark.parametrize("option", [pytest.param(option, marks=pytest.mark.quick if option in LOT[:2] else pytest.mark.slow) for option in OPTIONS])
def test_an_option_can_be_deleted(option, whole, tmp_path):
    firmware = tmp_path / "firmware"
    shutil.copytree(FIRMWARE, firmware, ignore=shutil.ignore_patterns("__pycache__"))
    gone, _ = without.parts(option)
    keys = {key: manifest for key, manifest in load_manifests().items() if key in gone and key in manifest.RULES}
    for name in gone:
        shutil.rmtree(firmware / tree.OPTIONS / name)
    files, _, _ = whole
    left, stamps, errors = builds(firmware, tmp_path, BUILT, keys)
    assert stamps.items() <= whole[1].items() and (stamps or option not in LOT[:2])
    for key in keys:
        known = errors[key].partition("; known are ")[2].split(", ")
        assert errors[key].startswith(f"the board file: unknown key {key!r}{nearest(key, known)}; known are ") and "chip" in known and key not in known
    assert left.keys() == files.keys()
    for name in boards.names():
        board = boards.load(name)
        asked, by_value = gone & board.keys(), gone & set(options_by_value(board))
        outputs = {each for each in by_value if each.startswith((OF_OUTPUT, OF_INPUT))}
        if outputs:  # one that nothing sees to any more is no fault
            assert set(files[name]) - set(left[name]) >= {str(tree.OPTIONS / each / tree.MANIFEST) for each in outputs}, (name, SEED)
        elif asked or by_value or gone & spoken(board):
            said = [f"unknown key '{key}'" for key in asked] + [f"asks for the option {each}" for each in by_value | gone & spoken(board)]
            said += [f"{key}: '{each.partition('_')[2]}' is none of" for each, (key, _) in options_wanted(board).items() if each in gone]
            assert isinstance(left[name], str) and any(text in left[name] for text in said), (name, SEED)
        else:
            assert left[name] == files[name], (name, SEED)


LANGUAGES = sorted(set(without.language_names()) - {"grbl"})  # whose files the PC's engine is made of


# Names whose copies have passed. Of the others a failure is no fault yet; one that passes (XPASS) belongs here.
SHOWN = ("blackbox", "card", "drive_pbl3770a", "input_jog", "input_p", "output_p", "parking", "servo", "tachometer", "weaving")
NOT_SHOWN = pytest.mark.xfail(reason="this copy has not passed yet", strict=False)


@pytest.fixture(scope="module")
def stamps(tmp_path_factory):
    """{board: the stamp of its build}."""
    return builds(FIRMWARE, tmp_path_factory.mktemp("stamps"), "all")[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(name, marks=() if name in SHOWN else NOT_SHOWN) for name in (*OPTIONS, *LANGUAGES)])
def test_what_is_left_is_whole(name, stamps, tmp_path, show):
    """Each board that is left has the build that it had, byte by byte; all tests are collected, and rules pass. Of the options by lot: all that `make check` runs."""
    copy = tmp_path / "copy"
    gone = without.make(name, copy)
    script = copy / "all_boards.py"
    script.write_text(_ALL_BOARDS, encoding="utf-8")
    files, left, _ = json.loads(without.run(copy, script, copy / "firmware", "all")[1])
    assert left.keys() == files.keys()
    assert {board: left[board] for board in left if not serves_page(board)} == {
        board: stamp for board, stamp in stamps.items() if board not in gone["boards"] and not serves_page(board)
    }  # fmt: skip
    script.unlink()
    status, said = without.run_tests(copy, gone, "--tier", "all", "--collect-only")
    assert status == 0, said[-6000:]
    checked = () if name in LOT else ("tests_host/rules", "--deselect", "tests_host/rules/test_additions.py")
    status, said = without.run_tests(copy, gone, "--tier", "check", "-rs", *checked)
    show(f"without {name}", "\n".join(f"{what}: {', '.join(names)}" for what, names in gone.items() if names) + "\n" + said.strip().rpartition("\n")[2])
    assert status == 0, f"seed {SEED}\n" + said[-6000:]


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

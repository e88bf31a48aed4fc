"""Board files with a mistake in them: every value of every shipped file in turn, replaced by others of wrong types and shapes, or taken away;
and the sections of the others put into it.
Each refusal is a BoardError with a sentence."""

import contextlib
import copy
import pprint
from random import Random

import pytest

from host_tools import boards as project
from host_tools.cli.main import main
from host_tools.failure import Failure
from passo.config.board_error import BoardError
from passo.config.boardfile import check

NAMES = project.names()
WRONG = (
    None, True, -1, 0, 3, 2**40, 1.5, float("nan"), "", "x", "x" * 90, " ", "!", "x |", "uart9", b"x", [], [1], [[]], [None], ["x"], [-1, "x"], [2, 2],
    {}, {"x": 1}, {1: 2}, {None: None}, {"x": {}}, {"x": "x"}, {"x": None}, {"masks": 1}, (), (1, 2), {1}, object, "x+",
)  # fmt: skip
GONE = object()
MOST_CHARACTERS = 1500  # of a message


def nested(levels, kind):
    value = 1
    for _ in range(levels):
        value = [value] if kind is list else {"x": value}
    return value


def within_itself():
    value = [1]
    value.append(value)
    return value


SHAPES = (nested(30, list), nested(3000, list), nested(3000, dict), within_itself(), "x" * 100_000)


def places(value, path=()):
    """The paths of all values inside a board file."""
    yield path
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    for key, each in inside:
        yield from places(each, (*path, key))


def broken(board, path, value):
    """Return the board with another value at the path; all beside the path stays."""
    if not path:
        return value
    key, *rest = path
    made = dict(board) if isinstance(board, dict) else list(board)
    if rest:
        made[key] = broken(board[key], rest, value)
    elif value is GONE:
        del made[key]
    else:
        made[key] = value
    return made


def mutants(board):
    for path in places(board):
        for value in WRONG:
            yield path, value
        if path:
            yield path, GONE
    tried = set()
    for name in NAMES:  # and each different section of other boards, once
        for key, value in project.load(name).items():
            if repr((key, value)) in tried:
                continue
            tried.add(repr((key, value)))
            if board.get(key) != value:
                yield (key,), value
            if key not in board:
                for wrong in () if key in tried else WRONG:
                    yield (key,), wrong
                tried.add(key)
                for inside in places(value):
                    if inside:
                        yield (key,), broken(value, inside, GONE)


@pytest.mark.parametrize("name", NAMES)
def test_a_mistake_is_a_board_error(name):
    board = project.load(name)
    before = repr(board)
    found = {}
    refused = 0
    for path, value in mutants(board):
        try:
            check(broken(board, path, value))
        except BoardError as error:
            assert str(error)
            refused += 1
        except Exception as error:
            trace = error.__traceback__
            while trace.tb_next:
                trace = trace.tb_next
            found.setdefault(f"{trace.tb_frame.f_code.co_filename}:{trace.tb_lineno} {type(error).__name__}", (path, value))
    assert not found, found
    assert refused > 500 and repr(board) == before


@pytest.mark.quick
def test_what_no_message_could_show_is_a_board_error():
    """Lists in lists, a list in itself, and texts without end, at every place."""
    board = project.load("router_3axis")
    for path in places(board):
        for shape in SHAPES:
            with pytest.raises(BoardError) as found:
                made = {**board, "inputs": [*board["inputs"]]} if not path else copy.deepcopy(board)
                part = made
                for key in path[:-1]:
                    part = part[key]
                if path:
                    part[path[-1]] = shape
                check(made if path else shape)
            assert len(str(found.value)) < MOST_CHARACTERS


@pytest.mark.parametrize("name", NAMES)
def test_several_mistakes_at_once_are_a_board_error(name):
    """Values of other places and boards, keys renamed, entries twice, in another order or gone, numbers and texts a little off."""
    board = project.load(name)
    random = Random(name)
    whole = [project.load(other) for other in NAMES]
    pool = [value_at(other, path) for other in whole for path in places(other)]
    for _ in range(150):
        made = copy.deepcopy(board)
        for _ in range(random.randint(2, 6)):
            change(made, random, pool)
        with contextlib.suppress(BoardError):
            check(made)


def value_at(board, path):
    for key in path:
        board = board[key]
    return board


def change(board, random, pool):
    """One mistake, somewhere."""
    path = random.choice([path for path in places(board) if path])
    part, key = value_at(board, path[:-1]), path[-1]
    value = part[key]
    if isinstance(part, tuple):
        return
    what = random.randrange(6)
    if what == 0:
        part[key] = copy.deepcopy(random.choice(pool))
    elif what == 1:
        del part[key]
    elif what == 2 and isinstance(part, list):
        part.insert(key, copy.deepcopy(random.choice(part)))
    elif what == 2:
        part[random.choice(("x", "pin", "name", "port", 1, None))] = part.pop(key)
    elif what == 3 and isinstance(part, list):
        random.shuffle(part)
    elif isinstance(value, int):
        part[key] = value + random.choice((-1, 1, -100, 100, 2**16, 2**31, -value, -2 * value))
    elif isinstance(value, str):
        part[key] = random.choice((value + "x", value[:-1], value.upper(), value[::-1], value + " | !", ""))
    else:
        part[key] = copy.deepcopy(random.choice(WRONG))


@pytest.mark.parametrize("verb", ("flash --port /dev/null", "build", "plot FILE", "check FILE", "board", "emulate"))
def test_every_command_says_what_is_wrong_with_a_board_file(verb, tmp_path, capsys, monkeypatch):
    broken = tmp_path / "mine.py"
    broken.write_text('BOARD = {"chip": "rp2040"}\n')
    file = tmp_path / "part.gcode"
    file.write_text("G1X1F100\n")
    monkeypatch.setattr("sys.argv", ["passo", *verb.replace("FILE", str(file)).split(), "--board", str(broken)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 1
    said = capsys.readouterr().err
    assert "mine.py: name: missing" in said and len(said.splitlines()) == 1, said


# --- a board file is data

ROUTER = "BOARD = " + pprint.pformat(project.load("router_3axis"))
RAN = "open('ran', 'w').close()"
CODE = {
    "a statement before": (f"{RAN}\n{ROUTER}\n", 1),
    "a statement behind": (f"# A comment.\n{ROUTER}\n\n{RAN}\n", ROUTER.count("\n") + 4),
    "a call among the values": (ROUTER.replace("'router_3axis'", f"({RAN} or 'router_3axis')"), None),
    "a comprehension": ("BOARD = {name: 1 for name in\n'ab'}\n", 1),
    "arithmetic": ("BOARD = {\n'name': 'mine',\n'clock_mhz': 2 * 100}\n", 3),
    "a name": ("BOARD = {'name':\nname}\n", 2),
    "a text with values in it": ("BOARD = {\n'name': f'{1}'}\n", 2),
    "another board's": ("from boards.router_3axis import BOARD\n", 1),
    "a changed one": (ROUTER + "\nBOARD['name'] = 'mine'\n", ROUTER.count("\n") + 2),
    "a second name": ("OTHER = BOARD = {}\n", 1),
    "another name": ("NUMBER = 3\nBOARD = {}\n", 1),
    "a class": ("class BOARD:\n    pass\n", 1),
}


@pytest.mark.parametrize("kind", CODE)
def test_code_in_a_board_file_is_refused_with_its_line_and_not_run(kind, tmp_path, monkeypatch):
    text, line = CODE[kind]
    (tmp_path / "mine.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(Failure, match=rf"board file mine.py, line {line or '[0-9]+'}: this is code; "):
        project.load("mine.py")
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("verb", ("wiring FILE", "flash --dry-run --board FILE", "build --board FILE", "check part.gcode --board FILE", "board --board FILE",
                                  "interlock FILE", "panel --demo --board FILE", "agent --broker x --virtual m=FILE", "machine add FILE --port /dev/null"))  # fmt: skip
def test_no_command_runs_the_code_of_a_board_file(verb, tmp_path, capsys, monkeypatch):
    (tmp_path / "mine.py").write_text(f"{RAN}\n{ROUTER}\n")
    (tmp_path / "part.gcode").write_text("G1X1F100\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["passo", *verb.replace("FILE", "mine.py").split()])
    with pytest.raises(SystemExit):
        main()
    said = capsys.readouterr().err
    assert "line 1: this is code" in said and len(said.splitlines()) == 1, said
    assert not (tmp_path / "ran").exists()


def test_a_board_file_may_have_comments_and_say_what_it_is(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(f'"""What it is, with a \\d in it."""\n# A comment.\n\n{ROUTER}  # another\n"more"\n')
    assert project.load(str(path)) == project.load("router_3axis")


@pytest.mark.parametrize("text, said", [
    ("", "has no BOARD"), ("BOARD = 3\n", "has no BOARD"), ("# nothing\n", "has no BOARD"), ("BOARD = {\n", r"cannot be read: .*\(line 1\)"),
    ("BOARD = {'a': 1\n'b': 2}\n", r"cannot be read: .*\(line [12]\)"), ("BOARD = {" + "[" * 1000, "cannot be read"), ("BOARD = " + "-" * 100_000 + "1\n", "."),
    ("BOARD = \0{}\n", "cannot be read"), ("BOARD = {[1]: 2}\n", "this is code"),
])  # fmt: skip
def test_a_board_file_that_cannot_be_read_is_one_sentence(text, said, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(text)
    with pytest.raises(Failure, match=rf"^board file {path}.*{said}"):
        project.load(str(path))


def test_a_board_file_that_is_no_text_is_one_sentence(tmp_path):
    path = tmp_path / "mine.py"
    path.write_bytes(b"# caf\xe9\nBOARD = {}\n")
    with pytest.raises(Failure, match="cannot be read"):
        project.load(str(path))


def test_half_a_character_is_shown_by_its_number():
    assert Failure("{}: unknown key {}", "my\ud800.py", "\udfff").message() == "my\\ud800.py: unknown key \\udfff"


@pytest.mark.parametrize("key, wanted", [("encoder", "encoders"), ("gantri", "gantry"), ("axis", "axes"), ("Tool", "tool"), ("inter_lock", "interlock"), ("qqq", None)])
def test_an_unknown_key_comes_with_the_nearest_name(key, wanted):
    with pytest.raises(BoardError) as refused:
        check({**project.load("plotter_2014"), key: {}})
    said = str(refused.value)
    assert f"unknown key '{key}'" in said and ("nearest" in said) == (wanted is not None) and (wanted is None or f"nearest is '{wanted}'" in said)

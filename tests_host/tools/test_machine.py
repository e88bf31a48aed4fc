"""`passo machine` on a board that stands behind a pty: stored, chosen, with the settings of each."""

import os
import shutil
import time
from functools import partial
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from host_tools import boards
from host_tools.build.frozen import stamp
from host_tools.cli import flash, machine
from host_tools.cli.main import app
from host_tools.failure import Failure
from passo.protocols.plotter.host import COMMANDS, packet
from passo.protocols.torch import protocol as torch
from test_board_command import Board as VirtualBoard
from test_flash import board, folder, put, put_drives, wait_for  # noqa: F401  fixtures
from test_flash_uf2 import IMAGE


@pytest.fixture
def small(tmp_path, monkeypatch):
    firmware = tmp_path / "firmware"
    for name in ("main.py", "passo/__init__.py", "passo/app.py", "passo/protocols/__init__.py", "passo/protocols/pulses/__init__.py",
                 "passo/protocols/plotter/__init__.py", "passo/protocols/grbl/__init__.py"):  # fmt: skip
        put(firmware, name, "x = 1\n")
    put_drives(firmware)
    monkeypatch.setattr(machine, "build_tree", partial(machine.build_tree, firmware=firmware))
    monkeypatch.setattr(machine, "_check_at_rest", lambda port: None)
    return firmware


def passo(*words):
    result = CliRunner().invoke(app, ["machine", *words])
    if isinstance(result.exception, Failure):
        return str(result.exception)
    assert result.exception is None, (result.exception, result.output)
    return result.output


def test_two_machines_on_a_board(folder, board, small):  # noqa: F811
    port, files = board
    where = ("--port", port)
    assert "passo flash first" in passo("add", "lpt_router", *where)
    put(files, "board.py", 'BOARD = {"chip": "rp2040", "name": "plotter_2014"}')
    put(files, "settings.0", "of the plotter")
    assert "no machine is stored" in passo("list", *where)
    assert passo("add", "lpt_router", *where).startswith("lpt_router is stored")
    assert passo("add", "plotter_2014", *where).startswith("plotter_2014 is stored")
    assert (files / "settings.0").read_text() == "of the plotter" and "plotter_2014" in (files / "board.py").read_text()
    assert [line.split() for line in passo("list", *where).splitlines()] == [["lpt_router", "ready"], ["plotter_2014", "ready"]]

    assert "starts with it" in passo("choose", "lpt_router", *where)
    assert wait_for(files / ".reset") and '"name": "lpt_router"' in (files / "board.py").read_text()
    assert not (files / "settings.0").exists()
    assert (files / "machines/before/settings.0").read_text() == "of the plotter"
    assert [line.split()[:2] for line in passo("list", *where).splitlines()] == [["before", "ready"], ["*", "lpt_router"], ["plotter_2014", "ready"]]
    put(files, "settings.1", "of the router")
    passo("choose", "plotter_2014", *where)
    assert not (files / "settings.1").exists() and '"name": "plotter_2014"' in (files / "board.py").read_text()
    passo("choose", "lpt_router", *where)
    passo("choose", "lpt_router", *where)
    assert (files / "settings.1").read_text() == "of the router"


def test_what_was_before_comes_back(folder, board, small):  # noqa: F811
    """The files flashed first, and a machine whose board file was changed, each with its settings."""
    port, files = board
    where = ("--port", port)
    flashed = 'BOARD = {"chip": "rp2040", "name": "flashed"}'
    put(files, "board.py", flashed)
    put(files, "main.py", "flashed")
    put(files, "settings.0", "of then")
    own = folder / "mine.py"
    own.write_text('BOARD = {"name": "mine", "like": "lpt_router"}  # mine\n')
    assert "no machine was chosen before" in passo("back", *where)
    passo("add", str(own), *where)
    passo("choose", "mine", *where)
    assert "before is chosen" in passo("back", *where)
    assert (files / "board.py").read_text() == flashed and (files / "main.py").read_text() == "flashed" and (files / "settings.0").read_text() == "of then"
    assert "mine is chosen" in passo("back", *where)
    assert "is the chosen one" in passo("remove", "mine", *where)
    assert passo("remove", "before", *where) == "before is removed\n"
    put(files, "settings.0", "calibrated")
    said = passo("set", str(own), "step_program.interval_us=250", *where)
    assert said.endswith(f"passo machine back --port {port} returns to what it was\n")
    assert "250" in (files / "board.py").read_text() and (files / "settings.0").read_text() == "calibrated"
    assert own.with_name("mine.py.old").read_text() == 'BOARD = {"name": "mine", "like": "lpt_router"}  # mine\n' and own.read_text().endswith("# mine\n")
    put(files, "settings.0", "newer")
    assert "mine_old is chosen" in passo("back", *where)
    assert "250" not in (files / "board.py").read_text() and (files / "settings.0").read_text() == "calibrated"
    passo("choose", "mine", *where)
    assert "250" in (files / "board.py").read_text() and (files / "settings.0").read_text() == "newer"


def test_board_files_are_written_and_changed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert passo("new", "mine", "--like", "lpt_router", "step_program.interval_us=250") == "mine.py is written\n"
    made = boards.load("mine.py")
    assert made["name"] == "mine" and made["step_program"] == {**boards.load("lpt_router")["step_program"], "interval_us": 250}
    assert passo("set", "mine.py", "axes.x.steps_per_m=81250", "idle_release_ms=9000") == "mine.py is written\n"
    assert boards.load("mine.py")["axes"][0]["steps_per_m"] == 81250 and boards.load("mine.py")["axes"][1] == made["axes"][1]
    assert "81250" not in (tmp_path / "mine.py.old").read_text()
    text = (tmp_path / "mine.py").read_bytes()
    for words, wrong in ((("set", "mine.py", "step_program.interval_us=0"), "interval_us"), (("set", "mine.py", "axis.x=3"), "axis"), (("set", "mine.py", "speed"), "is not KEY=VALUE"),
                         (("set", "lpt_router", "a=3"), "one of Passo's own"), (("set", str(boards.path("lpt_router")), "a=3"), "one of Passo's own"), (("set", "none.py", "a=3"), "is no board file here"),
                         (("new", "mine", "--like", "lpt_router"), "exists"), (("new", "other", "--like", "nothing"), "unknown board 'nothing'")):  # fmt: skip
        assert wrong in passo(*words), words
    assert (tmp_path / "mine.py").read_bytes() == text and sorted(path.name for path in tmp_path.iterdir()) == ["mine.py", "mine.py.old"]


def test_what_the_board_would_not_start_with_is_not_written(tmp_path, monkeypatch):
    """Pulses too long for the speeds, and speeds too high for the pulses."""
    monkeypatch.chdir(tmp_path)
    for like, pair, wrong in (
        ("router_3axis", "drive.pulse_us=100", "speed: steps every 480 ticks of 80 ns; the drive needs 2500"),
        ("router_3axis", "axes.x.steps_per_m=2000001", "axis x: 2000001 steps/m at 5000 mm/min make 166666 steps/s; pulses of this drive leave room for 164473"),
        ("lpt_router", "step_program.interval_us=19", "a pulse of 10 µs, and as long without it, take more than 19 µs"),
    ):  # fmt: skip
        assert wrong in passo("new", "mine", "--like", like, pair)
    assert not list(tmp_path.iterdir())
    assert passo("new", "mine", "--like", "lpt_router", "step_program.interval_us=20") == "mine.py is written\n"


@pytest.mark.parametrize("name", ["mine.py.old", "mine.py.new"])
def test_links_that_lie_in_the_way_are_not_followed(tmp_path, monkeypatch, name):
    """In a folder of others FILE.old may be a link to any file: that one stays as it is."""
    monkeypatch.chdir(tmp_path)
    passo("new", "mine", "--like", "lpt_router")
    before = (tmp_path / "mine.py").read_text()
    precious = tmp_path / "precious"
    precious.write_text("mine alone")
    (tmp_path / name).symlink_to(precious)
    assert passo("set", "mine.py", "idle_release_ms=9000") == "mine.py is written\n"
    assert precious.read_text() == "mine alone" and (tmp_path / "mine.py.old").read_text() == before and boards.load("mine.py")["idle_release_ms"] == 9000


def test_a_file_that_cannot_be_written_stays(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    passo("new", "mine", "--like", "lpt_router")
    before = (tmp_path / "mine.py").read_text()
    (tmp_path / "mine.py.old").mkdir()
    with pytest.raises(AssertionError, match="IsADirectoryError"):  # which passo tells in a sentence
        passo("set", "mine.py", "idle_release_ms=9000")
    assert (tmp_path / "mine.py").read_text() == before and sorted(path.name for path in tmp_path.iterdir()) == ["mine.py", "mine.py.old"]


def test_with_passos_uf2_only_board_files_are_stored(folder, board, monkeypatch):  # noqa: F811
    """Of machines that its chip's UF2 serves; nothing is built."""
    monkeypatch.setattr(machine, "_check_at_rest", lambda port: None)
    monkeypatch.setattr(machine, "build_tree", None)
    port, files = board
    where = ("--port", port)
    put(files, "passo_image.py", IMAGE % stamp("rp2040"))
    put(files, "board.py", 'BOARD = {"chip": "rp2040", "name": "x"}')
    put(files, "settings.0", "of x")
    assert passo("add", "lpt_router", *where).startswith("lpt_router is stored")
    assert not (files / "passo").exists() and (files / "machines/lpt_router/board.py").read_bytes() == boards.path("lpt_router").read_bytes()
    assert [line.split() for line in passo("list", *where).splitlines()] == [["lpt_router", "ready"]]
    assert "starts with it" in passo("choose", "lpt_router", *where)
    assert '"name": "lpt_router"' in (files / "board.py").read_text() and (files / "machines/before/settings.0").read_text() == "of x"
    assert "the board has Passo's UF2 for the rp2040, and router_pico_w wants that for the rp2040_w" in passo("add", "router_pico_w", *where)


def test_what_is_not_chosen(folder, board, small):  # noqa: F811
    port, files = board
    where = ("--port", port)
    put(files, "board.py", 'BOARD = {"chip": "rp2040", "name": "x"}')
    passo("add", "lpt_router", *where)
    assert "there is no machine plotter" in passo("choose", "plotter", *where)
    assert "is no name" in passo("choose", "../x", *where)
    assert "is an rp2040" in passo("add", "mks_dlc32", *where)
    for name in ("files", "chosen", "mine_old", "a" * 33):
        assert "is no name for a machine" in passo("add", f"boards/{name}.py", *where)
    next((files / "machines/files").iterdir()).unlink()
    assert "1 files of its firmware are missing or of another version" in passo("list", *where)
    said = passo("choose", "lpt_router", *where)
    assert "add it again" in said and '"name": "x"' in (files / "board.py").read_text()
    assert passo("add", "lpt_router", *where).startswith("lpt_router is stored")
    assert "starts with it" in passo("choose", "lpt_router", *where)
    assert "there is no port" in passo("list", "--port", "/dev/no/port")


class Cut(Exception):
    """The power fails."""


class Board:
    """Machines.py in a folder of its own; each of its orders to the file system may be the last."""

    def __init__(self, folder):
        self.folder = folder
        self.left = self.changes = 0
        names = ("listdir", "stat", "mkdir", "remove", "rename")
        self._os = SimpleNamespace(**{name: partial(self._order, name, getattr(os, name)) for name in names})

    def _order(self, name, call, *paths):
        if name in ("mkdir", "remove", "rename"):
            self._count()
        return call(*[self.folder / path for path in paths])

    def _count(self):
        if self.changes == self.left:
            raise Cut
        self.changes += 1

    def _open(self, path, mode="r"):
        if "w" in mode:
            self._count()
        return open(self.folder / path, mode)

    def run(self, call, left=-1):
        self.left, self.changes = left, 0
        text = machine._ON_BOARD.read_text(encoding="utf-8").replace("import os\n", "")
        printed = []
        exec(text + call, {"os": self._os, "open": self._open, "print": lambda *words: printed.append(" ".join(map(str, words)))})
        return printed

    def whole(self):
        """Which machine would start, of the two; None: none, there is no board file."""
        found = {(self.folder / path).read_text() for path in ("main.py", "passo/app.mpy", "passo/a.mpy") if (self.folder / path).exists()}
        if not (self.folder / "board.py").exists():
            return None
        assert len(found) == 1, "a mixture"
        name = found.pop()
        assert name in (self.folder / "board.py").read_text(), "the firmware of another machine"
        settings = self.folder / "settings.0"
        assert settings.read_text() == name, "the settings of another machine"
        return name


def of_two_machines(folder):
    """A board with the machines x, which runs, and y, whose files have to be moved to run."""
    made = Board(folder)
    for name in "xy":
        modules = ""
        for path in ("main.py", "passo/app.mpy", "passo/a.mpy"):
            digest = machine._file_digest(path, name.encode())
            modules += f"{path} {digest}\n"
            put(folder, path if name == "x" else f"machines/files/{digest}", name)
        put(folder, "passo/same.mpy", "same")
        modules += f"passo/same.mpy {machine._file_digest('passo/same.mpy', b'same')}\n"
        put(folder, f"machines/{name}/modules.txt", modules)
        put(folder, f"machines/{name}/board.py", f'BOARD = {{"chip": "{name}"}}')
    put(folder, "board.py", 'BOARD = {"chip": "x"}')
    put(folder, "settings.0", "x")
    put(folder, "machines/y/settings.0", "y")
    return made


def test_no_cut_of_the_power_makes_a_mixture(tmp_path):
    """Amid each step of `choose`: either the old machine starts, or none, and the same call or one for the other machine goes on."""
    done, count = False, 0
    while not done:
        for then in "xy":
            board = of_two_machines(tmp_path / f"{count}{then}")
            try:
                board.run("choose_machine('y')", count)
                done = True
            except Cut:
                assert board.whole() in (None, "x")
            board.run(f"choose_machine('{then}')")
            assert board.whole() == then
            board.run("choose_machine('x')")
            board.run("choose_machine('y')")
            assert board.whole() == "y"
        count += 1
    assert count > 8


def test_no_cut_of_the_power_loses_what_was_before(tmp_path):
    """Amid each step of the first `choose` of a board that was only flashed, and of the way back."""
    for calls in (["choose_machine('y')"], ["choose_machine('y')", "choose_last()"]):
        done, count = False, 0
        while not done:
            board = of_two_machines(tmp_path / f"{len(calls)}{count}")
            shutil.rmtree(board.folder / "machines/x")
            for call in calls[:-1]:
                board.run(call)
            try:
                board.run(calls[-1], count)
                done = True
            except Cut:
                assert board.whole() in (None, "x" if len(calls) == 1 else "y")
                board.run(calls[-1])
            assert board.whole() == ("y" if len(calls) == 1 else "x")
            board.run("choose_last()")
            assert board.whole() == ("x" if len(calls) == 1 else "y")
            count += 1
        assert count > 10


def test_what_a_board_asks_for(tmp_path):
    board = of_two_machines(tmp_path)
    known = (tmp_path / "machines/y/modules.txt").read_text()
    new = machine._file_digest("passo/a.mpy", b"new")
    assert board.run(f"print_missing({known!r})") == [] and board.run(f"print_missing({f'passo/a.mpy {new}'!r})") == [f"wants {new}"]
    assert [line for line in board.run("print_machines()") if line.startswith("machine")] == ["machine x: ready", "machine y: ready"]
    put(tmp_path, "machines/files/0123456789abcdef", "of nobody")
    board.run("remove_unused()")
    assert not (tmp_path / "machines/files/0123456789abcdef").exists() and len(list((tmp_path / "machines/files").iterdir())) == 3
    put(tmp_path, "passo/app.mpy", "newer")
    assert [line for line in board.run("print_machines()") if line.startswith("machine")] == ["machine x: 1 files of its firmware are missing or of another version: add it again", "machine y: ready"]


def test_a_moving_machine_stays_as_it_is():
    from host_tools.clients.grbl import GrblClient
    from running_router import Running

    with Running("real") as running:
        with GrblClient(running.line.name) as client:
            client.connect()
            client.command("$X")
            client.command("G1X200F600")
        with pytest.raises(Failure, match="not at rest: Run"):
            machine._check_at_rest(running.line.name)


def test_what_becomes_another_machine_and_what_fails(folder, board, small):  # noqa: F811
    port, files = board
    put(files, "board.py", 'BOARD = {"chip": "rp2040", "name": "x"}')
    with pytest.raises(Failure, match="is an rp2040, and mks_dlc32 is for an esp32"):
        machine.become_machine("mks_dlc32", port)
    assert wait_for(files / ".reset") and '"name": "x"' in (files / "board.py").read_text(), "it starts as what it was"
    (files / ".reset").unlink()
    machine.become_machine("lpt_router", port)
    assert wait_for(files / ".reset") and '"name": "lpt_router"' in (files / "board.py").read_text()
    assert (files / "machines/chosen").read_text() == "lpt_router\nbefore" and not list(folder.glob("build"))


def test_a_pc_without_mpremote(folder, monkeypatch):  # noqa: F811
    monkeypatch.setattr(flash, "find_spec", lambda name: None)
    with pytest.raises(Failure, match="pip install mpremote"):
        machine.become_machine("lpt_router", "/dev/null")


MOVING = {
    "router_3axis": b"$X\nG91G1X50F600\n",
    "torch_manipulator": torch.frame("CONNECT") + torch.move(4000, 400, 0, 1),
    "lpt_router": b"{load}" + b"A" * 3000 + b"{end}{run}",
    "plotter_2014": packet(COMMANDS["ORIGIN"]),
}


@pytest.mark.parametrize("name", MOVING)
def test_a_machine_that_moves_is_not_stopped_for_another(name):
    """Whatever language it speaks: its board is not asked for its prompt, which would stop it."""
    with VirtualBoard("--board", name) as running:
        machine._check_at_rest(running.port)
        with open(os.open(running.port, os.O_WRONLY | os.O_NOCTTY), "wb", buffering=0) as line:
            line.write(MOVING[name])
        time.sleep(1)
        with pytest.raises(Failure, match="is not at rest: (?i:run|home)"):
            machine._check_at_rest(running.port)
        assert running.end()[0] == 0

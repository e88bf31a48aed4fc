"""`passo machine` on a board that stands behind a pty: stored, chosen, with the settings of each."""

from functools import partial

import pytest
from typer.testing import CliRunner

from host_tools import boards
from host_tools.build.frozen import stamp
from host_tools.cli import flash, machine
from host_tools.cli.main import app
from host_tools.failure import Failure
from test_flash import board, folder, put, wait_for  # noqa: F401  fixtures
from test_flash_uf2 import IMAGE


@pytest.fixture
def small(tmp_path, monkeypatch):
    firmware = tmp_path / "firmware"
    for name in ("main.py", "passo/__init__.py", "passo/app.py", "passo/protocols/__init__.py", "passo/protocols/pulses/__init__.py",
                 "passo/protocols/plotter/__init__.py", "passo/protocols/grbl/__init__.py"):  # fmt: skip
        put(firmware, name, "x = 1\n")
    monkeypatch.setattr(machine, "build_tree", partial(machine.build_tree, firmware=firmware))
    monkeypatch.setattr(machine, "_at_rest", lambda port: None)
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
    assert passo("list", *where).startswith("* lpt_router")
    put(files, "settings.1", "of the router")
    passo("choose", "plotter_2014", *where)
    assert not (files / "settings.1").exists() and '"name": "plotter_2014"' in (files / "board.py").read_text()
    passo("choose", "lpt_router", *where)
    passo("choose", "lpt_router", *where)
    assert (files / "settings.1").read_text() == "of the router"


def test_with_passos_uf2_only_board_files_are_stored(folder, board, monkeypatch):  # noqa: F811
    """Of machines that its chip's UF2 serves; nothing is built."""
    monkeypatch.setattr(machine, "_at_rest", lambda port: None)
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
    (files / "passo/__init__.mpy").write_bytes(b"of another version")
    assert "1 files of its firmware are missing or of another version" in passo("list", *where)
    said = passo("choose", "lpt_router", *where)
    assert "add it again" in said and '"name": "x"' in (files / "board.py").read_text()
    assert passo("add", "lpt_router", *where).startswith("lpt_router is stored")
    assert "starts with it" in passo("choose", "lpt_router", *where)
    assert "there is no port" in passo("list", "--port", "/dev/no/port")


def test_a_moving_machine_stays_as_it_is():
    from host_tools.clients.grbl import GrblClient
    from running_router import Running

    running = Running("real")
    try:
        with GrblClient(running.line.name) as client:
            client.connect()
            client.command("$X")
            client.command("G1X200F600")
        with pytest.raises(Failure, match="not at rest: Run"):
            machine._at_rest(running.line.name)
    finally:
        running.close()


def test_what_becomes_another_machine_and_what_fails(folder, board, small):  # noqa: F811
    port, files = board
    put(files, "board.py", 'BOARD = {"chip": "rp2040", "name": "x"}')
    with pytest.raises(Failure, match="is an rp2040, and mks_dlc32 is for an esp32"):
        machine.become("mks_dlc32", port)
    assert wait_for(files / ".reset") and '"name": "x"' in (files / "board.py").read_text(), "it starts as what it was"
    (files / ".reset").unlink()
    machine.become("lpt_router", port)
    assert wait_for(files / ".reset") and '"name": "lpt_router"' in (files / "board.py").read_text()
    assert (files / "machines/chosen").read_text() == "lpt_router" and not list(folder.glob("build"))


def test_a_pc_without_mpremote(folder, monkeypatch):  # noqa: F811
    monkeypatch.setattr(flash, "find_spec", lambda name: None)
    with pytest.raises(Failure, match="pip install mpremote"):
        machine.become("lpt_router", "/dev/null")

"""A machine on trial on the emulated Pico: one whose board file does not start gives way to the one of before, and so does one at whose start
the input `previous` is held."""

import pytest
from emulated import uf2  # noqa: F401

from host_tools import boards
from host_tools.build.machines import __file__ as MACHINES
from host_tools.emulator.machine import firmware_files
from host_tools.emulator.pico import EmulatedPico

GOOD = "plotter_2014"
PREVIOUS = 22
pytestmark = pytest.mark.slow


def with_two_machines(board):
    """The files of a board that has just chosen the machine `bad`, after `good`, which is GOOD."""
    files = dict(firmware_files(GOOD))
    good = files["board.py"]
    with open(MACHINES, "rb") as file:
        files["machines/machines.py"] = file.read()
    files["machines/chosen"] = b"bad\ngood\n"
    for name, text in (("bad", board), ("good", good)):
        files[f"machines/{name}/board.py"] = text
        files[f"machines/{name}/modules.txt"] = b""
        files[f"machines/{name}/settings.0"] = name.encode()
    del files["machines/bad/settings.0"]
    files.update({"board.py": board, "board.trial": b"new", "settings.0": b"of bad"})
    return files, good


def written(change):
    board = boards.load(GOOD)
    change(board)
    return f"BOARD = {board!r}\n".encode()


@pytest.mark.parametrize("text", [b"BOARD = {\n", written(lambda board: board.update(color=1)), written(lambda board: board["links"][0].update(protocol="esperanto"))])
def test_a_board_file_that_does_not_start_gives_way(uf2, text, show):  # noqa: F811
    files, good = with_two_machines(text)
    pico = EmulatedPico(files=files, uf2=uf2)
    driven = [pico.edges(gpio) for gpio in range(2, 10)]
    pico.boot()
    begun = pico.now_us
    for _ in range(2):
        pico.await_reset(8_000_000)
    took_s = (pico.now_us - begun) / 1e6
    kept = pico.files()
    assert kept["board.py"] == good and "board.trial" not in kept and kept["machines/chosen"] == b"good\nbad"
    assert kept["settings.0"] == b"good" and kept["machines/bad/settings.0"] == b"of bad"
    assert kept["crash.txt"].startswith(b"machine bad: ") and kept["crash.txt"].endswith(b"; good is chosen again\n")
    assert not any(state == 1 for edges in driven for _, state in edges), "no coil is ever on"
    wire = pico.uart(0)
    wire.feed(b"r\0\0\0\0r", 57_600)
    pico.run(3_000_000)
    wire.feed(b"r\0\0\0\0r", 57_600)
    pico.run(100_000)
    assert b"k" in wire.drain()
    show("a machine that does not start gives way", f"{took_s:.1f} s; {kept['crash.txt'].decode().strip()}")


def test_one_that_runs_is_on_trial_no_longer(uf2):  # noqa: F811
    files, _ = with_two_machines(written(lambda board: board.update(name="other")))
    pico = EmulatedPico(files=files, uf2=uf2).boot()
    pico.run(4_000_000)
    assert "board.trial" not in pico.files() and b"other" in pico.files()["board.py"]
    pico.hard_reset()
    pico.run(4_000_000)
    assert b"other" in pico.files()["board.py"]


def test_an_input_held_at_the_start_brings_the_one_of_before(uf2):  # noqa: F811
    files, good = with_two_machines(written(lambda board: board["inputs"].append({"name": "previous", "pin": PREVIOUS, "active": 0})))
    del files["board.trial"]
    pico = EmulatedPico(files=files, uf2=uf2)
    pico.drive(PREVIOUS, 0)
    pico.boot()
    pico.run(3_000_000)
    assert b"previous" in pico.files()["board.py"], "it waits for the release"
    pico.drive(PREVIOUS, None)
    for _ in range(2):
        pico.await_reset(8_000_000)
    assert pico.files()["board.py"] == good and "input previous was active" in pico.files()["crash.txt"].decode()
    pico.run(4_000_000)
    assert pico.files()["board.py"] == good and "last_crash.txt" in pico.files()

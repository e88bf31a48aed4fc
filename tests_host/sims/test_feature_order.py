"""The order of FEATURES (machine_builder.py) means nothing: answers and motion are the same in any."""

import random

import pytest

from host_tools import boards
from host_tools.cli import jobs
from host_tools.clients.grbl import GrblClient
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.radio import LoopbackRadio
from passo import machine_builder
from running_router import Running

# The bytes sent, and the milliseconds before the next.
ORDERS = (
    (b"$X\n", 300), (b"G91G1X5F600\nG2X5Y5I5\nM3S500\nM8\nG1X3\n", 700), (b"?", 50), (b"!", 300), (b"?", 50), (b"\xa0", 50), (b"~", 900),
    (b"$J=G91X5F500\n", 200), (b"\x85", 300), (b"?", 20), (b"G1X20F900\n", 400), (b"\x84", 300), (b"?", 20), (b"~", 600), (b"\x18", 300),
    (b"?", 20), (b"$X\nG38.2Z-3F100\nG4P.2\nG1X1F300\n", 1500), (b"?\x91\x91", 20), (b"$LINK\n$LINK=2\nG1X1\n", 100), (b"$LINK=1\n", 100),
    (b"$LINK=4\n", 100), (b"$H\n", 9000), (b"?", 20), (b"G90G0X9999\n", 500), (b"?$X\n", 300), (b"$LOG\n$I\n", 100),
)  # fmt: skip


def board_of(name):
    board = {**boards.load(name)}
    if board.get("network"):
        board["network"] = {**board["network"], "presence": board["inputs"][0]["name"]}
    return board


def carried_out(name, order):
    """Answers and end of a machine whose features stand in this order."""
    machine_builder.FEATURES = tuple(order)
    board = board_of(name)
    radio = LoopbackRadio({"http": 0}, "ABCDEFGHJKLMNPQR", board) if board.get("network") else None
    machine = VirtualMachine(board, trace=None, radio=radio)
    said = b""
    for data, ms in ORDERS:
        machine.send(data)
        machine.run_ms(ms)
        said += machine.take()
    machine.close()
    return said, machine.plant.position


@pytest.mark.parametrize("name", ["router_3axis", "mill_2004", "router_pico_w"])
def test_any_order_of_features_is_as_good(name, monkeypatch):
    features = machine_builder.FEATURES
    monkeypatch.setattr(machine_builder, "FEATURES", features)  # put back at the end
    wanted = carried_out(name, features)
    assert b"<Hold" in wanted[0] and b"ALARM" in wanted[0] and b"Door" in wanted[0] and any(wanted[1])
    shuffled = random.Random(1).sample(features, len(features))
    for order in (features[::-1], shuffled):
        assert carried_out(name, order) == wanted


def journal_after_a_stored_job(folder, order):
    """Return the journal's line for a job that the board has run to its end."""
    machine_builder.FEATURES = tuple(order)
    folder.mkdir()
    (folder / "part.gcode").write_text("G21 G91\nG1 X2 F3000\nG1 X-2\n")
    board = Running("fast", jobs={"language": "grbl", "folder": str(folder / "flash")}, journal={"every_ms": 200})
    try:
        jobs.store(folder / "part.gcode", "PART", "grbl", check=False, port=board.line.name)
        jobs.run("PART", True, True, board.line.name, 115200)
        with GrblClient(board.line.name) as client:
            client.connect()
            return client.command("$JR")
    finally:
        board.close()


def test_a_stored_job_ends_in_any_order(tmp_path, monkeypatch):
    features = machine_builder.FEATURES
    monkeypatch.setattr(machine_builder, "FEATURES", features)  # put back at the end
    for number, order in enumerate((features, features[::-1])):
        assert journal_after_a_stored_job(tmp_path / str(number), order) == ["[JOURNAL:00000000|0|3|0,0,0]"]

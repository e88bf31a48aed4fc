"""The trace CSV and the VCD file: their format to the letter, and that they agree with the plant."""

import time

import pytest
from vcd.reader import TokenKind, tokenize

from host_tools import boards
from host_tools.cli import run
from host_tools.clients.plotter import PlotterClient
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.plant import Plant
from host_tools.sim.trace import BATCH_ROWS, HEADER, Trace

MS = 12_500


def packet(letter, x=0, y=0):
    body = bytes([ord(letter), x >> 8, x & 255, y >> 8, y & 255])
    return body + bytes([sum(body) & 255])


def plant_at(*start):
    return Plant(boards.load("plotter_2014"), start=start)


def test_format(tmp_path):
    path = tmp_path / "t.csv"
    trace = Trace(path, plant_at(100, 50))
    trace.add_row(1, [101, 50], 0)
    trace.add_row(15275, [101, 49], 0)
    trace.add_row(12_500_000 * 3600 + 1, [100, 49], 1000)
    trace.close()
    assert path.read_bytes().decode("ascii").split("\n") == [
        "t_us,x,y,z,a,tool",
        "0.000,0,0,0,0,0",
        "0.080,1,0,0,0,0",
        "1222.000,1,-1,0,0,0",
        "3600000000.080,0,-1,0,0,1000",
        "",
    ]


def test_columns_by_name_or_order(tmp_path):
    board = boards.load("plotter_2014")
    for names, row in (("xz", "1,0,2,0"), ("yx", "1,2,0,0"), ("uv", "1,2,0,0"), ("za", "0,0,1,2")):
        axes = [dict(axis, name=name) for axis, name in zip(board["axes"], names)]
        plant = Plant(dict(board, axes=axes, homing=None), start=(0, 0))
        trace = Trace(tmp_path / "t.csv", plant)
        trace.add_row(0, [1, 2], 0)
        trace.close()
        assert (tmp_path / "t.csv").read_text().splitlines()[-1] == f"0.000,{row},0"


@pytest.mark.parametrize("flushed", (False, True))
def test_one_zero_for_the_whole_file(tmp_path, flushed):
    path = tmp_path / "t.csv"
    trace = Trace(path, plant_at(100, 50))
    trace.add_row(100, [99, 50], 0)
    if flushed:
        trace.flush()
    trace.rezero([1, -2])
    trace.add_row(200, [1, -1], 0)
    trace.flush()
    assert path.read_text().splitlines()[1:] == ["0.000,99,52,0,0,0", "8.000,98,52,0,0,0", "16.000,0,1,0,0,0"]
    trace.rezero([1, -2])
    trace.rezero([0, 0])
    trace.close()
    assert path.read_text().splitlines() == [
        HEADER,
        "0.000,100,50,0,0,0",
        "8.000,99,50,0,0,0",
        "16.000,1,-1,0,0,0",
    ]
    assert list(tmp_path.iterdir()) == [path]


def test_long_traces_are_written_as_they_go(tmp_path):
    path = tmp_path / "t.csv"
    trace = Trace(path, plant_at(0, 0))
    for i in range(3 * BATCH_ROWS):
        trace.add_row(i, [i, 0], 0)
    assert len(path.read_text().splitlines()) > 2 * BATCH_ROWS
    trace.close()
    lines = path.read_text().splitlines()
    assert len(lines) == 3 * BATCH_ROWS + 2 and lines[-1] == f"{(3 * BATCH_ROWS - 1) * 0.08:.3f},24575,0,0,0,0"


def test_rows_in_memory():
    trace = Trace(None, plant_at(10, 20))
    trace.add_row(25, [11, 20], 1000)
    trace.flush()
    trace.rezero([11, 18])
    trace.close()
    assert trace.rows() == [(0.0, -1, 2, 0, 0, 0), (2.0, 0, 2, 0, 0, 1000)]


def test_a_homed_machine_traces_from_its_origin(tmp_path):
    path = tmp_path / "t.csv"
    machine = VirtualMachine(start=(300, 200), bounce_ms=3, trace=path)
    assert machine.ask(packet("o")) == b"o"
    for letter, x, y in (("m", 20, 10), ("l", 25, 10), ("l", 25, 13)):
        assert machine.ask(packet(letter, x, y)) == b"n"
    assert machine.ask(packet("e")) == b"d"
    machine.settle()
    machine.close()
    rows = [[float(field) for field in line.split(",")] for line in path.read_text().splitlines()[1:]]
    homed = [row[1:3] for row in rows].index([0, 0], len(rows) - 40)
    assert rows[0][0] == 0 and rows[0][3:] == [0, 0, 0]
    assert [row[0] for row in rows] == sorted(row[0] for row in rows)
    drawn = [row[1:] for row in rows[homed:]]
    assert drawn[20] == [20, 10, 0, 0, 0] and drawn[21] == [20, 10, 0, 0, 1000]
    assert drawn[22:] == (
        [[x, 10, 0, 0, 1000] for x in range(21, 26)]
        + [[25, y, 0, 0, 1000] for y in (11, 12, 13)]
        + [[25, 13, 0, 0, 0]]
    )
    # Pen down and up each take the solenoid's 60 ms.
    arrived, first = rows[homed + 21][0], rows[homed + 22][0]
    assert arrived - rows[homed + 20][0] >= 60_000 and first >= arrived
    assert machine.plant.errors == []


def test_vcd_reads_back(tmp_path):
    path = tmp_path / "t.vcd"
    board = dict(boards.load("plotter_2014"))
    board["drive"] = {"kind": "step_dir", "pulse_us": 3, "step_active": 0}
    board["axes"] = [dict(axis, pins=[2 + i, 4 + i]) for i, axis in enumerate(board["axes"])]
    board["tool"]["pin"] = 6
    board["outputs"] = [{"name": "enable", "pin": 20, "active": 0}]
    machine = VirtualMachine(board, start=(30, 20), bounce_ms=2, vcd=path)
    assert machine.ask(packet("o")) == b"o"
    machine.close()
    names, changes, now = {}, [], 0
    with open(path, "rb") as file:
        for token in tokenize(file):
            if token.kind is TokenKind.TIMESCALE:
                assert (int(token.data.magnitude), token.data.unit.value) == (1, "ns")
            elif token.kind is TokenKind.VAR:
                names[token.data.id_code] = token.data.reference
            elif token.kind is TokenKind.CHANGE_TIME:
                now = token.data
            elif token.kind is TokenKind.CHANGE_SCALAR:
                changes.append((now, names[token.data.id_code], token.data.value))
    assert set(names.values()) == {
        "x_step", "y_step", "x_dir", "y_dir", "tool", "enable", "barrier_x", "barrier_y"
    }  # fmt: skip
    # Steps read off the file move the machine exactly as far as the plant says, with the pulse asked for.
    for i, axis in enumerate("xy"):
        place, direction, fell = (30, 20)[i], 0, 0
        for time, name, value in changes:
            if name == f"{axis}_dir":
                direction = int(value)
            elif name == f"{axis}_step" and value == "0" and time:
                place += 1 if direction else -1
                fell = time
            elif name == f"{axis}_step" and fell:
                assert time - fell == 38 * 80  # the whole ticks in 3 µs
        assert place == machine.plant.position[i]
    barrier = [value for _, name, value in changes if name == "barrier_x"]
    assert barrier[0] == "0" and barrier[-1] == "0" and len(barrier) > 4
    assert [value for _, name, value in changes if name == "enable"][-1] == "1"
    times = [time for time, _, _ in changes]
    assert times == sorted(times)
    assert machine.plant.errors == []


SIDES = [(False, 200, 100), (True, 260, 100), (True, 230, 150), (True, 200, 100)]


@pytest.mark.parametrize("sleeps_s", [pytest.param((0.0, 0.0), marks=pytest.mark.slow), (0.0137, 0.3)])
def test_two_traces_of_a_job_are_equal_byte_for_byte(tmp_path, monkeypatch, sleeps_s):
    """By the program and the pty of `make run`, however long the PC takes between two objects."""
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    run.draw_job("first", [SIDES, SIDES], first)
    ended = PlotterClient.end
    paces = iter(sleeps_s)

    def end(self, *arguments):
        time.sleep(next(paces))
        return ended(self, *arguments)

    monkeypatch.setattr(PlotterClient, "end", end)
    run.draw_job("second", [SIDES, SIDES], second)
    assert first.read_bytes() == second.read_bytes() and len(first.read_bytes().splitlines()) > 300


def test_time_at_rest_is_left_out_only_if_asked():
    paces = []
    for idle, rest_ms in ((True, 50), (True, 90), (False, 50), (False, 90)):
        machine = VirtualMachine("plotter_2014", start=(30, 20), idle=idle)
        assert machine.ask(packet("o")) == b"o"
        machine.settle()
        machine.run_ms(rest_ms)
        assert machine.ask(packet("6")) == b"n"
        machine.settle()
        paces.append([row[0] for row in machine.trace.rows()])
    assert paces[2] == paces[3] != paces[0]
    assert [late - early for early, late in zip(paces[0], paces[1])][-1] == 40_000

"""`passo torch` against `passo board --board torch_manipulator`, and a board that only knows the document's frames."""

import csv

import pytest
from typer.testing import CliRunner

from host_tools.cli.main import app
from host_tools.clients import torch as torch_client
from host_tools.clients.torch import TorchClient
from host_tools.failure import Failure
from passo.protocols.torch import protocol as torch
from passo.protocols.torch.frames import Cutter
from test_board_command import Board


def passo(*words):
    """(exit status or failure's text, what was printed)"""
    result = CliRunner().invoke(app, ["torch", *words])
    if isinstance(result.exception, Failure):
        return str(result.exception), result.output
    assert result.exception is None or result.exit_code, result.exception
    return result.exit_code, result.output


def test_a_session(tmp_path):
    trace = tmp_path / "trace.csv"
    with Board("--board", "torch_manipulator", "--trace", trace, "--time", "fast") as board:
        where = ("--port", board.port)
        assert passo("info", *where) == (
            0, "idle  X 0.000 Y 0.000 mm, motors with the other controller; made X 0.000 Y 0.000 mm; 0 dropped\n"
        )
        assert passo("connect", *where)[0] == 0
        assert passo("move", "10", "-5", *where) == (0, "idle  X 10.000 Y -5.000 mm, motors here\n")
        assert passo("goto", "1", "1", "--speed", "1200", *where) == (0, "idle  X 1.000 Y 1.000 mm, motors here\n")
        assert passo("config", "2", "3", *where)[1] == "jogs of 96 and 249 steps at 480 and 830 steps/s\n"
        assert passo("jog", "y-", "--times", "2", *where)[1].startswith("idle  X 1.000 Y -5.000")
        assert passo("origin", *where)[0] == 0
        assert passo("move", "7", "-9", "--steps", *where)[1] == "idle  X 7 Y -9 steps, motors here\n"
        assert passo("halt", "--steps", *where)[1] == "stopped after X 7 Y -9 steps\n"
        failure, _ = passo("move", "1", "1", "--speed", "1000000", *where)
        assert failure.startswith("the board did not do it: error 105, ")
        assert "1 dropped" in passo("info", *where)[1]
        assert passo("unlock", *where)[0] == 0
        assert passo("disconnect", *where)[0] == 0
        status, _, errors = board.end()
        assert status == 0 and not errors
    with open(trace) as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["t_us", "x", "y", "z", "a", "tool"] and rows[-1][1:3] == [str(48 + 7), str(-5 * 83 - 9)]


@pytest.mark.parametrize(
    "words", [("move", "1"), ("jog", "z+"), ("jog", "x+", "--times", "0"), ("spin",), ("move", "a", "b"), ("info",)]
)
def test_what_cannot_be_fails(words):
    assert passo(*words, *(["--port", "/dev/nothing"] if words[0] == "info" else []))[0] != 0


FAR = ["nan", "inf", "-inf", "1e400", "1e12", "-1e12", "89478486", str(2**32 / 48), str(2**31 / 48), str(-(2**31) / 48), str((2**29 - 1) / 48)]


def test_no_number_becomes_another_one_in_a_frame():
    """A frame has 32 bits, and the sign of a speed is the direction: a value that does not fit is refused by name before anything is sent."""
    with Board("--board", "torch_manipulator", "--time", "fast") as board:
        where = ("--port", board.port)
        assert passo("connect", *where)[0] == 0
        before = passo("config", *where)
        for text in FAR:
            for verb in ("move", "goto"):
                for pair in ((text, "0"), ("0", text)):
                    failure, said = passo(verb, *pair, *where)
                    assert str(failure).startswith("too far: " + "xy"[pair[0] == "0"]) and not said, (verb, pair, failure)
            if text[0] != "-" and text != "nan":  # the command line takes none of these for a speed or a length
                assert str(passo("config", text, "1", *where)[0]).startswith("too far: x")
                steps_s = str(float(text) * 60)
                assert str(passo("move", "1", "1", "--speed", steps_s, *where)[0]).startswith("too fast: the speed of x")
                assert str(passo("config", "1", "1", "--y-speed", steps_s, *where)[0]).startswith("too fast: the speed of y")
        assert passo("config", *where) == before
        assert passo("info", *where)[1] == "idle  X 0.000 Y 0.000 mm, motors here; made X 0.000 Y 0.000 mm; 0 dropped\n"
        assert board.end()[0] == 0


@pytest.mark.parametrize("verb", ["move", "goto", "jog", "info", "halt", "origin", "config", "connect", "disconnect"])
def test_help_has_examples(verb):
    status, text = passo(verb, "--help")
    assert status == 0 and f"passo torch {verb}" in text


class OldBoard:
    """A serial port with the original board behind it: it answers STOP and INFO, and nothing else."""

    def __init__(self, counts):
        self._cutter = Cutter({**{code: 2 for code in torch.CODES.values()}, 0xFE: 18, 0x99: 18}, 5)
        self._counts = counts
        self._said = b""
        self.heard = []
        self.timeout = 0

    @property
    def in_waiting(self):
        return len(self._said)

    def write(self, data):
        if data[0] == 0x77:
            return
        self._cutter.put_bytes(data, 0)
        while frame := self._cutter.next_frame():
            self.heard.append(frame)
            if frame[0] in (0xDD, 0xBB):
                self._said += torch.answer("STOP" if frame[0] == 0xDD else "INFO", *self._counts.pop(0))

    def read(self, count):
        data, self._said = self._said[:count], self._said[count:]
        return data

    def close(self):
        pass


def test_a_board_without_words_of_ours(monkeypatch):
    old = OldBoard([(0, 0), (5, -5), (9, -9), (9, -9)])
    monkeypatch.setattr(torch_client, "open_port", lambda port, baud: old)
    monkeypatch.setattr(torch_client, "_PASSO_S", 0.01)
    monkeypatch.setattr(torch_client, "POLL_S", 0.001)
    with TorchClient("old") as client:
        client.order(torch.move(9, 480, 9, -480))
        status = client.wait()
    assert (status["x"], status["y"], status["ours"]) == (9, -9, None)
    assert old.heard[1:2] == [torch.move(9, 480, 9, -480)] and len(old.heard) == 5


def test_repeated_jogs_of_a_board_without_words_of_ours(monkeypatch):
    old = OldBoard([(0, 0)])
    monkeypatch.setattr(torch_client, "open_port", lambda port, baud: old)
    monkeypatch.setattr(torch_client, "_PASSO_S", 0.01)
    with TorchClient("old") as client:
        client.jog("Y-", 3)
    assert old.heard[1:] == 3 * [torch.frame("JOG_Y-")]


def test_many_jogs_are_whole(tmp_path):
    """More than one frame of ours has room for."""
    with Board("--board", "torch_manipulator", "--time", "fast") as board:
        where = ("--port", board.port, "--steps")
        assert passo("connect", "--port", board.port)[0] == 0
        assert passo("config", "2", "3", "--x-speed", "4000", "--y-speed", "4000", *where)[0] == 0
        assert passo("jog", "y-", "--times", "600", *where)[1].startswith("idle  X 0 Y -1800 ")
        assert passo("jog", "x+", *where)[1].startswith("idle  X 2 Y -1800 ")


def test_a_silent_port_is_a_failure(monkeypatch):
    monkeypatch.setattr(torch_client, "open_port", lambda port, baud: OldBoard([]))
    with TorchClient("old", timeout_s=0.02) as client:
        client._serial.write = lambda data: None
        with pytest.raises(Failure, match="no answer to INFO"):
            client.counts()


def test_weave(tmp_path):
    """A seam by the command: from side to side, to its end; a wrong seam is refused by number."""
    trace = tmp_path / "trace.csv"
    with Board("--board", "torch_manipulator", "--time", "fast", "--trace", trace) as board:
        where = ("--port", board.port)
        assert passo("connect", *where)[0] == 0
        status, text = passo("weave", "20", "5", "--shape", "trapezoid", "--left", "100", *where)
        assert status == 0 and "X 20.000 Y 5.000 mm" in text
        status, text = passo("weave", "0", "0", "--centre", "0,15", "--clockwise", "--amplitude", "2", *where)
        assert status == 0 and "X 20.000 Y 5.000 mm" in text
        assert "is no shape" in passo("weave", "1", "1", "--shape", "spiral", *where)[0]
        assert "--centre wants two numbers" in passo("weave", "1", "1", "--centre", "1,2,3", *where)[0]
        assert "error 34" in passo("weave", "0", "0", "--centre", "0,1", *where)[0]
        board.end()
    rows = [line.split(",") for line in trace.read_text().splitlines()[1:]]
    y = [int(row[2]) / 83 for row in rows]
    assert min(y) < -2.2 and max(y) > 5 + 30 + 1.9

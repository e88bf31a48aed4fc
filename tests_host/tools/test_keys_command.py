"""`passo keys`: words, a real terminal, a pipe; and the board at the other end."""

import os
import pty
import subprocess
import time

import pytest

from host_tools import interpreter
from host_tools.cli.keys import Kit, parse_keys
from host_tools.failure import Failure
from test_board_command import Board, passo, rows

COMMAND = [*interpreter.passo(), "keys"]


class FakeSerial:
    port = "fake"

    def __init__(self):
        self.sent = b""

    def write(self, data):
        self.sent += data

    def flush(self):
        pass


def test_words_to_bytes():
    assert parse_keys("A1 c B 127 2s GH 500ms j") == [b"A\x01", b"C", b"B\x7f", 2.0, b"G", b"H", 0.5, b"J"]
    for words, text in (("A0", "1 (fastest) … 127"), ("B128", "B 128"), ("A", "'A' is no key"), ("K", "'K' is no key")):
        with pytest.raises(Failure) as failure:
            parse_keys(words)
        assert text in str(failure.value)


def test_the_state_is_what_was_told():
    kit = Kit(FakeSerial())
    kit.press_all(parse_keys("A5 I H F"))
    assert str(kit) == "motor 1: clockwise, 50.0 steps/s (speed 5)   motor 2: off"
    kit.press_all(parse_keys("D"))
    assert str(kit).endswith("motor 2: anticlockwise, 250.0 steps/s (speed 1)")
    assert kit._serial.sent == b"A\x05IHFD"


def test_the_board_turns(tmp_path):
    trace = tmp_path / "kit.csv"
    with Board("--board", "two_motor_kit", "--time", "real", "--trace", trace) as board:
        sent = passo("keys", "--send", "A5 B25 I 1s J", "--port", board.port)
        assert sent.stdout == "motor 1: off   motor 2: off\n", sent.stderr
        piped = subprocess.run(
            [*COMMAND, "--port", board.port], input="D # on\n200ms J\n", capture_output=True, text=True, timeout=120,
            env=interpreter.environment(),
        )  # fmt: skip
        assert piped.stdout.splitlines()[0].startswith("motor 1: off   motor 2: clockwise")
        time.sleep(0.2)
        assert board.end()[0] == 0
    place = [rows(trace)[-1][column] - rows(trace)[0][column] for column in (1, 2)]
    assert place[0] >= 40 and 10 <= place[1] < place[0]


def test_keys_are_sent_as_they_are_pressed():
    master, terminal = pty.openpty()
    with Board("--board", "two_motor_kit") as board:
        command = [*COMMAND, "--port", board.port]
        process = subprocess.Popen(command, stdin=terminal, stdout=subprocess.PIPE, text=True, env=interpreter.environment())
        assert process.stdout.readline().startswith("A n, B n: speed")
        for pressed in ("c", "a12\r", "b200\r", "h", "q"):
            time.sleep(0.1)
            os.write(master, pressed.encode())
        shown = process.communicate(timeout=120)[0]
        assert process.returncode == 0
        assert "motor 1: clockwise, 250.0 steps/s (speed 1)" in shown
        assert "speed of motor 1: 12" in shown and "motor 1: clockwise, 20.8 steps/s (speed 12)" in shown
        assert "B 200: the speed is 1" in shown
        assert shown.rstrip().endswith("motor 1: off   motor 2: off")


def test_faults_are_one_line():
    done = passo("keys", "--send", "A300", "--port", "/nosuch")
    assert done.returncode == 1 and done.stderr == "passo: A 300: the speed is 1 (fastest) … 127\n"
    done = passo("keys", "--send", "C", "--port", "/nosuch")
    assert done.returncode == 1 and "cannot open port /nosuch" in done.stderr

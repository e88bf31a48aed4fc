"""`passo emulate` as a program: a blank Pico behind a TCP port, as mpremote sees it, and how it ends."""

import os
import re
import signal
import struct
import subprocess
import time

import pytest
import serial
from emulated import make_machine, uf2  # noqa: F401
from patience import patience
from test_board_command import ROOT, Board

from host_tools import interpreter
from host_tools.emulator.binary import Unavailable, find_uf2
from passo.protocols.plotter.host import COMMANDS, packet

COMMAND = [*interpreter.passo(), "emulate"]


class Emulator(Board):
    """A running `passo emulate`; `ports` maps "port" and "usb" to what it printed."""

    def __init__(self, uf2, *options):
        self.process = subprocess.Popen(
            [*COMMAND, *map(str, options)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=interpreter.environment(PASSO_UF2=str(uf2)),
        )
        self.ports = {}
        for _ in range(2 if "--tcp" in options else 1):
            name, _, value = self.process.stdout.readline().strip().partition(": ")
            assert value, self.process.stderr.read()
            self.ports[name] = value

    def mpremote(self, *arguments, timeout=120):
        """Return mpremote's output. Raises CalledProcessError."""
        command = [*interpreter.mpremote_command(self.ports["usb"]), *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True, timeout=timeout).stdout


BLINK = """
from machine import Pin
import time
for i in range(8):
    Pin(10, Pin.OUT).toggle()
    time.sleep_ms(100)
"""


def test_a_blank_pico_for_mpremote(uf2, tmp_path):
    script, trace, link = tmp_path / "blink.py", tmp_path / "t.csv", tmp_path / "plotter"
    script.write_text(BLINK)
    options = "--blank", "--tcp", 0, "--uart0", link, "--trace", trace, "--vcd", tmp_path / "t.vcd", "--start", "9,9"
    with Emulator(uf2, *options) as emulator:
        assert emulator.ports["port"] == str(link) and link.exists()
        assert re.fullmatch(r"socket://127\.0\.0\.1:\d+", emulator.ports["usb"])
        emulator.mpremote("cp", script, ":", "+", "exec", "x = 1")
        assert "blink.py" in emulator.mpremote("fs", "ls")
        emulator.mpremote("resume", "exec", "import blink")
        uart = "from machine import UART, Pin; u = UART(0, 57600, tx=Pin(0), rx=Pin(1)); u.write(b'here')"
        emulator.mpremote("exec", uart)  # a wire without a listener
        with serial.Serial(str(link), timeout=20) as client:
            emulator.mpremote("resume", "exec", "u.write(b'here')")
            assert client.read(4) == b"here"
            client.write(b"there")
            read = "import time; time.sleep_ms(20); print(u.read())"
            assert emulator.mpremote("resume", "exec", read) == "b'there'\n"
        emulator.mpremote("reset")
        time.sleep(1)
        assert emulator.mpremote("exec", "import machine; print(machine.reset_cause())") == "3\n"
        emulator.process.send_signal(signal.SIGUSR1)
        time.sleep(1)
        assert emulator.mpremote("exec", "import machine; print(machine.reset_cause())") == "1\n"
        status, seconds, errors = emulator.end()
    assert (status, errors) == (0, "") and seconds < patience(2.0)
    assert not os.path.lexists(link)
    rows = trace.read_text().splitlines()
    assert [row.split(",")[-1] for row in rows[1:]] == ["0", "1000", "0", "1000", "0", "1000", "0", "1000", "0"]
    assert (tmp_path / "t.vcd").read_text().count("#") > 4


BOARD = "plotter_2014"
HELLO = packet(COMMANDS["REQUEST"])
FLASH_LIMIT_S = 900  # without a C compiler a busy Pico is 25 times slower than it is
ANSWER_LIMIT_S = 300


def answers(link):
    """Asks on the board's serial link until it answers; whether it does."""
    with serial.Serial(str(link), timeout=1) as client:
        for _ in range(ANSWER_LIMIT_S):
            client.write(HELLO)
            if client.read(1) == b"k":
                return True
    return False


@pytest.mark.slow
def test_a_blank_pico_is_flashed(uf2, tmp_path, show):
    link = tmp_path / "plotter"
    with Emulator(uf2, "--board", BOARD, "--blank", "--tcp", 0, "--uart0", link) as emulator:
        port = emulator.ports["usb"]
        make = ["make", "-n", "flash", f"BOARD={BOARD}", f"PORT={port}"]
        recipe = subprocess.run(make, cwd=ROOT, capture_output=True, text=True).stdout.splitlines()
        verb, *options = next(line.split()[1:] for line in recipe if "/passo " in line)
        assert (verb, options) == ("flash", ["--board", BOARD, "--port", port])
        command = [*interpreter.passo(), verb, *options]
        begun = time.monotonic()
        done = subprocess.run(
            command, cwd=tmp_path, capture_output=True, text=True, timeout=FLASH_LIMIT_S, env=interpreter.environment()
        )
        assert done.returncode == 0, done.stderr
        assert f"{BOARD} runs on {port}" in done.stdout
        took_s = time.monotonic() - begun
        assert answers(link)
        six_by_seven = "exec", "print(6 * 7)"
        assert emulator.mpremote(*six_by_seven) == "42\n", "Ctrl-C brings the REPL back"
        emulator.mpremote("reset")
        assert emulator.mpremote(*six_by_seven) == "42\n", "while it starts, too"
        emulator.mpremote("reset")
        assert answers(link)
    show("make flash into a blank emulated Pico", f"{took_s:.0f} s")


@pytest.mark.parametrize(
    "options, text",
    [
        (("--board", "nosuch"), "unknown board 'nosuch'"),
        (("--blank", "--start", "9999,0"), "not between the hard ends"),
        (("--blank", "--trace", "/nosuch/t.csv"), "cannot write /nosuch/t.csv"),
        (("--blank", "--uart0", "/nosuch/link"), "cannot make the link /nosuch/link"),
    ],
)
def test_one_clear_line(uf2, options, text):
    environ = interpreter.environment(PASSO_UF2=str(uf2))
    done = subprocess.run([*COMMAND, *options], capture_output=True, text=True, timeout=60, env=environ)
    assert done.returncode == 1 and done.stdout == ""
    assert text in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_the_port_is_printed_when_the_firmware_answers(uf2, tmp_path):
    """Before the port, lines on stderr show the progress. From then on nothing is lost, and the first answer comes within a moment."""
    with Emulator(uf2, "--board", BOARD, "--uart0", tmp_path / "plotter") as emulator:
        with serial.Serial(emulator.ports["port"], timeout=ANSWER_LIMIT_S) as client:
            client.write(HELLO)
            assert client.read(1) == b"k"
        status, seconds, errors = emulator.end()
    assert status == 0 and "building" in errors and "starts" in errors


@pytest.mark.slow
def test_answers_come_from_then_on(make_machine):
    machine = make_machine(BOARD)
    assert not machine.is_listening()
    machine.run_until(machine.is_listening, 10_000)
    assert machine.ask(HELLO, limit_ms=300) == b"k"


@pytest.mark.slow
@pytest.mark.parametrize("said", ["building", "starts"])
def test_it_ends_whatever_it_is_at(uf2, said):
    process = subprocess.Popen([*COMMAND, "--board", BOARD], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               env=interpreter.environment(PASSO_UF2=str(uf2)))  # fmt: skip
    while said not in (line := process.stderr.readline()):
        assert line, "it has ended by itself"
    process.send_signal(signal.SIGTERM)
    ports, errors = process.communicate(timeout=60)
    assert (process.returncode, ports) == (0, "") and "Traceback" not in errors, errors


def uf2_blocks(family=0xE48BFF56, total=2, text=b"MicroPython"):
    """A file of two blocks."""
    block = "<8I476sI"
    numbers = 0x0A324655, 0x9E5D5157, 0x2000, 0x10000000, 256
    return b"".join(struct.pack(block, *numbers, number, total, family, text, 0x0AB16F30) for number in range(2))


@pytest.mark.parametrize("data, text", [
    (b"", "is no UF2 file: 0 bytes"),
    (b"MicroPython" * 1000, "is no UF2 file: 11000 bytes are not whole blocks"),
    (bytes(5120), "is no UF2 file: block 0 of 10"),
    (uf2_blocks() + uf2_blocks()[:512], "is not whole: 3 of 2 blocks"),
    (uf2_blocks(family=0xE48BFF59), "is not for the RP2040 of a Pico: its family is 0xe48bff59"),
    (uf2_blocks(total=3), "is not whole: 2 of 3 blocks"),
    (uf2_blocks(text=b"CircuitPy"), "holds no MicroPython"),
])  # fmt: skip
def test_what_is_no_uf2_for_the_pico_is_refused(data, text, tmp_path, monkeypatch):
    path = tmp_path / "pico.uf2"
    path.write_bytes(data)
    monkeypatch.setenv("PASSO_UF2", str(path))
    with pytest.raises(Unavailable, match=re.escape(f"{path} {text}")):
        find_uf2()


def test_a_whole_uf2_is_taken(tmp_path, monkeypatch):
    path = tmp_path / "pico.uf2"
    path.write_bytes(uf2_blocks())
    monkeypatch.setenv("PASSO_UF2", str(path))
    assert find_uf2() == path


def test_a_file_that_is_no_uf2_ends_at_once(tmp_path):
    path = tmp_path / "pico.uf2"
    path.write_bytes(bytes(5120))
    done = subprocess.run(COMMAND, capture_output=True, text=True, timeout=60, env=interpreter.environment(PASSO_UF2=str(path)))
    assert done.returncode == 1 and done.stderr.startswith(f"passo: {path} is no UF2 file"), done.stderr


def test_without_a_binary():
    environ = interpreter.environment(PASSO_UF2="/nosuch/pico.uf2")
    done = subprocess.run([*COMMAND, "--blank"], capture_output=True, text=True, timeout=60, env=environ)
    assert done.returncode == 1 and done.stderr == "passo: PASSO_UF2 names /nosuch/pico.uf2, which is no file\n"

"""`passo board` as a program: its ports, its time, its files, and how it ends."""

import contextlib
import csv
import io
import os
import re
import select
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from unittest import mock

import pytest
import serial

from host_tools import boards, interpreter
from host_tools.cli.main import main
from host_tools.clients.serial_port import LinkError
from host_tools.failure import Failure
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages
from passo import errors
from patience import patience
from test_virtual_machine import LOG_2014

ROOT = Path(__file__).resolve().parents[2]
COMMAND = [*interpreter.passo(), "board"]
HELLO = bytes.fromhex(LOG_2014[0][0])
SAFE_S = 2.0
LIMIT_S = 60  # after which something hangs
pytestmark = pytest.mark.programs_measured


class Board:
    """A running `passo board`; `ports` are the texts after `port:`."""

    def __init__(self, *options, links=1):
        self.process = subprocess.Popen(
            [*COMMAND, *map(str, options)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=interpreter.environment(),
        )
        ready, _, _ = select.select([self.process.stdout], [], [], LIMIT_S)
        assert ready, f"no port within {LIMIT_S} s"
        self.lines = [self.process.stdout.readline().strip() for _ in range(links)]
        assert self.lines[0].startswith("port: "), (self.lines, self.process.stderr.read())
        self.port = self.lines[0][6:]

    def open(self):
        return serial.serial_for_url(self.port, 57600, timeout=LIMIT_S)

    def end(self, number=signal.SIGTERM):
        """(exit status, seconds it took, stderr)"""
        started = time.monotonic()
        self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=LIMIT_S)
        return self.process.returncode, time.monotonic() - started, errors

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()


def converse(client):
    for packet, answer in LOG_2014:
        client.write(bytes.fromhex(packet))
        assert client.read(1) == answer, packet


def rows(path):
    with open(path, newline="") as file:
        return [[float(field) for field in row] for row in list(csv.reader(file))[1:]]


def failure(*options):
    command = [*COMMAND, *map(str, options)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, env=interpreter.environment())
    assert done.returncode != 0 and done.stdout == ""
    return done.stderr


def test_the_log_of_2014_over_a_pty(tmp_path):
    link = tmp_path / "plotter"
    trace, vcd = tmp_path / "t.csv", tmp_path / "t.vcd"
    options = "--time", "fast", "--link", link, "--trace", trace, "--vcd", vcd, "--bounce-ms", 3, "--seed", 4
    with Board(*options) as board:
        assert board.lines == [f"port: {link}"]
        with board.open() as client:
            converse(client)
        with board.open() as client:
            client.write(HELLO)
            assert client.read(1) == b"k"
        status, seconds, errors = board.end()
    assert (status, errors) == (0, "") and seconds < patience(SAFE_S)
    assert not link.is_symlink()
    table = rows(trace)
    assert table[-1][1:] == [644, 314, 0, 0, 0]
    assert vcd.read_text().startswith("$timescale 1 ns $end")


def test_tcp():
    with Board("--time", "fast", "--tcp", 0) as board:
        assert re.fullmatch(r"socket://127\.0\.0\.1:\d+", board.port)
        with board.open() as client:
            converse(client)
        assert board.end(signal.SIGINT)[0] == 0


def until_drawn(trace, count):
    """Wait until a trace, which the board writes as it moves, has `count` rows."""
    deadline = time.monotonic() + LIMIT_S
    while not trace.exists() or len(trace.read_text().splitlines()) < count:
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.parametrize("mode", ("real", "fast"))
def test_sigterm_in_the_middle_of_a_drawing(tmp_path, mode):
    trace, vcd = tmp_path / "t.csv", tmp_path / "t.vcd"
    options = "--time", mode, "--start", "0,0", "--trace", trace, "--vcd", vcd
    with Board(*options) as board:
        with board.open() as client:
            for i in range(300):
                x, y = (3900, 2900) if i % 2 else (0, 0)
                body = bytes([ord("l"), x >> 8, x & 255, y >> 8, y & 255])
                client.write(body + bytes([sum(body) & 255]))
                assert client.read(1) == b"n"
            client.write(bytes.fromhex(LOG_2014[-1][0]))
            until_drawn(trace, 100)
            status, seconds, errors = board.end()
    assert (status, errors) == (0, "") and seconds < patience(SAFE_S)
    table = rows(trace)
    assert len(table) > 50 and table[-2][5] == 1000, "it was drawing"
    assert table[-1][5] == 0, "the pen comes up"
    text = vcd.read_text()
    wires = dict(re.findall(r"\$var wire 1 (\S+) (\w+) \$end", text))
    last = {wires[code]: level for level, code in re.findall(r"^([01])(\S+)$", text, re.M)}
    assert text.endswith("\n") and not any(int(last[name]) for name in last if not name.startswith("barrier"))


def test_real_time_is_real():
    with Board("--start", "0,0") as board, board.open() as client:
        for packet in ("6d 00 00 00 00 6d", "6c 00 64 00 00 d0"):
            client.write(bytes.fromhex(packet))
            assert client.read(1) == b"n"
        started = time.monotonic()
        client.write(bytes.fromhex("65 00 00 00 00 65"))
        assert client.read(1) == b"d"
        # 100 steps of 2.225 ms, pen down and up of 60 ms each, 20 ms for the motors to wake.
        assert 0.33 < time.monotonic() - started < patience(0.8)


def cpu_seconds(pid):
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="reads /proc")
@pytest.mark.parametrize("connected", (True, False))
def test_idle_board_sleeps(connected):
    with Board("--time", "fast") as board:
        client = board.open()
        client.write(HELLO)
        assert client.read(1) == b"k"
        if not connected:
            client.close()
        time.sleep(0.2)
        before = cpu_seconds(board.process.pid)
        time.sleep(1.0)
        assert cpu_seconds(board.process.pid) - before < 0.15
        client.close()


def two_links(tmp_path):
    path = tmp_path / "two.py"
    board = boards.load("plotter_2014")
    path.write_text(f"BOARD = {({**board, 'links': [*board['links'], {'name': 'usb', 'port': 'usb', 'protocol': 'plotter'}]})!r}\n")
    return path


def test_two_links(tmp_path):
    path, link = two_links(tmp_path), tmp_path / "second"
    with Board("--board", path, "--link", f"usb={link}", "--protocol", "usb=plotter", links=2) as board:
        assert board.lines[1] == f"port usb: {link}"
        with serial.Serial(str(link), timeout=LIMIT_S) as client:
            client.write(HELLO)
            assert client.read(1) == b"k"
        assert board.end()[0] == 0


def test_who_takes_a_tcp_connection_is_told_that_there_was_another():
    """The plotter's language of 2014 has no message for the host that loses the link, but the next STATUS has the number of the error; {log} of the pulse
    language says which link it was.
    """
    from host_tools.clients.plotter import PlotterClient
    from host_tools.clients.pulses import PulsesClient
    from passo.protocols.plotter.host import COMMANDS, packet

    with Board("--board", "plotter_2014", "--tcp", 0) as board, PlotterClient(board.port) as first:
        assert first.status()["error"] == 0
        with socket.create_connection(("127.0.0.1", int(board.port.rpartition(":")[2]))) as second:
            second.settimeout(60)
            second.sendall(packet(COMMANDS["STATUS"]))
            said = b""
            while len(said) < 4:
                said += second.recv(100)
            assert said[:1] == b"?" and said[2] == errors.LINK_TAKEN
            with pytest.raises(LinkError, match="or another program has taken the connection"):
                first.status()
    with Board("--board", "lpt_router", "--tcp", 0) as board, PulsesClient(board.port) as first:
        first.command("speed", 1200)
        with socket.create_connection(("127.0.0.1", int(board.port.rpartition(":")[2]))) as second:
            second.settimeout(60)
            second.sendall(b"{log}\n")
            said = b""
            while f",{errors.LINK_TAKEN},pc 127.0.0.1:".encode() not in said:
                said += second.recv(1000)
            with pytest.raises(LinkError, match=r"the program at 127\.0\.0\.1:\d+ has taken this connection"):
                first.command("speed", 1200)


def test_the_tcp_port_of_each_link_is_told(tmp_path):
    """The second link has the next port; if that is taken, it says so."""
    path = two_links(tmp_path)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        errors = failure("--board", path, "--tcp", str(port - 1))
        assert re.match(f"passo: (link usb: cannot serve TCP port {port}|cannot serve TCP port {port - 1}): Address already in use", errors)
    with Board("--board", path, "--tcp", "0", links=2) as board:
        assert [line.rpartition(":")[0] for line in board.lines] == ["port: socket://127.0.0.1", "port usb: socket://127.0.0.1"]
    errors = failure("--board", path, "--tcp", "65535")
    assert "passo: link usb: cannot serve TCP port 65536: " in errors or "cannot serve TCP port 65535" in errors


def test_a_flash_that_cannot_be_written_is_named(tmp_path):
    """At the start; the journal amid work; and settings, which the board itself answers by an error."""
    (tmp_path / "pages.new").symlink_to("/dev/full")
    with pytest.raises(Failure, match=f"cannot write {tmp_path / 'pages'}: No space left on device"):
        Pages(tmp_path / "pages").write(0, 0, bytes(32))
    (tmp_path / "flash").mkdir()
    (tmp_path / "flash" / ".tried").symlink_to("/dev/full")
    assert failure("--flash", tmp_path / "flash") == f"passo: --flash: cannot write {tmp_path / 'flash' / '.tried'}: No space left on device\n"


def test_settings_that_cannot_be_saved_are_told_by_name(tmp_path, capfd):
    machine = VirtualMachine("router_3axis", flash=tmp_path)
    for slot in (0, 1):
        (tmp_path / f"settings.{slot}").unlink(missing_ok=True)
        (tmp_path / f"settings.{slot}").mkdir()
    assert b"error:" in machine.ask(b"$100=80\n")
    assert re.search(rf"cannot write {tmp_path}/settings.[01]: Is a directory", capfd.readouterr().err)


def passo(*arguments):
    """As a process of its own would have it, in this one: quicker."""
    out, errors, status = io.StringIO(), io.StringIO(), 0
    with mock.patch.object(sys, "argv", ["passo", *map(str, arguments)]), contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            main()
        except SystemExit as end:
            status = end.code or 0
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), errors.getvalue())


def test_the_command_is_handed_over_from_both_links(tmp_path):
    path, usb = two_links(tmp_path), tmp_path / "usb"
    options = "--board", path, "--link", f"usb={usb}", "--protocol", "usb=grbl"
    with Board(*options, links=2) as board:
        grbl = "link", "--protocol", "grbl", "--port", usb
        plotter = "link", "--protocol", "plotter", "--port", board.port
        assert passo(*grbl).stdout == "link 1, pc, commands\n"
        assert passo(*grbl, 0).stdout == "link 2, usb, commands\n"
        with serial.Serial(str(usb), timeout=LIMIT_S) as client:
            client.write(b"$X\n")
            assert client.read_until(b"ok\r\n").endswith(b"ok\r\n")
        refused = passo("send", "--port", board.port, "SPEED 900")
        assert refused.returncode == 1 and "error 112, another link commands the machine" in refused.stderr
        assert passo(*plotter, 1).stdout == "link 1 commands\n"
        assert passo("send", "--port", board.port, "SPEED 900", "LINK 2").returncode == 0
        assert passo(*grbl).stdout == "link 2, usb, commands\n"
        assert "no link of this number" in passo(*grbl, 3).stderr
        logged = passo("log", "--port", usb).stdout.splitlines()
        assert logged[0].split()[1:4] == ["s", "pc", "112"] and logged[0].endswith("hand the command over first")
        assert logged[-1] == "since the start: 1 times 112, 1 times 113"
        assert "it has no word for that" in passo("link", "--protocol", "keys", "--port", usb).stderr
        assert "plotter has no word for who commands" in passo(*plotter).stderr
        assert board.end()[0] == 0


@pytest.mark.parametrize("board, protocol", [("torch_manipulator", "torch"), ("lpt_router", "pulses")])
def test_the_log_of_other_languages(board, protocol):
    """With --protocol and without; asking for the log moves nothing."""
    refused, question = b"{jump}", b"{?}"
    if protocol == "torch":
        from passo.protocols.torch import protocol as torch

        refused, question = torch.move(5, 480, 5, 480), torch.frame("INFO")
    with Board("--board", board) as board:
        with serial.Serial(board.port, timeout=0.2) as client:
            client.write(refused)
            client.read(100)
        number = 117 if protocol == "torch" else 124
        for words in ((), ("--protocol", protocol)):
            told = passo("log", "--port", board.port, *words)
            assert told.returncode == 0, told.stderr
            assert told.stdout.splitlines()[0].split()[1:4] == ["s", "pc", str(number)]
        with serial.Serial(board.port, timeout=0.2) as client:
            client.write(question)
            said = client.read(1000)
            assert said == torch.answer("INFO", 0, 0) if protocol == "torch" else b"idle" in said.lower(), said
        assert "it has no word for the status and the log" in passo("log", "--port", board.port, "--protocol", "keys").stderr
        assert board.end()[0] == 0


def test_faults_of_the_machine_are_told_at_the_end():
    with Board("--time", "fast", "--start", "50,50", "--fault", "barrier_x=dead") as board:
        with board.open() as client:
            client.write(bytes.fromhex(LOG_2014[1][0]))
            client.timeout = 1
            assert client.read(1) == b"", "an alarm withholds ORIGIN_OK"
        status, _, errors = board.end()
    assert status == 0
    assert re.fullmatch(
        r"the machine: \d+ errors; the first at \d+\.\d{3} ms: x ran into its hard end at -140\n", errors
    )


def test_a_wrong_board_file_is_one_clear_line(tmp_path):
    path = tmp_path / "wrong.py"
    path.write_text("BOARD = {'name': 'wrong'}\n")
    assert failure("--board", path) == f"passo: board {path}: drive: missing\n"


@pytest.mark.parametrize(
    "options, text",
    [
        (("--board", "nosuch"), "unknown board 'nosuch'"),
        (("--time", "slow"), "--time is real or fast, not 'slow'"),
        (("--protocol", "klingon"), "unknown protocol 'klingon'"),
        (("--protocol", "usb=plotter"), "there is no link 'usb'; known are pc"),
        (("--link", "/nosuch/link"), "cannot make the link /nosuch/link"),
        (("--trace", "/nosuch/t.csv"), "cannot write /nosuch/t.csv"),
        (("--vcd", "/nosuch/t.vcd"), "cannot write /nosuch/t.vcd"),
        (("--flash", "/dev/null/flash"), "--flash: cannot write /dev/null/flash"),
        (("--start", "1"), "2 positions are wanted"),
        (("--start", "a,b"), "whole steps are wanted"),
        (("--start", "9999,0"), "not between the hard ends"),
        (("--fault", "barrier_x"), "NAME=VALUE is wanted"),
        (("--fault", "lid=dead"), "no input lid"),
        (("--fault", "barrier_x=tired"), "none of dead, stuck"),
    ],
)
def test_one_clear_line(options, text):
    errors = failure(*options)
    assert text in errors and errors.count("\n") == 1, errors

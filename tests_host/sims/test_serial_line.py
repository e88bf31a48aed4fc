"""Virtual serial lines: bytes pass as they are, and clients may come and go."""

import os
import socket
import stat
import subprocess
import termios
import time

import pytest
import serial
from patience import patience

from host_tools import interpreter
from host_tools.clients import serial_port
from host_tools.clients.grbl import GrblClient
from host_tools.clients.plotter import PlotterClient
from host_tools.clients.serial_port import LinkError, open_exclusively
from host_tools.failure import Failure
from host_tools.sim.serial_line import TAKEN, PtyLine, TcpLine, wait_for_bytes
from running_router import Running

ALL_BYTES = bytes(range(256))


def receive(line, count):
    """Read until `count` bytes have come or half a minute is over."""
    data = b""
    end = time.monotonic() + 30
    while len(data) < count and time.monotonic() < end:
        wait_for_bytes([line], 5)
        data += line.read()
    return data


@pytest.fixture(params=["pty", "tcp"])
def line(request):
    line = PtyLine() if request.param == "pty" else TcpLine(0)
    yield line
    line.close()


def connect(line):
    client = serial.serial_for_url(line.name, 57600, timeout=30)
    line.read()
    return client


def test_every_byte_passes_both_ways(line):
    with connect(line) as client:
        client.write(ALL_BYTES)
        assert receive(line, 256) == ALL_BYTES
        line.write(ALL_BYTES)
        assert client.read(256) == ALL_BYTES


def test_nothing_to_read_does_not_wait(line):
    started = time.monotonic()
    assert line.read() == b""
    with connect(line):
        assert line.read() == b""
    assert time.monotonic() - started < patience(1)


def test_what_is_said_to_nobody_is_lost(line):
    line.write(b"lost")
    line.read()
    with connect(line) as client:
        line.write(b"k")
        assert client.read(1) == b"k"
        line.write(b"unread")
        client.write(b"x")
        assert receive(line, 1) == b"x"
    time.sleep(0.05)
    for _ in range(3):
        line.read()
        line.write(b"lost")
    with connect(line) as client:
        client.timeout = 0.1
        assert client.read(1) == b""
        line.write(b"here")
        assert client.read(4) == b"here"


def test_bytes_written_just_before_leaving_arrive(line):
    with connect(line) as client:
        client.write(b"last words")
        client.flush()
    assert receive(line, 10) == b"last words"


def test_wait_ends_early_when_a_byte_comes(line):
    with connect(line) as client:
        client.write(b"a")
        started = time.monotonic()
        wait_for_bytes([line], 60_000)
        assert time.monotonic() - started < 30 and receive(line, 1) == b"a"
    for _ in range(3):
        line.read()
    started = time.monotonic()
    wait_for_bytes([line], 30)
    assert time.monotonic() - started >= 0.025, "a line without a client must not spin"


def test_a_client_that_does_not_read_costs_nothing_but_its_answers(line):
    with connect(line) as client:
        for _ in range(3000):
            line.write(b"0123456789" * 10)
        client.write(b"still here")
        assert receive(line, 10) == b"still here"


def test_pty_is_raw_again_after_a_rude_client():
    line = PtyLine()
    slave = os.open(line.name, os.O_RDWR | os.O_NOCTTY)
    assert line.read() == b""
    modes = termios.tcgetattr(slave)
    modes[3] |= termios.ECHO | termios.ICANON
    modes[1] |= termios.OPOST | termios.ONLCR
    termios.tcsetattr(slave, termios.TCSANOW, modes)
    os.close(slave)
    assert line.read() == b""
    slave = os.open(line.name, os.O_RDWR | os.O_NOCTTY)
    line.read()
    line.write(b"a\nb")
    assert os.read(slave, 10) == b"a\nb" and line.read() == b""
    os.close(slave)
    line.close()


def test_symlink(tmp_path):
    path = tmp_path / "plotter"
    path.symlink_to("/nowhere")
    line = PtyLine(path)
    assert line.name == str(path) and os.path.realpath(path).startswith("/dev/")
    path.unlink()
    path.symlink_to("/nowhere")
    line.close()
    assert path.is_symlink(), "another's link is left alone"
    path.unlink()
    path.write_text("precious")
    with pytest.raises(Failure, match="cannot make the link .*plotter: File exists"):
        PtyLine(path)
    assert path.read_text() == "precious" and list(tmp_path.iterdir()) == [path]


def test_tcp_port_in_use_and_a_second_client():
    line = TcpLine(0)
    port = int(line.name.rpartition(":")[2])
    with pytest.raises(Failure, match=f"cannot serve TCP port {port}"):
        TcpLine(port)
    first = connect(line)
    with socket.create_connection(("127.0.0.1", port)) as second:
        second.sendall(b"new")
        assert receive(line, 3) == b"new"
        line.write(b"k")
        assert second.recv(1) == b"k"
    first.close()
    line.close()


@pytest.mark.parametrize("said", [b"", b"GET / HTTP/1.1\r\nHost: x\r\n\r\n$X\n", bytes.fromhex("000300002112a442") + b"~" * 12])
def test_a_browser_takes_nobodys_place(said):
    """Nor with a connection that it opens beforehand; the sender beside it goes on, and the next client is served."""
    line = TcpLine(0)
    port = int(line.name.rpartition(":")[2])
    with connect(line) as client:
        for _ in range(3):
            with socket.create_connection(("127.0.0.1", port)) as browser:
                browser.sendall(said)
                client.write(b"G1X1\n")
                assert receive(line, 5) == b"G1X1\n"
                line.write(b"ok\r\n")
                assert client.read(4) == b"ok\r\n"
                with socket.create_connection(("127.0.0.1", port)):
                    line.read()
        assert line.clients == 1
        with socket.create_connection(("127.0.0.1", port)) as other:
            other.sendall(b"?")
            assert receive(line, 1) == b"?" and line.clients == 2
    with socket.create_connection(("127.0.0.1", port)) as other:
        line.read()
        line.write(b"k")
        assert other.recv(1) == b"k", "nobody else is there"
    line.close()


def test_a_link_in_use_is_not_stolen(tmp_path):
    """The second board is refused, the first one goes on; afterwards the name is free, and nothing is left behind."""
    link = tmp_path / "plotter"
    first = PtyLine(link)
    target = os.readlink(link)
    with pytest.raises(Failure, match=f"another board has the link {link}"):
        PtyLine(link)
    assert os.readlink(link) == target
    with connect(first) as client:
        client.write(b"still")
        assert receive(first, 5) == b"still"
    first.close()
    assert list(tmp_path.iterdir()) == []
    PtyLine(link).close()


def test_a_link_that_a_killed_board_has_left_is_replaced(tmp_path):
    link = tmp_path / "plotter"
    link.symlink_to("/dev/pts/no-such")
    (tmp_path / ".plotter.lock").write_text("")
    line = PtyLine(link)
    assert os.readlink(link) != "/dev/pts/no-such"
    line.close()
    assert list(tmp_path.iterdir()) == []


def test_a_client_that_does_not_read_is_told_of(line, capfd, monkeypatch):
    """Bytes that the wire cannot take are kept up to a limit; beyond it the newest stay, and one message says it."""
    monkeypatch.setattr("host_tools.sim.serial_line.UNSENT_BYTES", 10_000)
    with connect(line) as client:
        for _ in range(5_000):
            line.write(bytes(10_000))
            if "does not read" in capfd.readouterr().err:
                break
        line.write(b"last" * 2)
        assert "does not read" not in capfd.readouterr().err
        client.timeout = 0.02
        data = b""
        while not data.endswith(b"lastlast"):
            line.read()
            data = data[-8:] + client.read(65_536)


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_lines_sent_without_waiting_are_answered(kind):
    """4,200 bytes at once: an answer a line, in order: the lines answered by ok were done, and no others."""
    with Running("fast", PtyLine() if kind == "pty" else TcpLine(0)) as running:
        with serial.serial_for_url(running.line.name, 115200, timeout=10) as client:
            client.write(b"$X\nG91\n")
            while client.readline().strip() != b"ok" or client.readline().strip() != b"ok":
                pass
            tenths = [number % 10 for number in range(300)]
            client.write(b"".join(b"G1X0.%d00F3000\n" % tenth for tenth in tenths))
            assert client.readline().strip() == b"[MSG:Caution: not homed, soft limits do not hold]"
            said = [client.readline().strip() for _ in tenths]
            assert set(said) == {b"ok", b"error:11"}
            client.write(b"G4P0\n")
            assert client.readline().strip() == b"ok"
            assert running.position()[0] == 32 * sum(tenth for tenth, answer in zip(tenths, said) if answer == b"ok")


# --- files of others in the way, and the messages


def test_the_lock_beside_a_link_follows_no_link_and_is_of_this_user_only(tmp_path):
    link, lock, precious = tmp_path / "plotter", tmp_path / ".plotter.lock", tmp_path / "precious"
    for _existing in (False, True):
        PtyLine(link).close()
        lock.write_text("")
        lock.chmod(0o666)
        line = PtyLine(link)
        assert stat.S_IMODE(lock.stat().st_mode) == 0o600
        line.close()
    lock.symlink_to(precious)
    with pytest.raises(Failure, match=f"cannot make the link {link}: {lock}: "):
        PtyLine(link)
    assert not precious.exists() and lock.is_symlink()
    lock.unlink()
    os.mkfifo(lock)
    with pytest.raises(Failure, match=f"cannot make the link {link}: {lock}: "):
        PtyLine(link)


def test_the_lock_of_a_url_follows_no_link_and_is_of_this_user_only(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    line = TcpLine(0)
    lock, precious = serial_port._lock_file(line.name), tmp_path / "precious"
    opened = open_exclusively(line.name, 9600, 0)
    assert stat.S_IMODE(lock.stat().st_mode) == 0o600 and lock.parent == tmp_path
    opened.close()
    lock.unlink()
    lock.symlink_to(precious)
    with pytest.raises(LinkError, match="cannot open port"):
        open_exclusively(line.name, 9600, 0)
    assert not precious.exists()
    line.close()


KILLED = "import sys, time; from host_tools.sim.serial_line import PtyLine; line = PtyLine(sys.argv[1]); print(line.name, flush=True); time.sleep(99)"


def test_the_link_of_a_killed_board_is_removed(tmp_path):
    """So that it does not lead to the board that gets the same pty next."""
    link = tmp_path / "plotter"
    program = subprocess.Popen([*interpreter.python(), "-c", KILLED, str(link)], stdout=subprocess.PIPE, text=True)
    assert program.stdout.readline().strip() == str(link) and link.is_symlink()
    program.kill()
    program.communicate()
    end = time.monotonic() + 60
    while list(tmp_path.iterdir()) and time.monotonic() < end:
        time.sleep(0.01)
    assert list(tmp_path.iterdir()) == []


def test_a_link_that_a_killed_board_has_left_is_not_opened(tmp_path):
    """Its pty is another board's by now."""
    other = PtyLine()
    link, lock = tmp_path / "plotter", tmp_path / ".plotter.lock"
    link.symlink_to(other.name)
    lock.write_text("")
    with pytest.raises(LinkError, match=f"the link {link} was left by a board that was killed"):
        open_exclusively(str(link), 9600, 0)
    lock.unlink()
    open_exclusively(str(link), 9600, 0).close()  # a link of the user's own
    other.close()
    link.unlink()
    line = PtyLine(link)
    open_exclusively(str(link), 9600, 0).close()
    line.close()


@pytest.mark.parametrize("language, said_to_it", [("grbl", "[MSG:{} has taken this connection]\r\n"), ("pulses", "taken:{}\n"), ("plotter", ""), ("torch", ""), ("keys", "")])
def test_who_loses_a_tcp_line_is_told_who_has_it(language, said_to_it, capfd):
    taken = []
    line = TcpLine(0, message=TAKEN.get(language, b""), taken=taken.append)
    port = int(line.name.rpartition(":")[2])
    with socket.create_connection(("127.0.0.1", port)) as first, socket.create_connection(("127.0.0.1", port)) as second:
        first.sendall(b"$G\n")
        assert receive(line, 3) == b"$G\n"
        line.write(b"ok\r\n")
        second.sendall(b"?")
        assert receive(line, 1) == b"?"
        first.settimeout(10)
        said = b""
        while part := first.recv(100):
            said += part
        names = ["%s:%d" % each.getsockname() for each in (first, second)]
        assert said == b"ok\r\n" + said_to_it.format(names[1]).encode() and taken == [names[0]]
        assert f"the program at {names[1]} has taken the place of the one at {names[0]}" in capfd.readouterr().err
    line.close()


def test_a_client_of_ours_says_that_another_may_have_the_connection():
    line = TcpLine(0)
    with PlotterClient(line.name) as client, socket.create_connection(("127.0.0.1", int(line.name.rpartition(":")[2]))) as other:
        line.read()
        other.sendall(b"new")
        assert receive(line, 3) == b"new"
        with pytest.raises(LinkError, match=f"{line.name} hung up: the board has ended, or another program has taken the connection"):
            client.request()
    line.close()


def test_frames_that_a_board_has_not_are_refused(monkeypatch):
    """Not gone on without: --frames is given for a cable that changes bytes."""
    with Running("fast") as running:
        monkeypatch.setattr(serial_port, "frames", True)
        with pytest.raises(LinkError, match=f"the board on {running.line.name} answers no frames"):
            GrblClient(running.line.name)
        monkeypatch.setattr(serial_port, "frames", None)
        with GrblClient(running.line.name) as client:
            assert not client.framed and client.command("$G")

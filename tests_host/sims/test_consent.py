"""A sender at a port that any program of this PC reaches: it is shown the machine, and moves it once the operator has let it in."""

import os
import pty
import re
import socket
import subprocess
import time

import pytest
from hypothesis import given, strategies

from host_tools import interpreter
from host_tools.sim.consent import Consent, GuestLine
from panel_process import PanelProcess
from host_tools.page.guest_sender import ALWAYS, QUESTIONS
from host_tools.clients.page_key import in_groups

LIMIT_S = 60
ORDERS = [b"G0X1", b"$LINK=0", b"$X", b"$J=G91X10F1000", b"$H", b"$110=5", b"$SLP", b"$JR", b"M3S100", b"$token=", b"$TOKEN=ABCD"]


class Memory:
    """A line of one client."""

    name = "memory"

    def __init__(self):
        self.clients = 1
        self.come = b""
        self.said = b""

    def read(self):
        come, self.come = self.come, b""
        return come

    def write(self, data):
        self.said += data


def through(line, data):
    """Return the bytes that come through to a board, which answers each line."""
    line._line.come += data
    given = b""
    for _ in range(len(data) + 9):
        got = line.read()
        given += got
        line.write(b"ok\r\n" * got.count(b"\n"))
    return given


@given(strategies.lists(strategies.one_of(strategies.sampled_from(ORDERS + list(QUESTIONS) + [b"", b"?", b"!", b"~", b"\x18", b"\x90", b"\x85", b"\xff"]), strategies.binary(max_size=9))))
def test_nothing_but_questions_and_what_makes_it_safe_goes_on(words):
    consent = Consent()
    line = GuestLine(Memory(), consent)
    given_ = through(line, b"x\n" + b"\n".join(words) + b"\n")
    safe = bytes(set(given_) & {0x3F, *ALWAYS})
    for word in given_.translate(None, safe).split(b"\n"):
        assert word.strip().upper() in (b"", *QUESTIONS), word
    consent.give_consent()
    assert through(line, b"$LINK=0\nG0X1\n~\x90") == b"$LINK=0\nG0X1\n~\x90"


@given(strategies.lists(strategies.sampled_from([b"$$", b"$G", b"G0X1", b"", b"$X"]), min_size=1, max_size=20), strategies.integers(1, 7))
def test_each_line_has_one_answer_in_its_place(words, piece):
    line = GuestLine(Memory(), Consent())
    memory, data = line._line, b"".join(word + b"\r\n" for word in words)
    owed = []
    while data or owed or memory.come or line._held:
        memory.come, data = memory.come + data[:piece], data[piece:]
        owed += re.findall(rb"(.*)\n", line.read())
        if owed:
            owed.pop(0)
            line.write(b"o")
            line.write(b"k\r\n")
    assert memory.said.split() == [b"ok" if word in (b"$$", b"$G", b"") else b"error:178" for word in words]


def test_a_token_in_the_first_line_admits_one_connection():
    consent = Consent()
    line = GuestLine(Memory(), consent)
    first = b"$TOKEN=" + in_groups(consent.token).lower().encode() + b"\r\n"
    assert through(line, first + b"G0X1\n") == b"G0X1\n" and line._line.said.startswith(b"ok\r\n") and not consent.given
    line._line.clients += 1
    assert through(line, b"G0X1\n" + first + b"G0X1\n") == b"", "another connection, and it came second"
    line._line.clients += 1
    assert through(line, b"$TOKEN=ABCD-ABCD-ABCD-ABCD\nG0X1\n") == b""
    line._line.clients += 1
    assert through(line, first + b"G0X1\n") == b"G0X1\n"


def said(fd, wanted):
    """Return the text of a program in its terminal, up to `wanted`."""
    text, deadline = "", time.monotonic() + LIMIT_S
    while wanted not in text:
        assert time.monotonic() < deadline, text
        text += os.read(fd, 4096).decode()
    return text


def ask(client, line):
    """The answer to a line, at the end of all others."""
    client.sendall(line)
    heard = b""
    while not (found := re.search(rb"(ok|error:\d+)\r\n", heard)):
        data = client.recv(4096)
        assert data, heard
        heard += data
    return found[1]


@pytest.mark.unmeasured
@pytest.mark.parametrize("answer", ["y", "n"])
def test_asked_in_the_terminal(tmp_path, answer):
    ours, theirs = pty.openpty()
    words = [*interpreter.passo(), "panel", "--demo", "--http", "0", "--jobs", str(tmp_path), "--guest", "0"]
    script = f"import os, sys; os.setsid(); import fcntl, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); os.execv({words[0]!r}, {words!r})"
    process = subprocess.Popen([*interpreter.python(), "-c", script], stdin=theirs, stdout=theirs)
    try:
        begun = said(ours, "Ctrl-C")
        assert "token" not in begun
        port = int(re.search(r"socket://127.0.0.1:(\d+)", begun)[1])
        with socket.create_connection(("127.0.0.1", port), LIMIT_S) as client:
            assert ask(client, b"$G\n") == b"ok" and ask(client, b"$LINK=0\n") == b"error:178"
            assert "wants to move the machine" in said(ours, "y/n")
            os.write(ours, answer.encode() + b"\n")
            said(ours, "it may")
            assert ask(client, b"$LINK=0\n") == (b"ok" if answer == "y" else b"error:178")
            assert ask(client, b"$X\n") == (b"ok" if answer == "y" else b"error:178")
    finally:
        process.terminate()
        assert process.wait(30) == 0
        os.close(ours)
        os.close(theirs)


@pytest.mark.unmeasured
def test_let_in_on_the_page(tmp_path):
    with PanelProcess(tmp_path, "--guest", "0") as panel:
        address = ("127.0.0.1", int(panel.guest.rsplit(":", 1)[1]))
        page = panel.page().ready()
        with socket.create_connection(address, LIMIT_S) as client:
            assert ask(client, b"$G\n") == b"ok" and ask(client, b"$LINK=0\n") == b"error:178"
            assert page.said("asks")["name"] == panel.guest
            assert page.order("give", to="guest")["error"] == 0
            stood = page.until(lambda state: state["owner"] == "guest")["m"]
            assert ask(client, b"G91G0X1\n") == b"ok"
        page.until(lambda state: state["state"] == "Idle" and state["m"] != stood)  # states from before the move may still come
        assert page.order("give", to="page")["error"] == 0
        with socket.create_connection(address, LIMIT_S) as client:
            assert ask(client, b"$LINK=0\n") == b"ok", "asked once a start"

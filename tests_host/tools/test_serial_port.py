"""A port belongs to one program: the second gets the first one's name, and the first goes on."""

import os
import subprocess

import pytest

from host_tools import interpreter
from host_tools.cli.keys import Kit
from host_tools.clients import serial_port
from host_tools.clients.grbl import GrblClient
from host_tools.clients.plotter import PlotterClient
from host_tools.clients.pulses import PulsesClient
from host_tools.clients.serial_port import LinkError, open_exclusively, open_port
from host_tools.clients.torch import TorchClient
from host_tools.sim import serial_line

CLIENTS = [PlotterClient, GrblClient, PulsesClient, TorchClient, lambda port: Kit(open_port(port, 9600))]
HOLDER = "import sys; from host_tools.clients.serial_port import *; p = open_exclusively(sys.argv[1], 9600, 1); print(1, flush=True); input()"


@pytest.fixture(params=["pty", "link", "tcp"])
def line(request, tmp_path):
    made = {
        "pty": serial_line.PtyLine, "link": lambda: serial_line.PtyLine(tmp_path / "plotter"), "tcp": lambda: serial_line.TcpLine(0)
    }[request.param]()  # fmt: skip
    yield made
    made.close()


@pytest.fixture
def holder(line):
    """Another process that has the port open."""
    process = subprocess.Popen([*interpreter.python(), "-c", HOLDER, line.name], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"1\n"
    yield process
    process.kill()
    process.communicate()


@pytest.mark.parametrize("client", CLIENTS, ids=["plotter", "grbl", "pulses", "torch", "keys"])
def test_a_port_in_use_is_refused_and_its_user_named(line, holder, client):
    with pytest.raises(LinkError, match=rf"port {line.name} is in use by .*process {holder.pid}\)"):
        client(line.name)


@pytest.mark.parametrize("words, said", [
    ("python3 -P -E -X utf8 -m host_tools.cli draw map.svg", "passo draw map.svg"), ("/usr/bin/python3.11 -m mpremote repl", "mpremote repl"),
    ("python /home/me/.venv/bin/passo stream a.nc", "passo stream a.nc"), ("python -c code", "another program"), ("python", "another program"),
    ("/opt/cncjs -p 1", "cncjs -p 1"),
])  # fmt: skip
def test_a_program_is_named_as_it_was_typed(tmp_path, words, said):
    (tmp_path / "cmdline").write_bytes(words.replace(" ", "\0").encode() + b"\0")
    assert serial_port._command_line(tmp_path) == said


def test_the_first_program_notices_nothing(line):
    first = open_exclusively(line.name, 9600, 1)
    first.write(b"a")
    assert read(line, 1) == b"a"
    for _ in range(3):
        with pytest.raises(LinkError, match="in use by"):
            open_exclusively(line.name, 9600, 1)
    line.read()
    first.write(b"b")
    assert read(line, 1) == b"b"
    line.write(b"c")
    assert first.read(1) == b"c"
    first.close()


def test_a_port_is_free_again_when_it_is_closed_or_its_program_killed(line, holder):
    holder.kill()
    holder.wait()
    for _ in range(2):
        opened = open_exclusively(line.name, 9600, 1)
        opened.close()
        opened.close()


def test_a_port_that_is_not_there_is_not_said_to_be_in_use():
    with pytest.raises(LinkError, match="cannot open port /dev/nowhere: No such file"):
        open_exclusively("/dev/nowhere", 9600, 1)
    with pytest.raises(LinkError, match="cannot open port socket://127.0.0.1:1"):
        open_exclusively("socket://127.0.0.1:1", 9600, 1)
    with pytest.raises(LinkError, match="cannot open port nonsense://x"):
        open_exclusively("nonsense://x", 9600, 1)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="wants to be root")
def test_root_is_stopped_too(line, holder):
    with pytest.raises(LinkError, match="in use by"):
        open_exclusively(line.name, 9600, 1)


def read(line, count):
    data = b""
    for _ in range(200):
        serial_line.wait_for_bytes([line], 10)
        data += line.read()
        if len(data) >= count:
            break
    return data

"""`passo panel --demo` is killed: its virtual board ends too. And its key is in no list of processes."""

import os
import signal
import subprocess
import time

import pytest

from host_tools import interpreter
from host_tools.cli import panel
from host_tools.panel.board import Demo

pytestmark = pytest.mark.unmeasured
PROGRAM = """
import time
from host_tools.panel.board import Demo
demo = Demo("router_3axis")
print(demo.name, demo._process.pid, flush=True)
time.sleep(1000)
"""


def alive(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().split()[2] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="looks at Linux's processes")
def test_the_board_ends_with_its_panel():
    process = subprocess.Popen([*interpreter.python(), "-c", PROGRAM], stdout=subprocess.PIPE, text=True)
    pid = int(process.stdout.readline().split()[1])
    assert alive(pid)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    deadline = time.monotonic() + 30
    while alive(pid):
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_a_demo_is_closed_as_ever():
    demo = Demo("router_3axis")
    pid = demo._process.pid
    demo.close()
    assert not alive(pid)


def test_the_browser_is_given_no_key(monkeypatch, tmp_path):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    panel._open_browser("http://127.0.0.1:8080/#key=ABCD")
    assert len(opened) == 1 and "ABCD" not in opened[0]
    (folder,) = tmp_path.iterdir()
    assert "ABCD" in (folder / "page.html").read_text() and folder.stat().st_mode & 0o077 == 0

"""docs/use/core.md: the Python that it shows prints what it says, and each language answers a plain terminal as its table has it."""

import os
import re
import select
import signal
import subprocess
import time

import pytest

from host_tools import interpreter
from host_tools.resources import ROOT

TEXT = (ROOT / "docs" / "use" / "core.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `(\w+)` \| `talk /tmp/\w+ '(.+?)'` \| `(.+?)`", TEXT, re.MULTILINE)
WANTED = {"router_3axis": b"<Alarm|MPos:0.000,0.000,0.000", "plotter_2014": b"k", "torch_manipulator": b"\xbb" + bytes(8) + b"\xff",
          "lpt_router": b"<state:idle at:0", "two_motor_kit": b"?\0"}  # fmt: skip


def test_the_python_of_the_page():
    code = re.search(r"```python\n(.*?)```", TEXT, re.DOTALL)[1]
    done = subprocess.run([*interpreter.python(), "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == re.search(r"It prints `([01 ]+)`", TEXT)[1], done.stderr


def test_each_language_has_a_row():
    assert {board for board, _, _ in ROWS} == set(WANTED)


@pytest.mark.slow
@pytest.mark.parametrize("board, typed, shown", ROWS)
def test_packets_from_a_plain_terminal(board, typed, shown, tmp_path):
    link = tmp_path / "link"
    words = interpreter.passo("board", "--board", board, "--link", link, "--time", "fast")
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline().startswith("port")
        port = os.open(link, os.O_RDWR | os.O_NOCTTY)
        os.write(port, subprocess.run(["printf", typed], capture_output=True, check=True).stdout)
        heard, deadline = b"", time.monotonic() + 20
        while WANTED[board] not in heard and time.monotonic() < deadline:
            if select.select([port], [], [], 0.5)[0]:
                heard += os.read(port, 200)
        os.close(port)
        assert WANTED[board] in heard
        first = shown.replace("\\|", "|").split("…")[0].split(" …")[0].strip()
        assert first.encode() in heard or first == "273" and heard[0] == 0o273
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(20)
        process.stdout.close()

"""The road of one plain line of G-code, from the link's read to the ring of step words, as docs/inside/architecture.md lists it: no more
than 10 functions. Whatever else is called on the way is named here, too; a new layer fails this test.
"""

import ast
import re
import sys

import pytest
from router import Machine

from host_tools.resources import ROOT

pytestmark = pytest.mark.quick

MOST = 10

# In the order in which they are first called. On a board ChipPort._feed, a timer interrupt, stands in the place of App._make_words,
# and a serial line's read() and write() in that of MemoryLine's.
ROAD = (
    "app.py App.poll",
    "app.py App._read_links",
    "ports/virtual.py MemoryLine.read",
    "app.py App._in_batches",
    "protocols/grbl/protocol.py Grbl.take_batch",
    "protocols/grbl/take_viper.py take_lines",
    "app.py App._make_words",
    "steps/feeder.py Feeder.fill",
    "steps/segments_viper.py make",
    "ports/virtual_player.py Player.start",
)  # fmt: skip
# Machine code: a kernel includes the functions it calls, and one call does the work of several lines or segments.
KERNELS = [name for name in ROAD if "_viper.py" in name]

# What the road asks, once for all lines that a cycle brings: is a `?` among them? Does the machine take lines now, how many, understood by what?
ASKED = {
    "control/line_batches.py LineBatches.open",
    "control/line_batches.py LineBatches.reach",
    "control/queue.py Queue.room",
    "motion/row_viper.py room",
    "protocols/gcode/parser.py GCode.open_rows",
    "protocols/grbl/lines.py buffer_bytes",
    "protocols/grbl/protocol.py Grbl._open_batch",
}
# The answer, and the end of the batch.
ANSWER = {
    "control/line_batches.py LineBatches.close",
    "motion/planner.py Planner.set_power",
    "ports/virtual.py MemoryLine.write",
    "protocols/grbl/protocol.py Grbl.feed",  # is anything left that is no plain line?
}
# The work of every cycle.
CYCLE = {
    "control/controller.py Controller.poll",
    "control/switches.py Switches.look",
    "ports/virtual.py VirtualPort.input",
    "ports/virtual.py VirtualPort.levels",
    "ports/virtual.py VirtualPort.machine_ms",
    "ports/virtual.py VirtualPort.halting_input",
    "protocols/grbl/protocol.py Grbl.pending",
}
# The further work of a cycle while the machine is awake.
AWAKE = {
    "control/controller.py Controller._run_cycle",
    "control/motors.py Motors.poll",
    "control/motors.py Motors.ready",
    "control/program.py Program.poll_end",
    "control/queue.py Queue.still",
    "control/stream_queue.py StreamQueue.begin",
    "control/stream_queue.py StreamQueue.stream",
    "control/tools.py Tools.poll_end",
    "motion/planner.py Planner.start",
    "ports/virtual_player.py Player.words_played",
}
# Of a block that is not behind an accelerated line: the feeder fetches it, once.
FETCH = {
    "steps/feeder.py Feeder._fetch",
    "motion/planner.py Planner.next",
    "motion/row_viper.py take",
    "motion/line.py Steady.moving",
    "motion/ramp.py Ramp.begin",
    "motion/line.py Line.load",
    "motion/speed_viper.py q_of",
}


def calls(action):
    """Names of the firmware's functions that `action()` calls, in order, but for those that a kernel calls."""
    found, kernels = [], []

    def note(frame, event, argument):
        code = frame.f_code
        if "/firmware/passo/" not in code.co_filename or event not in ("call", "return"):
            return
        name = f"{code.co_filename.rpartition('/firmware/passo/')[2]} {code.co_qualname}"
        if event == "return":
            if kernels and kernels[-1] is frame:
                kernels.pop()
        elif not kernels:
            found.append(name)
            if name in KERNELS:
                kernels.append(frame)

    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
    return found


def first_calls(machine):
    """Names of the functions that a line passes until its words are in the ring, each once."""

    def a_line():
        machine.put("G1 X10 Y5\n")
        head = machine.app.ring.head
        for _ in range(3):
            machine.app.poll()
        assert machine.said() == ["ok"] and machine.app.ring.head != head

    return list(dict.fromkeys(calls(a_line)))


@pytest.fixture(scope="module")
def road():
    machine = Machine().ready()
    machine.do("G21 G90 F600", "G1 X1")
    machine.settle()
    return first_calls(machine)


def test_one_line_passes_few_functions(road):
    assert len(ROAD) <= MOST
    assert [name for name in road if name in ROAD] == list(ROAD)


def test_nothing_else_is_called_on_the_way(road):
    assert set(road) - set(ROAD) <= ASKED | ANSWER | CYCLE | AWAKE | FETCH


def test_an_idle_cycle_calls_no_more_than_it_is_said_to():
    machine = Machine().ready()
    machine.settle()
    idle = set(calls(machine.app.poll))
    assert idle - set(ROAD[:3]) == CYCLE and not machine.controller.machine.awake


@pytest.mark.parametrize("name", sorted(ASKED | ANSWER | CYCLE | AWAKE | FETCH))
def test_what_is_named_exists(name):
    path, function = name.split()
    owner, _, method = function.rpartition(".")
    tree = ast.parse((ROOT / "firmware/passo" / path).read_text(encoding="utf-8"))
    body = next(node.body for node in tree.body if getattr(node, "name", "") == owner) if owner else tree.body
    known = {node.name for node in body if isinstance(node, ast.FunctionDef)}
    known |= {alias.name for node in body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert method in known


def test_the_docs_list_it():
    text = (ROOT / "docs/inside/architecture.md").read_text(encoding="utf-8")
    section = text.split("## One G1")[1].split("\n## ")[0]
    listed = re.findall(r"^\| *(\d+) \| `([^`]+)` \| `([^`]+)`", section, re.MULTILINE)
    assert [int(number) for number, _, _ in listed] == list(range(1, len(ROAD) + 1))
    assert [f"{file} {name}" for _, file, name in listed] == list(ROAD)

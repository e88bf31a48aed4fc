"""docs/reference/states.md against the machine: which lines are allowed in which state."""

import re

import pytest

from host_tools.resources import ROOT
from host_tools.sim.machine import VirtualMachine

PAGE = ROOT / "docs" / "reference" / "states.md"
SOON_MS = 60  # an answer that comes later has waited for something


def machine():
    made = VirtualMachine("router_3axis", start=(3000, 3000, -3000), trace=None)
    made.run_ms(40)
    return made


def send(made, data, ms=SOON_MS):
    made.take()
    made.send(data)
    made.run_ms(ms)
    return made.take().decode()


def unlocked():
    made = machine()
    send(made, b"$X\nG91\n")
    return made


def moving(line=b"G1X50F600\n"):
    made = unlocked()
    made.send(line)
    made.run_ms(400)
    return made


def held(how):
    made = moving()
    how(made)
    made.run_ms(900)
    return made


def open_door(made):
    made.plant.set_input(made.port.now, "door", True)


def limit_hit():
    """With hard limits on, a limit switch is hit amid a motion."""
    made = unlocked()
    send(made, b"$21=1\nG1X5F600\n", 100)
    made.plant.inject_noise("limit_y", [made.port.now + 10])
    made.run_ms(100)
    return made


def after(data):
    made = unlocked()
    send(made, data)
    return made


# How the machine comes into each state of the page's rows.
STATES = {
    "Idle": unlocked,
    "Run": moving,
    "Hold": lambda: held(lambda made: made.send(b"!")),
    "Door": lambda: held(open_door),
    "Jog": lambda: moving(b"$J=G91X50F600\n"),
    "Home": lambda: moving(b"$H\n"),
    "Check": lambda: after(b"$C\n"),
    "Sleep": lambda: after(b"$SLP\n"),
    "Alarm, locked": machine,
    "Alarm, limit": limit_hit,
}


# The lines tried, by the page's columns.
LINES = {
    "G-code": b"G0X1\n",
    "jog": b"$J=G91X1F600\n",
    "`$H`": b"$H\n",
    "`$X`": b"$X\n",
    "`$C`": b"$C\n",
    "`$SLP`": b"$SLP\n",
    "`$1=…`": b"$1=200\n",
    "`$$` `$#` `$G`": b"$#\n",
}
KEYS = {"`!`": b"!", "`~`": b"~", "door opens": None, "Ctrl-X": b"\x18"}


def state_of(made):
    made.take()
    made.send(b"?")
    made.run_ms(2)
    found = re.search(r"<(\w+)", made.take().decode())
    return found[1] if found else "-"


def answer(made, line):
    """yes, waits, or the error's number, of one line."""
    said = send(made, line)
    error = re.search(r"error:(\d+)", said)
    return error[1] if error else "yes" if "ok" in said or "Grbl" in said else "waits"


def outcome(state, key):
    """The state that a key leads to, at its end."""
    made = STATES[state]()
    if KEYS[key] is None:
        open_door(made)
    else:
        made.send(KEYS[key])
    made.run_ms(1200)
    return state_of(made)


def tables():
    """[(header, {state: cells})] of the page."""
    found = []
    for block in re.findall(r"(?:^\|.*\n)+", PAGE.read_text(encoding="utf-8"), re.MULTILINE):
        rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in block.splitlines()]
        found.append((rows[0], {row[0]: row[1:] for row in rows[2:]}))
    return found


@pytest.mark.quick
@pytest.mark.parametrize("state", STATES)
def test_lines(state):
    header, rows = tables()[0]
    assert header[1:] == list(LINES) and list(rows) == list(STATES)
    found = []
    for line in LINES.values():
        made = STATES[state]()
        assert state_of(made) == state.partition(",")[0]
        found.append(answer(made, line))
    assert found == rows[state]


@pytest.mark.quick
@pytest.mark.parametrize("state", STATES)
def test_keys(state):
    header, rows = tables()[1]
    assert header[1:] == list(KEYS) and list(rows) == list(STATES)
    assert [outcome(state, key) for key in KEYS] == rows[state]


def test_a_soft_limit_is_told_as_an_alarm_once_it_stands():
    """While it still slows down the machine is no machine in alarm that one may reach into."""
    made = VirtualMachine("router_3axis", start=(3000, 3000, -3000), trace=None)
    made.run_ms(40)
    made.send(b"$20=1\n$H\n")
    made.run_ms(60_000)
    send(made, b"G91\nG1X80F5000\n", 900)
    assert "ALARM:2" in send(made, b"X900\n", 8)
    seen = []
    for _ in range(300):
        before = list(made.plant.position)
        state = state_of(made)
        seen.append((state, before != list(made.plant.position)))
    assert ("Hold", True) in seen and ("Alarm", True) not in seen and seen[-1] == ("Alarm", False), set(seen)

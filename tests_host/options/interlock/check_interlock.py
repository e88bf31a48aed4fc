"""The interlock of a router: it refuses a row's forbidden steps, ends them if they are under way, and allows them again."""

from array import array

from passo.records import (
    COUNT_MASK, FEED_AXES, FEED_NEWEST, FEED_OLDEST, FEED_POSITION, MARKS, MARK_FIELDS, MARK_WORD,
)  # fmt: skip
from passo.options.interlock.steps_viper import INTERLOCK_TOOL, find_ahead, find_denied
from router import Machine, World, answers

INPUTS = [
    {"name": "limit_x", "pin": 9, "active": 1, "pull": "up"},  # homing looks for them: not in the way here
    {"name": "limit_y", "pin": 10, "active": 1, "pull": "up"},
    {"name": "limit_z", "pin": 11, "active": 1, "pull": "up"},
    {"name": "a", "pin": 12, "active": 1, "pull": "up", "filter_us": 100},
    {"name": "b", "pin": 13, "active": 0, "pull": "up", "filter_us": 100},
    {"name": "good", "pin": 18, "active": 1, "pull": "up", "filter_us": 100},
    {"name": "stop", "pin": 27, "active": 1, "pull": "up", "halt": True},
]
TABLE = {
    "rows": {"x+": "!a & good", "x-": "!b & good", "y": "good | !a", "tool": "good & !b", "flood": "good", "enable": "!stop"},
    "limits": {"z-": "a"},
    "release_ms": 10,
}
NAMES = ("a", "b", "good", "stop")
CASES = {
    "check_what_is_forbidden_is_refused": (
        ("states", 0, 7), ("x", -2, 2), ("y", -2, 2), ("z", -2, 2), ("spindle", 0, 1), ("jog", 0, 1),
    ),
    "check_a_change_ends_what_it_forbids": (
        ("which", "choice") + NAMES, ("x", -9, 9), ("y", -9, 9), ("z", -9, 9), ("cycles", 1, 40),
    ),
    "check_denied_is_what_the_table_says": (("products", "list", 9, ("care", 0, 255), ("value", 0, 255), ("bit", 0, 5)), ("states", 0, 255)),
    "check_ahead_is_what_is_not_played": (
        ("moves", "list", 20, ("x", -3, 3), ("y", -3, 3), ("words", 1, 90)), ("played", 0, 2000), ("start", "seed"), ("wanted", 0, 15),
    ),
}  # fmt: skip
RUNS = {"check_what_is_forbidden_is_refused": 60, "check_a_change_ends_what_it_forbids": 60}


class Guarded(World):
    def __init__(self):
        World.__init__(self)
        self.active = {"good": 1}

    def input(self, tick, name):
        if name in NAMES:
            return self.active.get(name, 0) ^ (1 if name == "b" else 0)
        return World.input(self, tick, name)


def guarded(states=4):
    """A machine that is unlocked, with a, b, good as the bits of `states`."""
    world = Guarded()
    for number in range(3):
        world.active[NAMES[number]] = states >> number & 1
    machine = Machine(world, inputs=INPUTS, interlock=TABLE)
    machine.said()
    machine.do("$X", "G91")
    machine.settle()
    return machine


def allowed(active, axis, forward):
    """The rules in Python's words."""
    if active.get("stop"):
        return False
    if axis == 0:
        return bool(active.get("good")) and not active.get("a" if forward else "b")
    if axis == 1:
        return bool(active.get("good")) or not active.get("a")
    return forward or not active.get("a")


def words(steps):
    return "".join(["XYZ"[axis] + str(steps[axis]) for axis in range(3) if steps[axis]])


def check_what_is_forbidden_is_refused(states, x, y, z, spindle, jog):
    machine = guarded(states)
    active = machine.world.active
    if spindle:
        may = active.get("good") and not active.get("b")
        assert answers(machine.ask("M3S900")) == (["ok"] if may else ["error:131"])
        machine.settle()
        assert machine.world.tool == (1 if may else 0)
    steps = x, y, z
    if not any(steps):
        return
    place = machine.world.place[:]
    may = all([not steps[axis] or allowed(active, axis, steps[axis] > 0) for axis in range(3)])
    said = machine.ask(("$J=G91F900" if jog else "G1F900") + words(steps))
    assert answers(said) == (["ok"] if may else ["error:131"]), (states, steps, said)
    machine.settle()
    scale = 320, 320, 400
    assert machine.world.place == [place[axis] + (steps[axis] * scale[axis] if may else 0) for axis in range(3)]
    assert machine.status()["state"] == "Idle"


def check_a_change_ends_what_it_forbids(which, x, y, z, cycles):
    """A change at any time: forbidden steps end with an alarm that names the input, all else goes on; then there is a way out."""
    machine = guarded()
    steps = x, y, z
    if not any(steps):
        return
    place = machine.world.place[:]
    machine.put("G1F1200" + words(steps) + "\n")
    machine.cycles(cycles)
    still = machine.controller.queue.still()
    world = machine.world
    world.active[which] = 0 if which == "good" else 1
    machine.settle()
    machine.cycles(30)
    scale = 320, 320, 400
    wanted = [place[axis] + steps[axis] * scale[axis] for axis in range(3)]
    forbidden = not all([not steps[axis] or allowed(world.active, axis, steps[axis] > 0) for axis in range(3)])
    if which != "stop" and (still or not forbidden):
        assert world.place == wanted and not machine.controller.machine.alarm
    else:
        alarm = machine.controller.machine.alarm
        if alarm:
            assert alarm == (201 if which in ("a", "stop") else 220)
            assert machine.controller.machine.log.entries[-1][2] == which
        else:
            assert world.place == wanted, "only if nothing was left to do"
        position = machine.controller.position()
        assert [position[axis] + place[axis] for axis in range(3)] == world.place, "the position stays exact"
    world.active[which] = 1 if which == "good" else 0
    machine.cycles(60)
    machine.put(b"\x18")
    machine.cycles(3)
    machine.said()
    machine.do("$X", "G91G1F900X1Y1Z1")
    at = world.place[:]
    machine.settle()
    assert [world.place[axis] - at[axis] for axis in range(3)] <= [320, 320, 400]
    assert machine.status()["state"] == "Idle"


def check_an_output_stays_off_until_it_is_asked_for_again():
    machine = guarded()
    machine.do("M8")
    assert machine.world.outputs["flood"] == 1
    machine.world.active["good"] = 0
    machine.cycles(5)
    assert machine.world.outputs["flood"] == 0
    assert machine.controller.machine.log.entries[-1][1:] == (131, "good")
    machine.world.active["good"] = 1
    machine.cycles(60)
    assert machine.world.outputs["flood"] == 0
    machine.do("M9", "M8")
    assert machine.world.outputs["flood"] == 1


def check_the_drives_are_off_with_the_stop_and_wake_again():
    machine = guarded()
    machine.do("G1X1F900")
    machine.settle()
    enabled = machine.world.outputs["enable"]
    machine.world.active["stop"] = 1
    machine.cycles(3)
    assert machine.world.outputs["enable"] == 1 - enabled and machine.controller.machine.alarm == 201
    machine.put(b"\x18")
    machine.cycles(3)
    machine.put(b"$X\nG1X1F900\n")
    machine.cycles(20)
    assert machine.world.outputs["enable"] == 1 - enabled, "not as long as it is pressed"
    machine.world.active["stop"] = 0
    machine.cycles(60)
    machine.put(b"\x18")
    machine.cycles(3)
    machine.said()
    machine.do("$X", "G91G1X1F900")
    machine.settle()
    assert machine.world.outputs["enable"] == enabled


def check_log_and_status_tell_of_the_inputs():
    machine = guarded()
    machine.put("G1F1200X9\n")
    machine.cycles(20)
    machine.world.active["a"] = 1
    machine.settle()
    machine.cycles(20)
    said = [line for line in machine.ask("$LOG") if line[:5] == "[PIN:"]
    assert len(said) == 1 and said[0][:11] == "[PIN:a,1,1," and said[0][-4:] == ",-1]", said
    machine.world.active["a"] = 0
    machine.cycles(100)
    said = [line for line in machine.ask("$LOG") if line[:5] == "[PIN:"][0][1:-1].split(",")
    assert said[1] == "0" and 10 <= int(said[5]) < 1000, said
    machine.port.veto.glitches[3] = 7
    texts = []
    for _ in range(40):
        texts.append(machine.status()["text"])
    assert [text for text in texts if "|Gl:7" in text]


def check_denied_is_what_the_table_says(products, states):
    table = [len(products), 63]
    wanted = 63
    for care, value, bit in products:
        table += [care, value & care, 1 << bit]
        if not (states ^ value) & care:
            wanted &= ~(1 << bit)
    assert find_denied(array("i", table), states) == wanted


def check_ahead_is_what_is_not_played(moves, played, start, wanted):
    """Against a plain look at every segment that is not played to its end."""
    axes = 2
    stride = MARK_FIELDS + axes
    marks = array("i", [0] * (MARKS * stride))
    state = array("i", [0] * (FEED_POSITION + axes))
    state[FEED_AXES] = axes
    oldest = start & COUNT_MASK
    state[FEED_OLDEST] = oldest
    state[FEED_NEWEST] = (oldest + len(moves)) & COUNT_MASK
    word = start * 7 & COUNT_MASK
    place = [0, 0]
    coming = 0
    head = 0
    for number in range(len(moves) + 1):
        at = ((oldest + number) & (MARKS - 1)) * stride
        if number:
            move = moves[number - 1]
            head += move[2]
            for axis in range(axes):
                place[axis] += move[axis]
                if head > played and move[axis]:
                    coming |= (1 if move[axis] > 0 else 2) << 2 * axis
        marks[at + MARK_WORD] = (word + head) & COUNT_MASK
        for axis in range(axes):
            marks[at + MARK_FIELDS + axis] = place[axis]
    found = find_ahead(state, marks, (word + played) & COUNT_MASK, wanted)
    assert found & coming & wanted == found and bool(found) == bool(coming & wanted)
    assert not find_ahead(state, marks, word, INTERLOCK_TOOL)

"""The mill's first test: each contactor and fault, pressed alone, is named in the board's reports; each output is seen to switch.

The plant presses one input after another by --fault's words; contacts that report a good drive go dead instead.
"""

from dataclasses import dataclass

from host_tools import boards
from host_tools.experiments.authors import without_figure
from host_tools.experiments.grbl_talk import RESET, ask_line, wait_up, words_of
from host_tools.experiments.row import Outcome
from host_tools.language import _

GOOD = ("dx1", "dx2", "dy", "dz", "sel")  # active while all is well
FIRST_MS, EACH_MS, HELD_MS, LOOK_MS = 6000, 600, 400, 60
START = 3000, 2500, -1800
SWITCHES = {"vacuum": (b"M10\n", b"M11\n"), "flood": (b"M8\n", b"M9\n"), "mist": (b"M7\n", b"M9\n"), "tool": (b"M3S9000\n", b"M5\n")}


@dataclass
class Pressed:
    """An input that was pressed alone: the name expected in the report, and the names reported."""

    name: str
    expected: str
    reported: str  # while it was pressed
    after: str  # once it was released; "" if nothing

    def is_right(self):
        """True if the report named this input alone while it was pressed, and none afterwards."""
        return self.reported == self.expected and not self.after


class Outputs:
    """Records each change of a plant's outputs in `seen`: {name: [level, …]}."""

    def __init__(self, plant):
        self.seen = {}
        self._heard = plant.output
        plant.output = self.record_change

    def record_change(self, tick, name, level):
        """Record a level of an output, and hand it on to the plant."""
        self.seen.setdefault(name, []).append(level)
        self._heard(tick, name, level)


def name_in_report(board, name):
    """Return the name of an input in a report: an end of an axis has its direction behind it."""
    ends = {sensor: end for end, sensor in board["interlock"]["limits"].items()}
    return f"{name}({ends[name]})" if name in ends else name


def press_inputs(place):
    """Press each input of the mill in turn, and switch its outputs; return (list of Pressed, {output: True if it went on and off})."""
    board = boards.load("mill_2004")
    names = [item["name"] for item in board["inputs"]]
    times = {name: FIRST_MS + EACH_MS * at for at, name in enumerate(names)}
    faults = {name: f"{'dead' if name in GOOD else 'pressed'}@{ms}-{ms + HELD_MS}" for name, ms in times.items()}
    machine = place.create_machine("mill_2004", start=START, trace=None, faults=faults)
    try:
        switched = switch_outputs(machine, board)
        return [_press_input(machine, board, name, times[name]) for name in names], switched
    finally:
        machine.close()


def switch_outputs(machine, board):
    """Return {output: True if it went on and off again at the commands that switch it}; "tool" is the spindle's, "enable" is only looked at."""
    wait_up(machine)
    outputs = Outputs(machine.plant)
    ask_line(machine, b"$X\n")
    found = {}
    for name, (on, off) in SWITCHES.items():
        ask_line(machine, on)
        machine.run_ms(LOOK_MS)
        went_on = _is_on(machine, outputs, board, name)
        ask_line(machine, off)
        machine.run_ms(LOOK_MS)
        found[name] = went_on and not _is_on(machine, outputs, board, name)
    found["enable"] = machine.plant.enabled
    return found


def _is_on(machine, outputs, board, name):
    """True if an output is at its active level, as the plant saw it last."""
    if name == "tool":
        return bool(machine.plant.tool)
    active = {item["name"]: item["active"] for item in board["outputs"]}[name]
    return outputs.seen.get(name, [1 - active])[-1] == active


def _press_input(machine, board, name, begin_ms):
    """Wait until the plant presses an input at `begin_ms`, and again until it is released; return it as a Pressed."""
    machine.run_until(lambda: machine.now_ms() >= begin_ms + LOOK_MS, 2 * FIRST_MS)
    reported = words_of(machine).get("Fb", "")
    machine.run_until(lambda: machine.now_ms() >= begin_ms + HELD_MS + LOOK_MS, 2 * FIRST_MS)
    after = words_of(machine)
    if after["state"].startswith("Alarm"):
        machine.send(RESET)
        machine.run_ms(LOOK_MS)
        ask_line(machine, b"$X\n")
    return Pressed(name, name_in_report(board, name), reported, after.get("Fb", ""))


def run(place):
    """Return the Outcome: each input's name in the reports, and each output's change."""
    pressed, switched = press_inputs(place)
    outcome = Outcome(_("each input pressed alone for {} ms and released; the name in the reports to `?`. Each output switched by its command, and its pin looked at", HELD_MS))
    tells = without_figure("section 2.7.3")
    for each in pressed:
        told = _("reported as {}, and still {} when released", each.reported, each.after) if each.after else _("reported as {}", each.reported or "–")
        outcome.add_row(_("input {}", each.name), tells, None, "", told, each.is_right())
    for name, right in switched.items():
        outcome.add_row(_("output {}", name), tells, None, "", _("on and off") if right and name != "enable" else _("on") if right else _("not seen"), right)
    outcome.add_row(_("inputs named, of {}", len(pressed)), tells, sum(each.is_right() for each in pressed), "")
    return outcome

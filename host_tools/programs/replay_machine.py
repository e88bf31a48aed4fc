"""The machine for which a program is replayed: the facts that it reports, in the form in which the firmware's parser asks for them."""

import re
from dataclasses import dataclass, field
from functools import partial

from host_tools.programs.gcode_time import settings_of
from passo import commands
from passo.control import arcs

NM = 1_000_000  # a millimetre
AXES = "XYZA"
ENDLESS = 4  # bit of Machine.turns


@dataclass
class Machine:
    """The facts that the controller reports."""

    steps_per_mm: list
    top_mm: float  # the highest place of Z, machine coordinates
    homes: bool
    laser: bool
    max_rpm: float
    systems: dict = field(default_factory=dict)  # "G54": mm of each axis
    tools: dict = field(default_factory=dict)  # "T1": mm
    turns: int = 0  # of the fourth axis, as GCode.turns

    @classmethod
    def of_answers(cls, settings, parameters, about=()):
        """Make a Machine of the answers to `$$`, `$#` and `$I`."""
        values = settings_of(settings)
        axes = len([number for number in range(100, 100 + len(AXES)) if number in values])
        rotary = next((line for line in about if line.startswith("[ROTARY:")), "")
        turns = bool(rotary) | (",SHORT" in rotary) << 1 | (ENDLESS if ",ENDLESS" in rotary else 0)
        systems = {name: [float(part) for part in places.split(",")]
                   for name, places in re.findall(r"\[(G5[4-9]|G28|G30):([-\d.,]+)\]", "\n".join(parameters))}  # fmt: skip
        tools = {name: float(length) for name, length in re.findall(r"\[(T\d+):([-\d.]+)\]", "\n".join(parameters))}
        upward = not int(values.get(23, 0)) >> 2 & 1
        top = 0.0 if upward or axes < 3 else values[132]
        return cls(
            [values[100 + axis] for axis in range(axes)], top, values.get(22, 0) > 0, values.get(32, 0) > 0, values.get(30, 1000), systems, tools, turns
        )  # fmt: skip


class Memory:
    """Work offsets as the firmware's Offsets keep them."""

    def __init__(self, machine):
        self._texts = {name: ",".join(str(round(place * NM)) for place in places) for name, places in machine.systems.items()}
        self._texts.update({name: str(round(length * NM)) for name, length in machine.tools.items()})

    def get(self, key):
        return self._texts.get(key)

    def put(self, key, text):
        self._texts[key] = text


class Board:
    """The questions of the parser to a machine."""

    arcs = arcs

    def __init__(self, machine):
        self.steps_per_m = [round(scale * 1000) for scale in machine.steps_per_mm]
        self.target = [0] * len(machine.steps_per_mm)
        self.coolant = 0


def exact_words(board, position, steps, axes):
    """Return the words of a position in steps; of an axis on which the program stands there, its `position` to the nanometre, because an arc that
    closes there is a whole turn."""
    found = ""
    for axis in axes:
        nm = position[axis]
        if round(nm * board.steps_per_m[axis] / (1000 * NM)) != steps[axis]:
            nm = round(steps[axis] * 1e8 / board.steps_per_m[axis]) * 10
        found += f"{AXES[axis]}{nm / NM:.{6 if nm % 10 else 5}f}"
    return found


def commands_of(made):
    """Yield the commands of a line; those of a canned cycle are made one by one."""
    for command in made:
        if command.kind == commands.MORE:
            yield from iter(partial(next, command.value), None)
        else:
            yield command

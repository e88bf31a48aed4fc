"""Faults of the inputs of a virtual machine: `--fault INPUT=KIND@MS-MS`.

    faults = InputFaults(board["inputs"], limits, {"bxb": "pressed@2000-2500", "dx2": "broken"}, random)
    level = faults.faulty_level("bxb", level, tick)        # `level`: without a fault
    faults.moments, faults.bounces                  # parts of a plant; [(input, ticks at which it turns round)]
"""

import random as randomness
import re

from passo.records import REGISTER_BIT

from host_tools.sim.parts import NEVER, TICKS_PER_MS

_FAULT = re.compile(r"(dead|stuck|broken|pressed|bounces)(?:@(\d+)(?:-(\d+))?)?")
_BOUNCES, _BOUNCE_MS = 6, 5  # changes of an input that bounces, and the ms of all


class Fault:
    """A fault of an input: "dead" never reads active, "stuck" and "pressed" always do, "broken" has lost its wire, "bounces" chatters
    for 5 ms. With "@2000" from that virtual millisecond on, with "@2000-2500" until then; "bounces@2000" once, then."""

    def __init__(self, name, text, random):
        parts = _FAULT.fullmatch(text)
        if not parts or parts[1] == "bounces" and not parts[2] or parts[3] and int(parts[3]) <= int(parts[2]):
            raise ValueError(f"fault of {name}: {text!r} is none of dead, stuck, broken, pressed, bounces@MS, each with @MS or @MS-MS behind it")
        self.kind = parts[1]
        self.begin = int(parts[2] or 0) * TICKS_PER_MS
        self.end = int(parts[3]) * TICKS_PER_MS if parts[3] else NEVER
        self._random = random

    def is_present(self, tick):
        """True if the fault is present at `tick`; bounces are changes, which InputFaults makes."""
        return self.kind != "bounces" and self.begin <= tick < self.end

    def bounce_ticks(self):
        """Return the ticks at which the level changes; none if it does not bounce."""
        span = _BOUNCE_MS * TICKS_PER_MS
        return [self.begin + self._random.randint(1, span) for _ in range(_BOUNCES)] if self.kind == "bounces" else []

    def edge_ticks(self):
        """Return the ticks at which the input may change because of the fault."""
        return [tick for tick in (self.begin, self.end) if tick is not NEVER] if self.kind != "bounces" else []


class Moments:
    """When an input may change: `due` is the next of these ticks."""

    def __init__(self, name, ticks):
        self.name = name
        self._ticks = sorted(ticks, reverse=True)
        self.due = NEVER
        self._plan_next()

    def run(self):
        self._ticks.pop()
        self._plan_next()

    def _plan_next(self):
        self.due = self._ticks[-1] if self._ticks else NEVER


class InputFaults:
    def __init__(self, inputs, limits, faults, random):
        """`limits`: names of the inputs that watch an axis. Raises ValueError."""
        self._inputs = {item["name"]: item for item in inputs}
        self._limits = limits
        if unknown := sorted(set(faults) - set(self._inputs)):
            raise ValueError(f"faults: there is no input {', '.join(unknown)}; the machine has {', '.join(self._inputs) or 'none'}")
        own = randomness.Random(random.random()) if faults else None
        self._faults = {name: Fault(name, text, own) for name, text in faults.items()}
        self.moments = [Moments(name, fault.edge_ticks()) for name, fault in self._faults.items() if fault.edge_ticks()]
        self.bounces = [(name, fault.bounce_ticks()) for name, fault in self._faults.items() if fault.kind == "bounces"]

    def faulty_level(self, name, level, tick):
        """Return the level that the firmware reads of an input whose true one is `level`, at `tick`."""
        fault = self._faults.get(name)
        if fault is None or not fault.is_present(tick):
            return level
        if fault.kind == "broken":
            return self._open_level(name)
        active = self._inputs[name].get("active", 1)
        return active if fault.kind in ("stuck", "pressed") else 1 - active

    def _open_level(self, name):
        """Return the level of an input without its wire: that of its own pull-up or pull-down. If the resistor is outside, that of a safe machine: a
        limit reads as hit, and all else as inactive, such as a drive, which is then faulty."""
        item = self._inputs[name]
        if item.get("pull", "up") != "none" and item["pin"] < REGISTER_BIT:
            return int(item.get("pull", "up") == "up")
        return item.get("active", 1) ^ (name not in self._limits)

"""The list of experiments, and how one is run.

    for name in EXPERIMENTS: ...
    run("lines", place)         # an Outcome; Failure if it cannot be measured there
"""

from dataclasses import dataclass
from importlib import import_module

from host_tools.experiments.places import BOARD, EMULATED, VIRTUAL
from host_tools.failure import Failure
from host_tools.language import N_, _


@dataclass(frozen=True)
class Experiment:
    """An experiment: its title, the document that it is of, and the kinds of places at which it can be measured."""

    title: str
    document: str
    kinds: tuple  # of places
    moves: bool = False  # pins of a board are driven


EXPERIMENTS = {
    "lines": Experiment(N_("Integer lines against floating-point lines, computing alone"), "plotter", (VIRTUAL, EMULATED, BOARD)),
    "drawing": Experiment(N_("Drawing times at the motors' pace"), "plotter", (VIRTUAL, EMULATED, BOARD)),
    "arcs": Experiment(N_("Arcs by radius and angle: CORDIC's ends, and the radius on the way"), "mill", (VIRTUAL, EMULATED, BOARD)),
    "inputs": Experiment(N_("Contactors, faults and outputs, one by one"), "mill", (VIRTUAL, EMULATED)),
    "codes": Experiment(N_("Pulse codes, and the bytes of the parallel port"), "pulses", (VIRTUAL, EMULATED, BOARD)),
    "strokes": Experiment(N_("Strokes of 10 to 100 mm, and the wait before them"), "torch", (VIRTUAL, EMULATED)),
    "rates": Experiment(N_("Pulse rates"), "keys", (VIRTUAL, EMULATED, BOARD), moves=True),
    "homing": Experiment(N_("Homing, repeated"), "plotter", (VIRTUAL, EMULATED, BOARD), moves=True),
}


def check_names(names):
    """Return `names` without repetitions, or all experiments. Raises Failure for an unknown one."""
    for name in names:
        if name not in EXPERIMENTS:
            raise Failure("no experiment {}; there are {}", name, ", ".join(EXPERIMENTS))
    return list(dict.fromkeys(names)) or list(EXPERIMENTS)


def why_not_here(name, place):
    """Return the reason why an experiment is left out at a place, a sentence; "" if it is not."""
    experiment = EXPERIMENTS[name]
    if place.kind not in experiment.kinds:
        return _("it needs a machine that the PC can look into: --on virtual or emulated")
    if experiment.moves and not place.moves:
        return _("it moves pins: --moves allows that")
    if place.kind == BOARD and hasattr(experiment_module(name), "why_left_out"):
        return experiment_module(name).why_left_out(place.board_table())
    return ""


def experiment_module(name):
    """Return the module of an experiment."""
    return import_module(f"host_tools.experiments.{name}")


def run(name, place):
    """Run an experiment at a place; return its Outcome. Raises Failure if it cannot be measured there."""
    return experiment_module(name).run(place)

"""The writers of the machine's record (control/state.py): one module beside it for each attribute, but for those named here; and the attributes that languages
may read.
"""

import ast
from collections import defaultdict

import pytest
from goes_with import GONE
from parsed import parse

from host_tools.resources import FIRMWARE

pytestmark = [pytest.mark.quick, pytest.mark.xdist_group("sources")]

# Attributes with several writers, and why.
WRITERS = {
    # a flag that says "poll again", which nobody but the controller takes back
    "awake": {"blackbox", "changeover", "controller", "encoders", "gantry", "host_watch", "independent", "jobs", "journal", "line_batches", "program", "step_program"},
    # the long command: some ends of it are no begin() or finish() of the record
    "command": {"jobs", "program", "resets"},
    # motion of a program and jogs: each way of queueing them says so, the controller notices the stand
    "active": {"line_batches", "program"},
    "fresh": {"line_batches", "program"},
    "jogging": {"controller", "drawing", "independent", "program"},
    # a button may toggle what the program has switched
    "coolant": {"pauses", "tools"},
    # homing finds the position, encoders doubt it
    "homed": {"encoders", "homing"},
    "known": {"encoders", "homing"},
    # STOP and RESET turn an alarm that needs a reset into the lock
    "alarm": {"controller", "resets"},
    # of a board with a drawing or a step program, never both
    "job": {"drawing", "step_program"},
}
# All that a language may know of a machine.
FACE = {
    # its properties
    "about", "arcs", "links", "settings", "steps_per_m",
    # its state and actions
    "alarm", "blocks", "busy_with", "change_setting", "checking", "coolant", "homed", "log", "overrides", "restore_settings", "state", "target",
    # the link that commands, and the link for which a stored job runs
    "commander", "lender",
}  # fmt: skip
_RECORD = ("machine", "self._machine", "self.machine", "self.controller.machine")


def targets(node):
    if isinstance(node, ast.Assign):
        for target in node.targets:
            yield from target.elts if isinstance(target, ast.Tuple) else (target,)
    elif isinstance(node, ast.AugAssign):
        yield node.target


def writers():
    """{attribute: modules of control that assign it}; an option's are named by the option"""
    found = defaultdict(set)
    for path in [*(FIRMWARE / "passo/control").glob("*.py"), *(FIRMWARE / "passo/options").glob("*/control*.py")]:
        for node in ast.walk(parse(path.read_text(encoding="utf-8"))):
            for target in targets(node):
                if isinstance(target, ast.Attribute) and ast.unparse(target.value) in _RECORD:
                    found[target.attr].add(path.stem if path.parent.name == "control" else path.parent.name)
    return found


def test_an_attribute_has_one_writer():
    found = writers()
    assert found["checking"] == {"resets"} and "overrides" in found
    left = {name: modules - GONE for name, modules in WRITERS.items()}
    assert {name: modules for name, modules in found.items() if len(modules) > 1} == {name: modules for name, modules in left.items() if len(modules) > 1}


def faces():
    """{attribute of the record: modules of protocols that name it}. The modules name a page's machine `record`."""
    found = defaultdict(set)
    for path in sorted((FIRMWARE / "passo/protocols").rglob("*.py")):
        names = ("record", "self._record") if path.parent.name == "page" else ("machine", "self._machine", "self.machine", "gcode.machine", "controller.machine")
        for node in ast.walk(parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) in names:
                found[node.attr].add(path.stem)
    return found


def test_languages_know_the_face_of_the_machine_and_no_more():
    found = faces()
    assert {"protocol", "page_machine"} <= found["state"]
    assert set(found) == FACE, {name: found[name] for name in set(found) ^ FACE}

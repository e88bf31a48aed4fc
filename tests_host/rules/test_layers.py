"""The rooms of the firmware and what each may import (docs/inside/architecture.md), read from the source.

One table for the rooms, one for MicroPython's built-ins. A rule that stands in the way is changed there, for all.
"""

import ast
import functools
import re
from importlib import import_module
from pathlib import Path

import pytest
from parsed import parse

from host_tools.build.tree import options_asked

pytestmark = [pytest.mark.quick, pytest.mark.xdist_group("sources")]

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = ROOT / "firmware"
FILES = sorted(path.relative_to(FIRMWARE) for path in FIRMWARE.rglob("*.py"))

# The vocabulary: everybody may name it, and it names nobody.
VOCABULARY = ("passo.records", "passo.commands", "passo.batch", "passo.errors", "passo.arrays")

# The modules of passo that a room may import besides itself.
MAY_IMPORT = {
    "passo": (),
    "records": (),
    "commands": (),
    "batch": (),
    "arrays": (),
    "errors": (),
    "error_texts": ("passo.errors",),
    "drives": (),
    "motion": VOCABULARY,
    "steps": VOCABULARY + ("passo.motion",),
    "protocols": VOCABULARY,
    "config": VOCABULARY + ("passo.steps",),  # a board file's pins and interlock become those of the words
    "control": VOCABULARY + ("passo.config", "passo.motion", "passo.steps"),
    "ports": VOCABULARY + ("passo.steps",),
    "web": VOCABULARY + ("passo.protocols.page",),  # links, whose language that is
    "app": ("passo",),
    "machine_builder": ("passo",),
    "builder": ("passo",),  # of an option
    "run": ("passo",),
    "passo_image": ("passo.ports.rp2",),
    "main": (
        "passo_image", "passo.run", "passo.ports", "board",
    ),
}

# The layer of an option's file, by the first word of its name.
OF_OPTIONS = {
    "manifest": "config", "config": "config", "motion": "motion", "steps": "steps", "control": "control", "drive": "drives", "port": "ports", "language": "protocols", "builder": "builder",
    "words": "config", "commands": "commands", "errors": "errors", "error": "error_texts", "records": "records",
}  # fmt: skip

# These load an option's manifest, its part of a port, and its texts of errors, by the option's key or the name that its manifest writes.
BY_KEY = ("board_error.py", "parts.py", "error_texts.py")

# Shared by languages; otherwise none imports another.
SHARED_PROTOCOLS = ("passo.protocols.gcode", "passo.protocols.words", "passo.protocols.setting_lines", "passo.protocols.typed_words", "passo.protocols.HELLO_WIRE", "passo.protocols.extend_language")

INTEGER_ROOMS = ("motion", "steps")
BUILT_INS = {"micropython", "array", "struct", "time", "gc", "sys", "os", "io", "json", "hashlib", "select", "binascii"}
MORE_BUILT_INS = {
    "ports": {"builtins", "math", "machine", "rp2", "esp32", "uctypes", "errno", "vfs", "sdcard", "deflate"},  # the last is a driver of micropython-lib
    "config": {"deflate"},
    "control": {"math"},
    "passo_image": {"rp2", "uctypes"},
    "web": {"socket", "network"},
}

# A file of these names would hide MicroPython's own module on the board; ports has its rp2 and esp32.
RESERVED = BUILT_INS | set().union(*MORE_BUILT_INS.values()) | {
    "asyncio", "bluetooth", "btree", "builtins", "cmath", "collections", "cryptolib", "deflate", "framebuf", "heapq",
    "mip", "neopixel", "ntptime", "onewire", "platform", "random", "re", "ssl", "string", "tls", "types", "uasyncio",
    "vfs", "_thread",
}  # fmt: skip
PORT_NAMES = {"rp2", "esp32"}

# Rooms that serve every language know none. "pulses" and "keys" are ordinary words: only as a module or a mode's name.
LANGUAGE_FREE = ("motion", "steps", "drives")
LANGUAGE_WORDS = re.compile(r"(?<![a-z])(plotter|torch|grbl|g-?code)(?![a-z])", re.IGNORECASE)
LANGUAGE_NAMES = {"plotter", "torch", "pulses", "keys", "grbl"}

# On the host, only the virtual machine brings a port to the firmware.
HOST_WITH_PORTS = ("host_tools/sim", "host_tools/prove")  # the latter has a board run it


def room_of(path):
    """The name of a firmware file's room: its folder under passo, or the file itself (app, main). That of an option's file is its layer."""
    parts = path.with_suffix("").parts
    if parts in (("passo", "__init__"), ("passo", "options", "__init__")):
        return "passo"
    if parts[:2] == ("passo", "options"):
        return OF_OPTIONS[path.stem.split("_")[0] or "manifest"]
    return parts[1] if parts[0] == "passo" else parts[0]


def imports(source, package):
    """(line, full name) of all that is imported; `from a import b` is a.b, relative imports are resolved by `package`."""
    found = []
    for node in ast.walk(parse(source)):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            base = ".".join(above + ((node.module,) if node.module else ()))
            found += [(node.lineno, f"{base}.{alias.name}") for alias in node.names]
    return found


def option_of(path):
    """The option that a firmware file belongs to, None if to none."""
    return path.parts[2] if path.parts[:2] == ("passo", "options") and len(path.parts) > 3 else None


@functools.cache
def options_open_to(path):
    """Options whose files a firmware file may name: its own, and those that its manifest SHARES; in a language's folder, and in its page, those of its
    OPTIONS and WANTS; core names none."""
    option = option_of(path)
    if path.parts[:2] == ("passo", "protocols") and len(path.parts) == 4:
        language = FIRMWARE / path.parent.parent / (path.stem if path.parts[2] == "page" else path.parts[2]) / "__init__.py"
        return set(options_asked(language.read_text(encoding="utf-8"))) if language.is_file() else set()
    if option is None:
        return set()
    return {option, *import_module(f"passo.options.{option}.manifest").__dict__.get("SHARES", ())}


@functools.cache
def options():
    """Names of all options."""
    return {folder.name for folder in (FIRMWARE / "passo" / "options").iterdir() if (folder / "manifest.py").is_file()}


def words_of_pages(tree):
    """Constants that are words between a page and its server: those of a message, a dict with the key "t", and names of orders, keys whose values are
    functions `_order_…`."""
    found = set()
    for node in [node for node in ast.walk(tree) if isinstance(node, ast.Dict)]:
        is_message = "t" in [getattr(key, "value", None) for key in node.keys]
        for key, value in zip(node.keys, node.values):
            found |= {key, value} if is_message else {key} if getattr(value, "attr", "").startswith("_order_") else set()
    return found


def option_faults(source, path):
    """Names of options in what is none: their keys, imports, and texts such as "passo.options.parking"; in an option imports and such texts of
    another. A page has words of its own: its jobs are files of a PC."""
    allowed = options_open_to(path)
    nodes = [node for node in ast.walk(parse(source)) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    named = imports(source, path.parent.parts) + [(node.lineno, node.value) for node in nodes]
    named = [(line, found) for line, text in named for found in re.findall(r"passo\.options\.(\w+)", text)]
    if option_of(path) is None:
        words = words_of_pages(parse(source))
        named += [(node.lineno, node.value) for node in nodes if node.value in options() and node not in words]
    return [f"{path}:{line}: names the option {name}" for line, name in named if name not in allowed]


def within(name, prefixes):
    return any(name == prefix or name.startswith(prefix + ".") for prefix in prefixes)


def import_faults(source, path):
    """Imports of a firmware file that its room may not make."""
    room = room_of(path)
    own = SHARED_PROTOCOLS + (".".join(path.parts[:3]),) if room == "protocols" else (f"passo.{room}",)
    own += tuple(f"passo.options.{option}" for option in options_open_to(path))
    if option_of(path) and path.stem.startswith("language_"):
        own += ("passo.protocols." + path.stem.partition("_")[2],)  # the language it adds to
    if path.parts[:3] == ("passo", "protocols", "page"):
        own += ("passo.protocols." + path.stem,)  # the language that this page is for
    allowed = MAY_IMPORT.get(room, ()) + own
    built_ins = BUILT_INS | MORE_BUILT_INS.get(room, set())
    faults = []
    for line, name in imports(source, path.parent.parts):
        top = name.split(".")[0]
        if not (within(name, allowed) or top in built_ins and top != "passo"):
            faults.append(f"{path}:{line}: {room} may not import {name}")
    if room not in ("machine_builder", "builder", "run", "main") and path.name not in BY_KEY:
        for node in ast.walk(parse(source)):
            if isinstance(node, ast.Name) and node.id == "__import__":
                faults.append(f"{path}:{node.lineno}: only builders load modules by name")
    return faults


def float_faults(source, path):
    """Places where a float could come into being."""
    faults = []
    for node in ast.walk(parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, (float, complex)):
            faults.append(f"{path}:{node.lineno}: float {node.value}")
        elif isinstance(node, (ast.BinOp, ast.AugAssign)) and isinstance(node.op, ast.Div):
            faults.append(f"{path}:{node.lineno}: true division")
        elif isinstance(node, ast.Name) and node.id in ("float", "complex", "round"):
            faults.append(f"{path}:{node.lineno}: {node.id}")
    return faults


def language_faults(source, path):
    """Places that name a language: in any text, or as a module or the name of a mode."""
    faults = []
    for number, line in enumerate(source.splitlines(), 1):
        faults += [f"{path}:{number}: names {word}" for word in LANGUAGE_WORDS.findall(line)]
    for line, name in imports(source, path.parent.parts):
        if LANGUAGE_NAMES & set(name.split(".")):
            faults.append(f"{path}:{line}: imports {name}")
    for node in ast.walk(parse(source)):
        if isinstance(node, ast.Constant) and node.value in ("pulses", "keys"):
            faults.append(f"{path}:{node.lineno}: names the language {node.value}")
    return faults


def name_faults(path):
    """A module or a folder named like one of MicroPython's own."""
    names = (set(path.with_suffix("").parts) - {option_of(path)}) & RESERVED  # an option is called as its key is
    if room_of(path) == "ports":
        names -= PORT_NAMES
    return [f"{path}: hides MicroPython's {name}" for name in sorted(names)]


def faults_of(path, *rules):
    source = (FIRMWARE / path).read_text(encoding="utf-8")
    return [fault for rule in rules for fault in rule(source, path)]


def report(faults):
    assert not faults, "\n" + "\n".join(faults)


@pytest.mark.parametrize("path", FILES, ids=str)
def test_firmware_file(path):
    room = room_of(path)
    assert room in MAY_IMPORT, f"{path}: no room of this name"
    rules = [import_faults, option_faults]
    rules += [float_faults] * (room in INTEGER_ROOMS) + [language_faults] * (room in LANGUAGE_FREE)
    report(faults_of(path, *rules) + name_faults(path))


@pytest.mark.parametrize("path", sorted((ROOT / "boards").glob("[!_]*.py")), ids=lambda path: path.name)
def test_boards_are_data(path):
    """A docstring and BOARD = a literal, nothing else."""
    body = parse(path.read_text(encoding="utf-8")).body
    assert ast.get_docstring(ast.Module(body, [])), f"{path.name}: no docstring says which machine this is"
    assert len(body) == 2 and isinstance(body[1], ast.Assign), f"{path.name}: more than a docstring and BOARD"
    assert [target.id for target in body[1].targets] == ["BOARD"]
    assert isinstance(ast.literal_eval(body[1].value), dict)


def test_on_the_host_only_the_virtual_machine_imports_ports():
    faults = []
    for path in sorted((ROOT / "host_tools").rglob("*.py")):
        if path.relative_to(ROOT).parent.as_posix() not in HOST_WITH_PORTS:
            found = imports(path.read_text(encoding="utf-8"), path.relative_to(ROOT).parent.parts)
            faults += [f"{path.name}:{line}: imports {name}" for line, name in found if within(name, ["passo.ports"])]
    report(faults)


BROKEN = [
    (import_faults, "passo/motion/line.py", "from passo.steps import word"),
    (import_faults, "passo/motion/line.py", "from ..steps import word"),
    (import_faults, "passo/motion/line.py", "import math"),
    (import_faults, "passo/steps/feeder.py", "import passo.control.tools"),
    (import_faults, "passo/steps/ring.py", "from typing import Any"),
    (import_faults, "passo/control/homing.py", "def home():\n    import machine"),
    (import_faults, "passo/control/homing.py", "from passo.protocols import plotter"),
    (import_faults, "passo/commands.py", "from passo.control import queue"),
    (import_faults, "passo/errors.py", "from passo import commands"),
    (import_faults, "passo/control/homing.py", "from passo import ports"),
    (import_faults, "passo/protocols/plotter/protocol.py", "from passo.control import controller"),
    (import_faults, "passo/protocols/grbl/protocol.py", "from passo.motion.planner import Planner"),
    (import_faults, "passo/protocols/grbl/protocol.py", "from passo.control.queue import Queue"),
    (import_faults, "passo/batch.py", "from passo.protocols import grbl"),
    (import_faults, "passo/protocols/grbl/report.py", "from passo.protocols.plotter import host"),
    (import_faults, "passo/control/point_buffer.py", "__import__('passo.ports.virtual')"),
    (import_faults, "passo/ports/virtual.py", "from passo.control.log import Log"),
    (import_faults, "passo/options/parking/motion.py", "from passo.control import queue"),
    (option_faults, "passo/control/homing.py", "from passo.options.parking import control"),
    (option_faults, "passo/machine_builder.py", "__import__('passo.options.parking.control')"),
    (option_faults, "passo/options/parking/control.py", "from passo.options.drivers import control"),
    (option_faults, "passo/ports/virtual.py", "if board.get('blackbox'): pass"),
    (option_faults, "passo/protocols/page/torch.py", "if board.get('weaving'): pass"),
    (option_faults, "passo/protocols/page/orders.py", "features = {'jobs': board.get('jobs')}"),
    (float_faults, "passo/motion/line.py", "half = 0.5"),
    (float_faults, "passo/motion/line.py", "x = a / b"),
    (float_faults, "passo/motion/line.py", "x = 8\nx /= 2"),
    (language_faults, "passo/steps/feeder.py", "x = 1  # as the Plotter does"),
    (language_faults, "passo/steps/feeder.py", "grbl_mode = 1"),
    (language_faults, "passo/steps/feeder.py", "if mode == 'pulses': pass"),
    (language_faults, "passo/options/coil_drives/drive.py", "from passo.protocols import keys"),
]
SOUND = [
    (import_faults, "passo/steps/feeder.py", "from passo.motion.line import Line\nfrom passo.steps import word"),
    (import_faults, "passo/control/homing.py", "from passo import errors\nimport passo.commands"),
    (import_faults, "passo/motion/arc.py", "from . import line\nfrom array import array"),
    (import_faults, "passo/ports/rp2.py", "import machine, rp2\nfrom passo.steps.word import ahead"),
    (import_faults, "passo/machine_builder.py", "from passo.ports import rp2\n__import__('passo.protocols.keys')"),
    (option_faults, "passo/options/spi_drivers/control.py", "from passo.options.drivers import control"),
    (option_faults, "passo/options/parking/manifest.py", "unfit = board.get('encoders')"),
    (option_faults, "passo/protocols/page/orders.py", "orders = {'jobs': self._order_jobs}\nmessage = {'t': 'jobs', 'jobs': []}"),
    (option_faults, "passo/protocols/torch/__init__.py", "OPTIONS = {'independent': 'passo.options.independent.control'}"),
    (float_faults, "passo/motion/line.py", "half = total // 2"),
    (language_faults, "passo/steps/feeder.py", "pulses = len(table.keys())  # pulses of the STEP pins"),
]


def of_options_here(examples):
    """Examples of rules without those that name an option removed, or a file of a language removed."""
    found = [(each, re.findall(r"options[./](\w+)|board\.get\('(\w+)'\)", f"{each[1]} {each[2]}")) for each in examples]
    return [each for each, named in found if {name for pair in named for name in pair if name} <= options() and has_folder(each[1])]


def has_folder(path):
    """Return whether a file's language is there; True for files of no language."""
    parts = Path(path).parts
    return parts[:2] != ("passo", "protocols") or len(parts) < 4 or (FIRMWARE / Path(*parts[:3])).is_dir()


@pytest.mark.parametrize("rule, path, source", of_options_here(BROKEN))
def test_a_breach_is_found(rule, path, source):
    assert rule(source, Path(path))


@pytest.mark.parametrize("rule, path, source", of_options_here(SOUND))
def test_what_is_allowed_passes(rule, path, source):
    assert rule(source, Path(path)) == []


@pytest.mark.parametrize(
    "path, faulty",
    [("passo/control/machine.py", 1), ("passo/time/x.py", 1), ("passo/ports/rp2/pio.py", 0)],
)
def test_names_of_built_ins_are_refused(path, faulty):
    assert len(name_faults(Path(path))) == faulty


# --- nobody assigns attributes of another room's objects

# Names under which rooms know objects of another one.
OWNERS = {"planner": "motion", "feeder": "steps", "ring": "steps", "player": "ports", "port": "ports"}

# {attribute: why others than its room may assign it}
ASSIGNED = {
    "open": "the feeder's flag, set each cycle, which an interrupt reads: a call would cost 10 µs",
    "brake": "likewise",
    "start": "the interlock looks at words before the player gets them",
}


def assigned(tree):
    """Attributes that a module assigns: (node, True if it is one of self)."""
    for node in ast.walk(tree):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets if isinstance(node, (ast.Assign, ast.AugAssign, ast.AnnAssign)) else ():
            for each in target.elts if isinstance(target, (ast.Tuple, ast.List)) else [target]:
                if isinstance(each, ast.Attribute):
                    yield each, isinstance(each.value, ast.Name) and each.value.id == "self"


def attributes(tree):
    """Names of the attributes that the classes of a module have."""
    found = {node.attr for node, own in assigned(tree) if own}
    for owner in [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]:
        for node in [node for node in owner.body if isinstance(node, ast.Assign)]:
            found |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return found


@functools.cache
def attributes_of_rooms():
    rooms = {}
    for path in FILES:
        rooms.setdefault(room_of(path), set()).update(attributes(parse((FIRMWARE / path).read_text(encoding="utf-8"))))
    return rooms


def assignment_faults(source, path, rooms):
    """Assignments to attributes that no class of this room, or of the vocabulary, has; or of an object that is another's."""
    own = rooms[room_of(path)] | rooms["commands"] | rooms["batch"]
    faults = []
    for node, of_self in assigned(parse(source)):
        name = getattr(node.value, "attr", getattr(node.value, "id", "")).lstrip("_")
        others = OWNERS.get(name, room_of(path)) != room_of(path)
        if not of_self and (others or node.attr not in own) and node.attr not in ASSIGNED:
            faults.append(f"{path}:{node.lineno}: assigns {ast.unparse(node)}")
    return faults


def test_nobody_assigns_another_rooms_attributes():
    rooms = attributes_of_rooms()
    report([fault for path in FILES for fault in faults_of(path, lambda source, path: assignment_faults(source, path, rooms))])


@pytest.mark.parametrize(
    "path, source, faulty",
    [
        ("passo/app.py", "self.controller.machine.alarm = 0", 1),
        ("passo/control/queue.py", "self._planner.ramp = None", 1),
        ("passo/protocols/grbl/protocol.py", "self._machine.homed, x = True, 1", 1),
        ("passo/protocols/gcode/parser.py", "command.tool = True", 0),
        ("passo/control/pauses.py", "machine.hold = 'door'", 0),
    ],
)
def test_a_foreign_assignment_is_found(path, source, faulty):
    assert len(assignment_faults(source, Path(path), attributes_of_rooms())) == faulty


# --- no feature knows another one


def features():
    """Names of the features, by the machine builder's table."""
    source = (FIRMWARE / "passo/machine_builder.py").read_text(encoding="utf-8")
    for node in parse(source).body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "FEATURES":
            return [row.elts[0].value for row in node.value.elts]
    raise AssertionError("the machine builder has no FEATURES")


def feature_faults(source, path, names):
    faults = []
    for line, name in imports(source, path.parent.parts):
        parts = name.split(".")
        if parts[:2] == ["passo", "control"] and parts[2] in names and parts[2] != path.stem:
            faults.append(f"{path}:{line}: a feature imports {name}")
    return faults


def test_no_feature_imports_a_feature():
    names = features()
    assert len(names) > 10
    report([
        fault for name in names
        for fault in faults_of(Path(f"passo/control/{name}.py"), lambda source, path: feature_faults(source, path, names))
    ])  # fmt: skip
    assert feature_faults("from passo.control.tools import OFF", Path("passo/control/program.py"), names)
    assert not feature_faults("from passo.control.queue import Queue", Path("passo/control/program.py"), names)

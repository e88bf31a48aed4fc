"""Rules of the whole house, read from the source: fields of arrays have names, a constant stands in one place, files and functions
stay short, and no module imports one that imports it.

Each table of exceptions says why, or is a list to be emptied: an entry without need is a fault, too.
"""

import ast
import re
from pathlib import Path

import folders
import pytest
from goes_with import GONE
from parsed import Trees

pytestmark = [pytest.mark.quick, pytest.mark.xdist_group("sources")]

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = {path.relative_to(ROOT / "firmware").as_posix(): path for path in (ROOT / "firmware").rglob("*.py")}
HOST_TOOLS = {path.relative_to(ROOT).as_posix(): path for path in (ROOT / "host_tools").rglob("*.py")}
PATHS = {**FIRMWARE, **HOST_TOOLS}
TREES = Trees(PATHS)

MOST_LINES = 400
MOST_LINES_OF_A_FUNCTION = 60
MOST_LINES_OF_A_KERNEL = 40

# Arrays without fields: {(file, name): why a number is an index there}. "" is what an expression gives.
SEQUENCES = {
    ("passo/protocols/torch/frames.py", "data"): "bytes of a frame",
    ("passo/protocols/plotter/protocol.py", "data"): "bytes of a packet",
    ("passo/protocols/torch/protocol.py", "data"): "bytes of a line",
    ("passo/protocols/pulses/protocol.py", "items"): "steps of a line, the last one",
    ("passo/ports/usb_line.py", "byte"): "room for one byte",
    ("passo/ports/usb_line.py", "self._said"): "the first bytes said",
    ("passo/ports/esp32/frames_viper.py", "frames"): "the next frames",
    ("passo/ports/esp32/frames_viper.py", "table"): "frames of 128 levels, and of 128 behind them",
    ("passo/ports/esp32/timer_player.py", "table"): "pins of 128 levels, and of 128 behind them",
    ("passo/options/player_timer/port_rp2.py", "table"): "pins of 128 levels, and of 128 behind them",
    # Pointers to one register, to one pointer, to an object's type, or to a table.
    ("passo/options/spindle_pwm/port_rp2.py", "compare"): "a PWM slice's CC",
    ("passo/ports/rp2/pio_player.py", "abort"): "CHAN_ABORT",
    ("passo/ports/rp2/pio_player.py", ""): "the first run of a table",
    ("passo/ports/rp2/port.py", ""): "GPIO_IN",
    ("passo/ports/rp2/port.py", "inputs"): "GPIO_IN",
    ("passo/options/registers/port_rp2.py", ""): "GPIO_IN",
    ("passo/options/registers/port_rp2.py", "pins"): "GPIO_IN",
    ("passo/options/registers/port_rp2.py", "toggle"): "GPIO_OUT_XOR",
    ("passo/options/output_p/port_rp2.py", ""): "a PIO block's INTE",
    ("passo/options/output_p/port_rp2.py", "pins"): "GPIO_OUT",
    ("passo/options/output_p/port_rp2.py", "toggle"): "GPIO_OUT_XOR",
    ("passo/options/player_timer/port_rp2.py", "pins"): "GPIO_OUT",
    ("passo/options/player_timer/port_rp2.py", "toggle"): "GPIO_OUT_XOR",
}
# To be emptied: files and functions that are too long, and classes that are a file cut at a number.
LONG_FILES = set()
HALF_CLASSES = set()
LONG_FUNCTIONS = {
    "passo/options/step_program/motion_walker.py:_write_steps",
}  # fmt: skip

# {kernel: why it is longer}
LONG_KERNELS = {
    "passo/ports/esp32/frames_viper.py:make": "an ESP32 has viper only: what it counts stays in registers for all frames of a piece",
    "passo/protocols/grbl/text_viper.py:set_lengths": "digits of a number in any of three forms, where viper compiles it from flash",
}


def report(faults):
    assert not faults, "\n" + "\n".join(sorted(faults))


def decorators(function):
    return {getattr(each, "attr", "") for each in function.decorator_list}


# --- (a) no bare index in machine code


def _is_bare(index):
    """A number, or a place with a number added: 3, at + 3, at - 1. Not what masks or scales: n & 7, 2 * n."""
    if isinstance(index, ast.Slice):
        return any(_is_bare(part) for part in (index.lower, index.upper) if part is not None)
    if isinstance(index, ast.UnaryOp):
        return _is_bare(index.operand)
    if isinstance(index, ast.BinOp) and isinstance(index.op, (ast.Add, ast.Sub)):
        return _is_bare(index.left) or _is_bare(index.right)
    return isinstance(index, ast.Constant) and isinstance(index.value, int)


def bare_indices(tree):
    """(line, array, index) of each subscript by number in a function of machine code; "" is an array without a name."""
    found = []
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef) and decorators(function) & {"viper", "native"}:
            for node in ast.walk(function):
                if isinstance(node, ast.Subscript) and _is_bare(node.slice):
                    named = isinstance(node.value, (ast.Name, ast.Attribute))
                    found.append((node.lineno, ast.unparse(node.value) if named else "", ast.unparse(node.slice)))
    return found


def test_no_bare_index_in_a_kernel():
    faults, met = [], set()
    for name in FIRMWARE:
        for line, array, index in bare_indices(TREES[name]):
            met.add((name, array))
            if (name, array) not in SEQUENCES:
                faults.append(f"{name}:{line}: {array or 'an expression'}[{index}]: name the field in records.py")
    faults += [f"{each}: no such index is left" for each in SEQUENCES if each not in met and GONE.isdisjoint(each[0].split("/"))]
    report(faults)


# --- (b) a constant stands in one place


def constants(tree):
    """(name without its underscore, value) of all that a module assigns in capitals and that is a number or a text."""
    found = []
    for node in tree.body:
        if not isinstance(node, ast.Assign) or len(node.targets) > 1:
            continue
        target, value = node.targets[0], node.value
        together = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
        for name, each in zip(target.elts, value.elts) if together else [(target, value)]:
            if isinstance(each, ast.Call) and getattr(each.func, "id", "") == "const":
                each = each.args[0]
            if isinstance(name, ast.Name) and name.id.isupper():
                known = not any(isinstance(part, (ast.Name, ast.Call, ast.Attribute)) for part in ast.walk(each))
                value_of = eval(compile(ast.Expression(each), "constant", "eval"), {}) if known else None
                if isinstance(value_of, (int, str, bytes)) and not isinstance(value_of, bool):
                    found.append((name.id.lstrip("_"), value_of))
    return found


def declared_twice(trees):
    """{(name, value): [modules]} of constants that more than one module assigns. Every room sees records.py, errors.py and
    commands.py, so one place for all can always be found."""
    places = {}
    for path, tree in trees.items():
        for constant in constants(tree):
            places.setdefault(constant, []).append(path)
    return {constant: paths for constant, paths in places.items() if len(paths) > 1}


OF_MANIFESTS = ("HEAP_KB",)  # each manifest states its own option's


def test_no_constant_stands_twice():
    twice = declared_twice({name: TREES[name] for name in FIRMWARE})
    report([f"{name} = {value} stands in {', '.join(paths)}: import it" for (name, value), paths in twice.items() if name not in OF_MANIFESTS])


# --- (c) short files and functions


def lines_of_code(source, tree):
    """Lines without those of docstrings and imports."""
    spared = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            spared |= set(range(node.lineno, node.end_lineno + 1))
        elif isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            spared |= set(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    return source.count("\n") - len(spared)


def test_no_file_is_long():
    long = {name for name, path in PATHS.items() if lines_of_code(path.read_text(encoding="utf-8"), TREES[name]) > MOST_LINES}
    report([f"{name}: more than {MOST_LINES} lines of code" for name in long - LONG_FILES])
    report([f"{name}: is short enough by now" for name in LONG_FILES - long])


def bound(node):
    """Return the names that the body of a class gives to its instances: methods, fields, and attributes that its methods set."""
    found = {each.name for each in node.body if isinstance(each, (ast.FunctionDef, ast.ClassDef))}
    for each in node.body:
        for target in getattr(each, "targets", [getattr(each, "target", None)]):
            found |= {name.id for name in ast.walk(target) if isinstance(name, ast.Name)} if target is not None else set()
    return found | set_of_self(node)


def of_self(node):
    return [each for each in ast.walk(node) if isinstance(each, ast.Attribute) and isinstance(each.value, ast.Name) and each.value.id == "self"]


def set_of_self(node):
    return {each.attr for each in of_self(node) if isinstance(each.ctx, ast.Store)}


def half_classes(trees):
    """{file:class: names} of base classes that read fields of self which they do not set, while a class made of them does. A method that
    every class made of it has is the base's to call."""
    classes, bases = {}, {}
    for name, tree in trees.items():
        homes = {}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                homes.update({alias.asname or alias.name: (node.module.replace(".", "/") + ".py", alias.name) for alias in node.names})
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                homes[node.name] = (name, node.name)
                classes[name, node.name] = node
                bases[name, node.name] = [homes[base.id] for base in node.bases if isinstance(base, ast.Name) and base.id in homes]

    def made_of(each):
        """The methods of each class at the end of a line of heirs, with those of the classes between."""
        heirs = [heir for heir in classes if each in bases[heir]]
        own = {made.name for made in classes[each].body if isinstance(made, ast.FunctionDef)}
        return [own | methods for heir in heirs for methods in made_of(heir)] or [own]

    found = {}
    for each, node in classes.items():
        heirs = [heir for heir in classes if each in bases[heir]]
        known, above = bound(node), list(bases[each])
        while above:
            base = above.pop()
            if base in classes:
                known |= bound(classes[base])
                above += bases[base]
        missing = {read.attr for read in of_self(node)} - known
        names = {field for field in missing if not all(field in made for made in made_of(each))}
        if heirs and names and len(bases[each]) == len(node.bases):  # all that it is made of is known
            found["%s:%s" % each] = sorted(names)
    return found


def test_no_class_is_half_a_class():
    half = half_classes(TREES)
    report([f"{each}: reads {', '.join(names)}, which it does not set" for each, names in half.items() if each not in HALF_CLASSES])
    report([f"{each}: is whole by now" for each in HALF_CLASSES - half.keys()])


def long_functions(tree):
    """Names of functions of more than MOST_LINES_OF_A_FUNCTION lines that are no kernels: machine code is called at a price."""
    return {
        node.name
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and node.end_lineno - node.lineno >= MOST_LINES_OF_A_FUNCTION
        and "viper" not in decorators(node)
    }


def test_no_function_is_long():
    long = {f"{name}:{function}" for name, tree in TREES.items() for function in long_functions(tree)}
    report([f"{each}: more than {MOST_LINES_OF_A_FUNCTION} lines" for each in long - LONG_FUNCTIONS])
    report([f"{each}: is short enough by now" for each in LONG_FUNCTIONS - long])


def long_kernels(tree):
    return {
        node.name
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.end_lineno - node.lineno >= MOST_LINES_OF_A_KERNEL and "viper" in decorators(node)
    }


def test_kernels_are_short():
    long = {f"{name}:{function}" for name in FIRMWARE for function in long_kernels(TREES[name])}
    report([f"{each}: more than {MOST_LINES_OF_A_KERNEL} lines" for each in long - LONG_KERNELS.keys()])
    report([f"{each}: is short enough by now" for each in LONG_KERNELS.keys() - long])


def native_functions():
    """{module of `passo`: names of its native functions}"""
    found = {}
    for name in FIRMWARE:
        for node in ast.walk(TREES[name]):
            if isinstance(node, ast.FunctionDef) and "native" in decorators(node):
                found.setdefault(name.removeprefix("passo/"), set()).add(node.name)
    return found


def test_native_functions_are_listed_with_their_reason():
    text = (ROOT / "docs" / "inside" / "kernels.md").read_text(encoding="utf-8").split("## What is native, and why")[1]
    rows = re.findall(r"^\| `(\S+)` \| (.+?) \| (.+) \|$", text, re.MULTILINE)
    assert {module: set(re.findall(r"`(\w+)`", names)) for module, names, _ in rows} == native_functions()


# --- (d) no circle of imports


def module_of(name):
    return name.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def imports(trees):
    """{module: modules of `trees` that it imports, anywhere in it}"""
    modules = {module_of(name) for name in trees}
    found = {}
    for name, tree in trees.items():
        wanted = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                wanted |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                full = {f"{node.module}.{alias.name}" for alias in node.names}
                wanted |= full & modules or {node.module}
        found[module_of(name)] = wanted & modules - {module_of(name)}
    return found


def circles(imported):
    """Groups of modules each of which can be reached from the others."""
    reach = {}
    for start in imported:
        seen, ahead = set(), [start]
        while ahead:
            for each in imported[ahead.pop()] - seen:
                seen.add(each)
                ahead.append(each)
        reach[start] = seen
    return {tuple(sorted({a} | {b for b in reach[a] if a in reach[b]})) for a in imported if a in reach[a]}


def between_folders(imported, top):
    """Return {folder: folders that its modules import} for the folders under the package `top`; each option is a folder."""
    folders = {}
    for module, others in imported.items():
        names = [tuple(each.split(".")[: 3 if each.startswith("passo.options.") else 2]) for each in (module, *others) if each.startswith(top + ".")]
        if module.startswith(top + "."):
            folders.setdefault(".".join(names[0]), set()).update(".".join(name) for name in names[1:] if name != names[0])
    return folders


def test_no_circle_of_imports():
    report([" and ".join(circle) + " import each other" for circle in circles(imports(TREES))])


def test_no_circle_of_folders():
    """Also where no two modules import each other."""
    folders = {}
    for top in ("host_tools", "passo"):
        folders.update(between_folders(imports(TREES), top))
    report([" and ".join(circle) + " import each other" for circle in circles(folders)])


# --- (e) one home for a name in a module, one room for the feeder's state


def imported_twice(tree):
    """Names that a module binds by more than one import at its top: a build would leave such a constant unfolded."""
    seen, twice = set(), set()
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            names = {alias.asname or alias.name for alias in node.names} - {"*"}
            twice |= names & seen
            seen |= names
    return twice


def test_no_name_is_imported_twice():
    report([f"{name}: imports {each} twice" for name, tree in TREES.items() for each in imported_twice(tree)])


def vague(tree):
    """Names of variables, arguments and functions that are called `place`: an index, a position or a location is meant."""
    names = [getattr(node, key, None) for node in ast.walk(tree) for key in ("id", "arg", "attr", "name")]
    return [name for name in names if isinstance(name, str) and "place" in name.split("_")]


def test_no_name_is_vague():
    report([f"{name}: {each}" for name, tree in TREES.items() if name.startswith("passo/") for each in vague(tree)])


def test_a_vague_name_is_found():
    assert vague(ast.parse("def f(place):\n    self._to_place = place.index")) == ["place", "_to_place", "place"]
    assert not vague(ast.parse("def f(index):\n    return text.replace('place', index)"))


def test_only_steps_knows_the_feeders_state():
    """Geometries and the ramp answer "next segment"; the feeder alone writes its state, its marks and the ring."""
    own = {name for name, _ in constants(TREES["passo/records.py"]) if name.startswith(("FEED_", "MARK_"))}
    faults = []
    for name in FIRMWARE:
        if not name.startswith("passo/steps/") and not re.search(r"/options/\w+/steps", name) and name != "passo/records.py":
            named = {node.id for node in ast.walk(TREES[name]) if isinstance(node, ast.Name)}
            faults += [f"{name}: names {each}" for each in named & own]
    report(faults)


# Modules of constants only: a module that reads many of them may import all.
OF_CONSTANTS = ("passo.records", "passo.protocols.gcode.parse_records", "passo.protocols.grbl.report_records", "passo.ports.rp2.fields",
                "passo.ports.rp2.registers", "passo.options.independent.records", "passo.options.planning_s_curves.records")  # fmt: skip


def star_faults(tree, public):
    """Stars where names should be, and names that a star brings and that the module binds too: which counts would differ between
    interpreters. `public`: {module of constants: its names}."""
    found = []
    stars = [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.names[0].name == "*"]
    brought = [public.get(module, set()) for module in stars]
    read = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    own = {alias.asname or alias.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names}
    own |= {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load)}
    found += [f"all of {module}: name what is wanted" for module in stars if module not in public]
    found += [f"{module}: nothing of it is read" for module, names in zip(stars, brought) if module in public and not names & read]
    for index, names in enumerate(brought):
        found += [f"{name} of {stars[index]} is bound twice" for name in names & read & own.union(*brought[:index])]
    return found


def test_a_star_brings_constants_only():
    public = {}
    for module in OF_CONSTANTS:
        made = TREES[module.replace(".", "/") + ".py"]
        public[module] = {name for name, _ in constants(made)} | {
            target.id for node in made.body if isinstance(node, ast.Assign) for target in node.targets if isinstance(target, ast.Name)
        }  # fmt: skip
        assert not [node for node in made.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))], f"{module}: more than constants"
    report([f"{name}: {fault}" for name in FIRMWARE for fault in star_faults(TREES[name], public)])
    assert star_faults(ast.parse("from a import *\nfrom b import A\nx = A"), {"a": {"A", "B"}}) == ["A of a is bound twice"]
    assert star_faults(ast.parse("from a import *\nfrom b import *\nx = A"), {"a": {"A"}, "b": {"A"}}) == ["A of b is bound twice"]
    assert star_faults(ast.parse("from a import *"), {}) == ["all of a: name what is wanted"]


# --- (f) where tests lie


def misplaced(paths):
    """Faults of the files of tests_host, given from there: modules are imported by bare names, so each name occurs once; both
    interpreters look for check_*.py in properties/ and options/KEY/ only."""
    names = [path.name for path in paths if path.name != "__init__.py"]
    faults = [f"{path}: another file has this name" for path in paths if names.count(path.name) > 1]
    return faults + [f"{path}: belongs into properties/ or options/KEY/" for path in paths
                     if path.name.startswith("check_") and path.parent.as_posix() != "properties" and path.parent.parent.as_posix() != "options"]  # fmt: skip


def test_tests_lie_where_they_are_found():
    tests = ROOT / "tests_host"
    report(misplaced([path.relative_to(tests) for path in tests.rglob("*.py")]))
    keys = {path.name for room in ("options", "protocols") for path in (ROOT / "firmware" / "passo" / room).iterdir() if path.is_dir()}
    assert {path.name for path in folders.OF_OPTIONS} <= keys and len(folders.OF_OPTIONS) > 5
    assert len(misplaced([Path("pico/a.py"), Path("sims/a.py"), Path("sims/check_b.py"), Path("properties/check_c.py"), Path("options/backlash/check_d.py")])) == 3


# --- the rules find what they are for

BARE = """
import micropython
@micropython.viper
def f(rows: ptr32, at: int):
    rows[{}] = 1
"""


@pytest.mark.parametrize("index", ["3", "at + 3", "3 + at", "at - 1", "-1", "at + (FIELD + 1)", "1:2", "0"])
def test_a_bare_index_is_found(index):
    assert [found[:2] for found in bare_indices(ast.parse(BARE.format(index)))] == [(5, "rows")]


@pytest.mark.parametrize("index", ["FIELD", "at + FIELD", "at & 7", "2 * at", "at + FIELD + 2 * axes", "at:FIELD"])
def test_a_named_field_passes(index):
    assert bare_indices(ast.parse(BARE.format(index))) == []


@pytest.mark.parametrize("one, other", [("A = const(5)", "_A = 5"), ("A, B = 1, 2", "B = const(1 + 1)"), ("A = 'x'", "A = 'x'")])
def test_a_constant_that_stands_twice_is_found(one, other):
    assert declared_twice({"one": ast.parse(one), "other": ast.parse(other)})


@pytest.mark.parametrize("one, other", [("A = 5", "A = 6"), ("A = 5", "B = 5"), ("A = 5", "def f():\n    A = 5"), ("A = 5", "A = B")])
def test_constants_of_their_own_pass(one, other):
    assert not declared_twice({"one": ast.parse(one), "other": ast.parse(other)})


@pytest.mark.parametrize("lines, found", [(59, set()), (60, {"f"})])
def test_a_long_function_is_found(lines, found):
    assert long_functions(ast.parse("def f():\n" + "    x = 1\n" * lines)) == found
    assert not long_functions(ast.parse("@micropython.viper\ndef f():\n" + "    x = 1\n" * lines))


def test_a_long_kernel_is_found():
    for lines, found in (39, set()), (40, {"f"}):
        assert long_kernels(ast.parse("@micropython.viper\ndef f():\n" + "    x = 1\n" * lines)) == found


def test_docstrings_and_imports_are_no_code():
    source = '"""One\ntwo."""\n\nfrom a import (\n    b,\n)\n\n\ndef f():\n    """Three."""\n    return b\n'
    assert lines_of_code(source, ast.parse(source)) == 5


HALF = """class A:
    def f(self):
        return self._here + self._there

    def g(self):
        self._here = self.h()
"""
WHOLE = HALF + """
    def h(self):
        self._there = 1
"""
HEIR = """from a import A


class B(A):
    def __init__(self):
        self._there = 1

    def h(self):
        return 2
"""


def test_half_a_class_is_found():
    assert half_classes({"a.py": ast.parse(HALF), "b.py": ast.parse(HEIR)}) == {"a.py:A": ["_there"]}
    assert half_classes({"a.py": ast.parse(WHOLE), "b.py": ast.parse(HEIR)}) == {}
    assert half_classes({"a.py": ast.parse(HALF)}) == {}, "nobody is made of it"
    last = HEIR.replace("a import A", "b import B").replace("class B(A)", "class C(B)")
    between = "from a import A\n\n\nclass B(A):\n    pass\n"
    trees = {"a.py": ast.parse(HALF), "b.py": ast.parse(between), "c.py": ast.parse(last)}
    assert half_classes(trees) == {"a.py:A": ["_there"]}, "h() is a method of the last one"


def test_a_name_imported_twice_is_found():
    assert imported_twice(ast.parse("from a import b\nfrom c import d as b, e")) == {"b"}
    assert not imported_twice(ast.parse("from a import b\nfrom c import b as d\ndef f():\n    from e import b"))


def test_a_circle_is_found():
    trees = {"a/b.py": "from a.c import x", "a/c.py": "from a import d", "a/d.py": "def f():\n    import a.b", "a/e.py": "import a.b"}
    assert circles(imports({name: ast.parse(text) for name, text in trees.items()})) == {("a.b", "a.c", "a.d")}


def test_a_circle_of_folders_is_found():
    trees = {"a/b/x.py": "from a.c.x import n", "a/c/x.py": "n = 1", "a/c/y.py": "import a.b.y", "a/b/y.py": "", "a/d.py": "import a.c.x"}
    imported = imports({name: ast.parse(text) for name, text in trees.items()})
    assert not circles(imported) and circles(between_folders(imported, "a")) == {("a.b", "a.c")}

"""The kernels of the firmware as a library of this PC: CPython calls the largest of them by ctypes, so that a virtual board runs the same C as a
real one.

    use_compiled()              # before a machine is made; True: kernels are C from now on

The same translator as for boards (host_tools/kernels), in front of it kernels/pc.c. The library is made once for each state of the
sources, by cc, gcc, clang or PyPI's ziglang, and kept in ~/.cache/passo/kernels; where there is none of them, or PASSO_PC_KERNELS=plain,
kernels stay Python.

A call by ctypes costs a microsecond or two, which is what a short kernel takes in Python: TAKEN are those that gain. Kernels call each other in C.
An array is passed by its address, read anew at each call because the array may have moved. Other objects are passed by a number; C asks Python for
their attributes by this number.
"""

import array
import ctypes
import hashlib
import importlib.abc
import importlib.machinery
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import types
from functools import lru_cache
from pathlib import Path

from host_tools import interpreter
from host_tools.build.constants import fold_in_place
from host_tools.failure import Failure
from host_tools.kernels import module as modules
from host_tools.kernels import unit as units
from host_tools.kernels.build import RUNTIME
from host_tools.kernels.program import INT, OBJECT, Program
from host_tools.resources import FIRMWARE

CHOICE = "PASSO_PC_KERNELS"  # plain or c
TAKEN = {
    "passo.options.coil_drives.drive_viper.apply",
    "passo.motion.block_viper.plan_block",
    "passo.motion.circle_viper.walk",
    "passo.motion.line_viper.walk",
    "passo.motion.look_ahead_viper.look_back",
    "passo.motion.look_ahead_viper.plan_lines",
    "passo.options.gantry.drive_viper.double_steps",
    "passo.options.independent.motion_viper.walk",
    "passo.protocols.gcode.parse_viper.parse_lines",
    "passo.protocols.grbl.lines.buffer_bytes",
    "passo.protocols.grbl.text_viper.write_form",
    "passo.protocols.plotter.protocol.sift_points",
    "passo.steps.pace_viper.pace",
    "passo.steps.pace_viper.repay",
    "passo.steps.position_viper.find",
    "passo.steps.segments_viper.make",
}
PC = (Path(units.__file__).parent / "pc.c").read_text(encoding="utf-8")
OPTIONS = "-O2 -fno-math-errno -std=gnu11 -fwrapv -fno-strict-aliasing -fPIC -shared -w"
SUFFIX = ".dll" if sys.platform == "win32" else ".so"


def runtime_text():
    """Return the C in front of kernels: pc.c, with the numbers of runtime.c."""
    numbers = RUNTIME.partition("// --- numbers")[2].partition("// --- objects")[0].partition("\n")[2]
    return PC.replace("/* numbers */\n", numbers)


def compiler_command():
    """Return the command of a C compiler for this PC, or None."""
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    return [*interpreter.python(), "-m", "ziglang", "cc", "-fno-sanitize=all"] if importlib.util.find_spec("ziglang") else None


def firmware_texts():
    """Return {path: text} of the firmware, without the ports of chips."""
    paths = [path for path in sorted((FIRMWARE / "passo").rglob("*.py")) if "ports" not in path.parts and not path.name.startswith("port")]
    return {path.relative_to(FIRMWARE).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def compile_library(texts=None, taken=TAKEN):
    """Compile the kernels of `texts`, {path: text}, of which Python calls those in `taken`; default: the firmware's. Return (path of the library, its
    table), or None if this computer has no compiler. Takes seconds the first time. Raises Failure if compiling fails."""
    command = compiler_command()
    if command is None:
        return None
    texts = texts or firmware_texts()
    makers = [path.read_text(encoding="utf-8") for path in sorted(Path(units.__file__).parent.glob("*.*")) if path.is_file()]
    state = hashlib.sha256(repr((texts, sorted(taken), makers, command, OPTIONS, sys.platform, Path(__file__).read_text(encoding="utf-8"))).encode())
    kept = modules.CACHE / f"pc-{state.hexdigest()[:24]}{SUFFIX}"
    table = kept.with_suffix(".json")
    if not kept.is_file() or not table.is_file():
        _make_library(texts, taken, command, kept, table)
    return kept, json.loads(table.read_text(encoding="utf-8"))


def _make_library(texts, taken, command, kept, table):
    """Compile the kernels to `kept`, and write their table as JSON; another process sees both whole or not at all. Raises Failure."""
    program = Program(fold_in_place(texts))
    unit = units.Unit(program, list(program.kernels.values()))
    text = unit.pc_text(runtime_text())
    rows = {
        each.kernel.full: [each.c_name, each.kernel.arguments, each.kernel.returns, each.needs_objects()]
        for each in unit.called if each.kernel.full in taken
    }
    usual = {each.kernel.full: each.wrapper_name() for each in unit.functions.values() if f"const char {each.wrapper_name()}[" in text}
    kept.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=kept.parent) as folder:
        source, made, listed = (Path(folder) / name for name in ("k.c", "k" + SUFFIX, "k.json"))
        source.write_text(text, encoding="utf-8")
        done = subprocess.run([*command, *OPTIONS.split(), "-o", made, source], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            raise Failure("{} does not compile kernels: {}", command[0], done.stdout)
        listed.write_text(json.dumps({"names": unit.names, "kernels": rows, "usual": usual}), encoding="utf-8")
        os.replace(made, kept)
        os.replace(listed, table)


@lru_cache(maxsize=1)
def use_compiled():
    """Let the firmware call kernels in C from now on; call it before machines are made. Returns whether it does."""
    choice = os.environ.get(CHOICE)
    own = [Path(path).resolve() for path in importlib.util.find_spec("passo").submodule_search_locations] == [FIRMWARE / "passo"]
    found = None if choice == "plain" or not own else compile_library()  # a passo of elsewhere has kernels of its own
    if found is None:
        if choice == "c":
            raise Failure("{}=c: there is no C compiler here", CHOICE)
        return False
    kernels = Library(*found)
    finder = Finder(kernels)
    sys.meta_path.insert(0, finder)
    for name in [name for name in sys.modules if finder.names_in(name)]:
        _put_compiled(sys.modules[name], finder.names_in(name), kernels)
    return True


def kernels_of(module, *names):
    """Return a host tool's own kernels, functions of a module by name: those in C if there is a compiler, else the module's; `.compiled` says which.
    The plain ones do the same, some hundred times slower. Raises Failure."""
    return _kernels_of(os.environ.get(CHOICE), module, names)


@lru_cache(maxsize=8)
def _kernels_of(choice, module, names):
    """Return kernels_of() for a choice of the environment; each answer is kept."""
    plain, found = importlib.import_module(module), None
    if choice != "plain":
        taken = {f"{module}.{name}" for name in names}
        found = compile_library({module.replace(".", "/") + ".py": Path(plain.__file__).read_text(encoding="utf-8")}, taken)
    if found is None and choice == "c":
        raise Failure("{}=c: there is no C compiler here", CHOICE)
    if found is None:
        return types.SimpleNamespace(compiled=False, **{name: getattr(plain, name) for name in names})
    made = Library(*found)
    return types.SimpleNamespace(compiled=True, **{name: made.caller_of(f"{module}.{name}", getattr(plain, name)) for name in names})


def _put_compiled(module, names, library):
    """Put compiled kernels into a module of the firmware, and wherever else its own are imported by name."""
    for name in names:
        plain = getattr(module, name)
        made = library.caller_of(f"{module.__name__}.{name}", plain)
        for each in [each for key, each in sys.modules.items() if key.partition(".")[0] == "passo"]:
            vars(each).update({key: made for key, value in vars(each).items() if value is plain})


class Finder(importlib.abc.MetaPathFinder):
    """Finds modules of kernels, and puts compiled ones into them when they have been imported."""

    def __init__(self, library):
        self._library = library

    def names_in(self, module):
        """Return the names of the kernels of a module."""
        return [full.rpartition(".")[2] for full in self._library.kernel_names() if full.rpartition(".")[0] == module]

    def find_spec(self, name, path, target=None):
        """Return the spec of a module that has kernels, with a loader that puts compiled ones into it; None for others."""
        wanted = self.names_in(name)
        spec = importlib.machinery.PathFinder.find_spec(name, path, target) if wanted else None
        if spec is not None:
            spec.loader = _Loader(spec.loader, self._library, wanted)
        return spec


class _Loader(importlib.abc.Loader):
    """Loads a module as `inner` does, and puts compiled kernels into it."""

    def __init__(self, inner, library, names):
        self._inner, self._library, self._names = inner, library, names

    def create_module(self, spec):
        """Create the module as its own loader does."""
        return self._inner.create_module(spec)

    def exec_module(self, module):
        """Run the module, then put compiled kernels into it."""
        self._inner.exec_module(module)
        _put_compiled(module, self._names, self._library)

    def __getattr__(self, name):  # get_source and the like, for tracebacks
        return getattr(self._inner, name)


class Object(ctypes.Structure):
    """object_t of pc.c."""

    _fields_ = [("numbers", ctypes.c_void_p), ("code", ctypes.c_void_p), ("number", ctypes.c_int64)]


_POINTER = ctypes.c_void_p
_OBJECTS = ctypes.POINTER(ctypes.c_void_p)
_CALLBACKS = (
    ctypes.PYFUNCTYPE(_POINTER, _POINTER, ctypes.c_int32),
    ctypes.PYFUNCTYPE(_POINTER, _POINTER, ctypes.c_int32, ctypes.c_int32, _OBJECTS),
    ctypes.PYFUNCTYPE(_POINTER, ctypes.c_int32),
    ctypes.PYFUNCTYPE(_POINTER, _POINTER),
    ctypes.PYFUNCTYPE(ctypes.c_int32, _POINTER),
    ctypes.PYFUNCTYPE(_POINTER, _POINTER),
)
_KEPT = 256  # objects that are remembered


def address_of(numbers):
    """Return the address of the numbers of an array, a bytearray or bytes."""
    if type(numbers) is array.array:
        return numbers.buffer_info()[0]
    if type(numbers) is bytes:
        return ctypes.cast(numbers, ctypes.c_void_p).value
    return ctypes.addressof(ctypes.c_char.from_buffer(numbers))


class Library:
    """The compiled kernels. Only one thread may call them."""

    def __init__(self, path, table):
        """Load the library at `path`. `table`: as compile_library() returns it."""
        self._library = ctypes.PyDLL(str(path))  # which keeps the interpreter's lock: a call is short
        self._names, self._kernels = table["names"], table["kernels"]
        self._usual = {full: ctypes.addressof(ctypes.c_char.in_dll(self._library, name)) for full, name in table["usual"].items()}
        self._codes = {}  # {id of a function: address of its C function}
        self._known = {}  # {id of an object: (the object, what C gets for it)}
        self._raised = None
        self._scratch = ctypes.create_string_buffer(1 << 16)  # an array for C to go on with after a failure
        self._nothing = Object(ctypes.addressof(self._scratch), None, 0)
        self._functions = [
            kind(function)
            for kind, function in zip(_CALLBACKS, (self._get_attribute, self._call_object, self._address_of_object, self._array_at, self._to_int, self._numbers_address))
        ]
        self._context = (ctypes.c_void_p * len(_CALLBACKS))(*[ctypes.cast(each, ctypes.c_void_p).value for each in self._functions])

    def kernel_names(self):
        """Return the full names of kernels that are replaced, or that stand for something if they are given as arguments."""
        return self._kernels.keys() | self._usual.keys()

    def caller_of(self, full, plain):
        """Return the function that replaces a kernel in its module."""
        made = self._make_caller(full) if full in self._kernels else plain
        if full in self._usual:
            self._codes[id(made)] = self._usual[full]
            self._address_of_object(made)
        return made

    def _make_caller(self, full):
        """Return a function of Python that calls a kernel."""
        name, arguments, returns, objects = self._kernels[full]
        function = self._library[f"pc_{name}"]
        function.argtypes = [ctypes.c_void_p] * objects + [ctypes.c_int32 if kind == INT else ctypes.c_void_p for _, kind in arguments]
        function.restype = ctypes.c_int32 if returns else None
        names = ", ".join(argument for argument, _ in arguments)
        form = {INT: "{}", OBJECT: "given({})"}
        given = ", ".join(["context"] * objects + [form.get(kind, "address({})").format(argument) for argument, kind in arguments])
        call = f"function({given})" if returns != "bool" else f"function({given}) != 0"
        body = f"    return {call}\n" if not objects else f"    result = {call}\n    end()\n    return result\n"
        space = {"function": function, "address": address_of, "given": self._address_of_object, "context": self._context, "end": self._end_call}
        exec(f"def {full.rpartition('.')[2]}({names}):\n{body}", space)
        return space[full.rpartition(".")[2]]

    # --- objects

    def _address_of_object(self, value):
        """Return the address of the struct that C gets for an object."""
        found = self._known.get(id(value))
        if found is None:
            found = self._known[id(value)] = value, Object(None, self._codes.get(id(value)), id(value))
        if isinstance(value, (array.array, bytearray)):
            found[1].numbers = address_of(value)
        return ctypes.addressof(found[1])

    def _end_call(self):
        """End a call: forget objects if they are more than _KEPT, and raise the error that a callback has noted."""
        if len(self._known) > _KEPT:
            self._known = {key: each for key, each in self._known.items() if key in self._codes}
        if self._raised is not None:
            raised, self._raised = self._raised, None
            raise raised

    def _object_at(self, pointer):
        """Return the object whose struct is at an address."""
        return self._known[Object.from_address(pointer).number][0]

    def _note_failure(self, error):
        """Keep the error for the end of the call, because C cannot raise; C goes on with the object returned."""
        self._raised = self._raised or error
        return ctypes.addressof(self._nothing)

    def _get_attribute(self, pointer, name):
        """Return the struct's address of an attribute, for C."""
        try:
            return self._address_of_object(getattr(self._object_at(pointer), self._names[name]))
        except Exception as error:
            return self._note_failure(error)

    def _call_object(self, pointer, name, count, arguments):
        """Call an object, or its method, for C (`name` < 0: the object itself); return the struct's address of the result."""
        try:
            function = self._object_at(pointer) if name < 0 else getattr(self._object_at(pointer), self._names[name])
            return self._address_of_object(function(*[self._object_at(arguments[number]) for number in range(count)]))
        except Exception as error:
            return self._note_failure(error)

    def _array_at(self, pointer):
        """Return the struct's address of the array whose numbers lie at `pointer`, for a function of Python."""
        found = [value for value, made in self._known.values() if made.numbers == pointer]
        return self._address_of_object(found[0]) if found else self._note_failure(ValueError("no array lies there"))

    def _to_int(self, pointer):
        """Return an object as C's integer; 0 after an error."""
        try:
            return self._object_at(pointer)
        except Exception as error:
            return self._note_failure(error) & 0

    def _numbers_address(self, pointer):
        """Return the address of an array's numbers, for C; of a scratch array after an error."""
        try:
            return address_of(self._object_at(pointer))
        except Exception as error:
            self._note_failure(error)
            return ctypes.addressof(self._scratch)

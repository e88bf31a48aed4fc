"""The kernels of one board's build: which go together into a module, and the texts without them.

    made = compile_kernels(*fold_both_ways(texts), board, march)     # fold_both_ways() of build/constants.py: private names are still whole
    made.texts, made.modules, made.by       # {path: text}; {path of .mpy: bytes}; names of the compilers, [] is viper
    made.pointers                           # words of machine code that the collector takes for pointers
"""

import ast
import re
from collections import namedtuple
from pathlib import Path

from host_tools.kernels.inline import drop_imports
from host_tools.kernels.module import make_module
from host_tools.kernels.program import Program
from host_tools.kernels.unit import Unit

RUNTIME = (Path(__file__).parent / "runtime.c").read_text(encoding="utf-8")
# Kernels that are loaded together are one module, because calls within it are C's; any other module of Python has one of its own.
STEPS = (
    "passo.steps.segments_viper", "passo.steps.pace_viper", "passo.steps.position_viper", "passo.motion.line_viper", "passo.motion.row_viper",
    "passo.motion.integers", "passo.ports.rp2.pio_player",
    "passo.options.spindle_pwm.steps_viper", "passo.steps.power",
)  # fmt: skip
PLAN = "passo.motion.block_viper", "passo.motion.look_ahead_viper", "passo.motion.ramp", "passo.motion.circle"  # and their imports
# they call kernels of the planner
LINES = "passo.protocols.gcode.", "passo.protocols.grbl.", "passo.control.line_batches", "passo.options.spindle_pwm.language_grbl"
# In a UF2 these kernels are one module, which is copied into memory. The other kernels of `steps`, and those of a laser's dots, stay in flash.
HOT = (
    "passo.motion.block_viper.plan_block", "passo.motion.look_ahead_viper.plan_lines", "passo.motion.ramp_viper.begin", "passo.motion.ramp_viper.cut",
    "passo.options.spindle_pwm.language_grbl.read_dots",
    "passo.protocols.grbl.lines.buffer_bytes", "passo.protocols.grbl.take_viper.take_lines", "passo.steps.pace_viper.repay",
    "passo.steps.power.take_marks", "passo.steps.segments_viper.make",
)  # fmt: skip
LASER = "passo.options.spindle_pwm.steps_viper", "passo.options.spindle_pwm.port_rp2"
STAYING = "calm", "laser"  # modules that run from flash
_IMPORT = re.compile(r"^( *)from (passo[.\w]+) import (\w+(?:, \w+)*)$", re.MULTILINE)
Compiled = namedtuple("Compiled", "texts modules by pointers")


def has_acceleration(board):
    """True if an axis has an acceleration: then the planner is loaded with the feeder."""
    return any("accel_mm_s2" in axis for axis in board.get("axes", ()))


def group_kernels(program, board, left=(), keep=False, frozen=False):
    """Return [(name of a module, its kernels)]. `keep`: include kernels that only other kernels call. `frozen`: group them as the UF2 does, where
    code that runs seldom stays in flash (STAYING)."""
    plan, planned = program.modules_loaded_with(PLAN), has_acceleration(board)

    def group_of(kernel):
        """Return the name of the module that a kernel goes into. In a UF2 a laser's kernels, and those of "steps" that are not HOT, go into the
        modules of STAYING."""
        module = kernel.module
        if frozen and module in LASER:
            return STAYING[1]
        name = module_name(module)
        return STAYING[0] if frozen and name == "steps" and kernel.full not in HOT else name

    def module_name(module):
        if module in STEPS or planned and (module in plan or module.startswith(LINES)):
            return "steps"
        return "plan" if module in plan or module.startswith(LINES) else module.removeprefix("passo.").replace(".", "_")

    uses = program.uses
    found = {}
    for kernel in program.kernels.values():
        if kernel.path not in left and (keep or uses[kernel.full][1]):
            found.setdefault(group_of(kernel), []).append(kernel)
    return sorted(found.items())


def compile_kernels(numbered, texts, board, march, left=(), keep=False, frozen=False):
    """`numbered`: the same texts with numbers for constants, and all other names as they are; `left`: paths of modules that are left
    to viper; `keep`: every kernel can still be called from Python, for tests call each; `frozen`: as in group_kernels()."""
    program = Program(numbered)
    modules, imports, by, inside, pointers = {}, {}, [], set(), 0
    for name, kernels in group_kernels(program, board, left, keep, frozen):
        unit = Unit(program, kernels, name in STAYING)
        made = make_module(unit.text(RUNTIME), unit.names, march)
        if made is None:
            continue
        modules[f"passo/kernels_{name}.mpy"] = made.data
        by += [] if made.by in by else [made.by]
        pointers += made.pointers
        inside |= unit.functions.keys()
        for kernel in kernels:
            imports[kernel.full] = f"from passo.kernels_{name} import {unit.python_name(kernel)} as {kernel.name}\n"
    gone = set() if keep else inside - imports.keys() - _python_still_used(program, inside | imports.keys(), imports)
    made = {path: _thin_text(program, path, text, imports, gone) for path, text in texts.items()}
    if frozen:
        made = {path: _IMPORT.sub(lambda found: _kernel_import(imports, *found.groups()) or found[0], text) for path, text in made.items()}
    return Compiled(made, modules, by, pointers)


def _kernel_import(imports, indent, module, names):
    """Return an import line that fetches kernels from their compiled module, so that the module which defined them is not loaded; None if the line
    also imports anything but kernels."""
    lines = [imports.get(f"{module}.{name}") for name in names.split(", ")]
    return indent + "; ".join(line.strip() for line in lines) if all(lines) else None


def _python_still_used(program, compiled, imports):
    """Return the full names of the kernels whose Python has to stay in the texts, for viper to compile: those that are not in C; those that are in C
    only as another kernel's copy, if Python calls them; and the kernels that these call."""
    uses = program.uses
    found, new = set(), [each for each in program.kernels.values() if each.full not in compiled or each.full not in imports and uses[each.full][1]]
    while new:
        kernel = new.pop()
        if kernel.full not in found:
            found.add(kernel.full)
            new += [called for called in program.kernels_called(kernel) if called.full not in imports]
    return found


def c_of(program, groups, name):
    """Return the C of the kernels whose full name is, or ends in, `.name`; an empty text if there is none."""
    units = [Unit(program, kernels) for _, kernels in groups]
    for unit in units:
        unit.text("")
    found = {full: function.function_text() for unit in units for full, function in unit.functions.items() if f".{full}".endswith(f".{name}")}
    return "".join(found.values()).rstrip()


def _thin_text(program, path, text, imports, gone):
    """Return the text with imports where kernels were; all other lines keep their numbers."""
    module = path.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
    if module not in program.imported:
        return text
    lines = text.splitlines(keepends=True)
    nodes = {f"{module}.{getattr(node, 'name', '')}": node for node in ast.parse(text).body}
    assert {full for full in imports if full.rpartition(".")[0] == module} <= nodes.keys(), f"{path} has other names than its kernels"
    for full, node in nodes.items():
        if isinstance(node, ast.FunctionDef) and (full in imports or full in gone):
            first = min(each.lineno for each in node.decorator_list)
            lines[first - 1 : node.end_lineno] = [imports.get(full, "\n")] + ["\n"] * (node.end_lineno - first)
    drop_imports(program, module, text, lines, gone)
    return "".join(lines)

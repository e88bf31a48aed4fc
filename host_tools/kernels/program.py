"""The kernels of a build: functions in viper's Python, found in the texts of its modules, and the meaning of names in them.

    program = Program(texts)                     # {path: folded text}
    kernel = program.kernels["passo.motion.row_viper.take"]
    program.kernel_of_call(kernel, node)                 # the kernel that a call in it calls, or None
    kernel.kinds                                 # {name: INT, BOOL, OBJECT or a pointer's name}
"""

import ast
import re
from functools import cached_property, lru_cache

from host_tools.failure import Failure

POINTERS = "ptr8", "ptr16", "ptr32"
INT, BOOL, OBJECT = "int", "bool", "object"
ROOT = "isqrt"  # math's: of a number from 0 on, on a PC only
LOOPS = ast.While, ast.For


class Kernel:
    """One function. `path`: of its module's text."""

    def __init__(self, program, module, path, node):
        self.program, self.module, self.path, self.node, self.name = program, module, path, node, node.name
        self.full = f"{module}.{node.name}"
        self.arguments = [(each.arg, ast.unparse(each.annotation) if each.annotation else OBJECT) for each in node.args.args]
        self.returns = ast.unparse(node.returns) if node.returns else None

    def refuse(self, node, what):
        raise Failure("{}:{}: {}(): {}", self.path, getattr(node, "lineno", self.node.lineno), self.name, what)

    @cached_property
    def own_names(self):
        """The names of its arguments and locals."""
        stored = {each.id for each in ast.walk(self.node) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
        return stored | {name for name, _ in self.arguments}

    @cached_property
    def kinds(self):
        """{argument or local: kind}; the kind of a local is that of its first assignment."""
        return self.kinds_in(self.node)

    def kinds_in(self, node):
        """Return {argument or local: kind} of a node that was made from this kernel's."""
        found = dict(self.arguments)
        for node in statements_of(node.body):
            if isinstance(node, ast.Assign):
                for target in node.targets:
                    if isinstance(target, ast.Name):
                        found.setdefault(target.id, self.kind_of(node.value, found))
            elif isinstance(node, ast.For) and isinstance(node.target, ast.Name):
                found.setdefault(node.target.id, INT)
        return found

    def kind_of(self, node, kinds):
        """Return the kind of an expression in this kernel."""
        numbers = dict.fromkeys(self.program.constants.get(self.module, ()), INT)
        return kind_of(node, {**numbers, **kinds}, lambda call: self.program.kernel_of_call(self, call))


def statements_of(body):
    """Yield statements in the order of the text, those within others too."""
    for node in body:
        yield node
        for part in ("body", "orelse"):
            yield from statements_of(getattr(node, part, ()))


def kind_of(node, kinds, kernel_of_call=lambda node: None):
    """Return the kind of an expression: INT, BOOL, OBJECT or a pointer's name. `kinds`: {name: kind}; `kernel_of_call(node)`: the kernel that a call
    calls, or None."""
    if isinstance(node, ast.Name):
        return kinds.get(node.id, OBJECT)
    if isinstance(node, ast.Constant):
        return BOOL if isinstance(node.value, bool) else INT if isinstance(node.value, int) else OBJECT
    if isinstance(node, ast.Call):
        name = node.func.id if isinstance(node.func, ast.Name) else None
        kernel = kernel_of_call(node)
        return INT if name in (INT, ROOT) or kernel and kernel.returns else name if name in POINTERS else OBJECT
    if isinstance(node, ast.Attribute):
        return OBJECT
    if isinstance(node, ast.IfExp):
        return kind_of(node.body, kinds, kernel_of_call)
    if isinstance(node, ast.Compare) or isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return BOOL
    if isinstance(node, ast.BoolOp):
        return kind_of(node.values[0], kinds, kernel_of_call)
    return INT


def is_kernel(node):
    return isinstance(node, ast.FunctionDef) and [ast.unparse(each) for each in node.decorator_list] == ["micropython.viper"]


@lru_cache(maxsize=512)
def tree_of(text):
    """Return the tree of a text; nobody may change it."""
    return ast.parse(text)


class Program:
    def __init__(self, texts):
        self.texts = texts
        self.paths = {path.removesuffix(".py").replace("/", ".").removesuffix(".__init__"): path for path in texts}
        self.kernels, self.imported, self.rebound, self.constants = {}, {}, {}, {}
        for module, path in self.paths.items():
            if "micropython.viper" not in texts[path]:
                continue
            for node in tree_of(texts[path]).body:
                if is_kernel(node):
                    kernel = Kernel(self, module, path, node)
                    self.kernels[kernel.full] = kernel
        for module, path in self.paths.items():
            if any(full.rpartition(".")[0].rpartition(".")[2] in texts[path] for full in self.kernels) or path in self.kernel_paths():
                self._read_module(module, path)

    def kernel_paths(self):
        return {kernel.path for kernel in self.kernels.values()}

    def _read_module(self, module, path):
        """Note a module's imports, the names that its functions bind anew, and its numbers."""
        imported, numbers = self.imported.setdefault(module, {}), self.constants.setdefault(module, {})
        rebound = self.rebound.setdefault(module, set())
        for node in ast.walk(tree_of(self.texts[path])):
            if isinstance(node, ast.ImportFrom) and node.module:
                imported.update({alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names})
            elif isinstance(node, ast.Global):
                rebound.update(node.names)
        for node in tree_of(self.texts[path]).body:
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                value = node.value
                constant = isinstance(value, ast.Call) and ast.unparse(value.func) == "const"
                if constant:
                    value = value.args[0]
                if isinstance(value, ast.UnaryOp) and isinstance(value.op, ast.USub) and isinstance(value.operand, ast.Constant):
                    value = ast.Constant(-value.operand.value)
                if isinstance(value, ast.Constant) and type(value.value) is int and (constant or node.targets[0].id.isupper()):
                    numbers[node.targets[0].id] = value.value

    def kernel_of_name(self, module, node, passed_on=True):
        """Return the kernel for which a name, or `module.name`, stands in a module; `passed_on`: also by way of a module that binds it anew while it
        runs."""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            base = self.imported.get(module, {}).get(node.value.id)
            full = f"{base}.{node.attr}" if base in self.paths else None
        elif isinstance(node, ast.Name):
            full = self.imported.get(module, {}).get(node.id, f"{module}.{node.id}")
        else:
            return None
        seen = set()
        while full and full not in self.kernels:
            if full in seen:
                return None
            seen.add(full)
            owner, _, name = full.rpartition(".")
            if not passed_on and name in self.rebound.get(owner, ()):
                return None
            full = self.imported.get(owner, {}).get(name)
        return self.kernels.get(full)

    def kernel_of_call(self, kernel, node, passed_on=True):
        """Return the kernel that a node calls by its name, or None."""
        if not isinstance(node, ast.Call):
            return None
        if isinstance(node.func, ast.Name) and node.func.id in kernel.own_names:
            return None
        return self.kernel_of_name(kernel.module, node.func, passed_on)

    def kernels_called(self, kernel):
        """Return the kernels that it calls by name."""
        return [called for called in (self.kernel_of_call(kernel, node) for node in ast.walk(kernel.node)) if called]

    def marks_of(self, kernel):
        """Return (arguments shared with interrupts, {argument: the kernel that it usually is}), as comments of the module say."""
        text = self.texts[kernel.path]
        shared = re.search(r"^# Shared with interrupts: (\w+(?:, \w+)*)", text, re.MULTILINE)
        usual = re.findall(r"^# `(\w+)` is usually ([\w.]+)", text, re.MULTILINE)
        return {name for name, _ in kernel.arguments} & set(shared[1].split(", ") if shared else ()), {**dict(usual), **self._usual_of_others.get(kernel.module, {})}

    @cached_property
    def _usual_of_others(self):
        """{module: {argument of its kernels: the kernel that it usually is}}, as the modules of those kernels say: an option's, which the caller does not
        name."""
        found = {}
        for module, path in self.paths.items():
            for name, caller in re.findall(r"^# `(\w+)` of ([\w.]+) is usually this one$", self.texts[path], re.MULTILINE):
                found.setdefault(caller, {})[name] = f"{module}.{name}"
        return found

    def modules_loaded_with(self, modules):
        """Return these modules, and all that they import when they are imported."""
        found, queue = set(), [module for module in modules if module in self.paths]
        while queue:
            module = queue.pop()
            found.add(module)
            for node in tree_of(self.texts[self.paths[module]]).body:
                if isinstance(node, ast.ImportFrom) and node.module:
                    names = {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
                    queue += sorted((names & self.paths.keys()) - found)
        return found

    @cached_property
    def uses(self):
        """{full name of a kernel: (calls by kernels, other uses)}"""
        found = {full: [0, 0] for full in self.kernels}
        for module in self.imported:
            tree = tree_of(self.texts[self.paths[module]])
            calls = {}
            for node in tree.body:
                if is_kernel(node):
                    kernel = self.kernels[f"{module}.{node.name}"]
                    calls.update({id(each.func): kernel for each in ast.walk(node) if self.kernel_of_call(kernel, each, False)})
            names = set()
            for node in ast.walk(tree):
                if isinstance(node, (ast.Name, ast.Attribute)):
                    kernel = self.kernel_of_name(module, node)
                    if kernel and isinstance(node.ctx, ast.Load):
                        found[kernel.full][0 if id(node) in calls else 1] += 1
                    if isinstance(node, ast.Name):
                        names.add(node.id)
            for name in self.imported[module].keys() - names:
                kernel = self.kernel_of_name(module, ast.Name(name))  # imported, to be passed on
                if kernel:
                    found[kernel.full][1] += 1
        return found

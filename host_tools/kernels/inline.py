"""Puts the text of short kernels where other kernels call them: viper's calls cost 15 to 26 µs each, on a chip that has no
other compiler.

    texts = inline_kernels(texts)               # {path: folded text} of a build
    texts = inline_kernels(texts, keep=True)    # the same, and what has been put into others can still be called from Python

A kernel goes into those that call it if it has few statements; a longer one if kernels call it in one place, or only kernels, in few.
A kernel above LARGEST statements, inlined ones included, stays a call: a board needs the memory of a function in one piece.
Its arguments and locals become locals of the caller, `return` an assignment, and values that Python computes before the call become locals. A
kernel that only kernels call is left out of its module then.

A changed kernel goes to the end of its module, so that all other lines keep their numbers.
"""

import ast
import builtins
import copy

from host_tools.kernels.fall_through import FallThrough, assign_node, cast_node, name_node, has_return
from host_tools.kernels.program import INT, LOOPS, OBJECT, POINTERS, Program, statements_of, tree_of

SMALL = 1 << 30
# Statements that a kernel may have to go in anywhere; that it may have if kernels call it in one place; that all copies but the first may
# have, if only kernels call it; and that it may have with all that is in it.
FEW, ONCE, COPIES, LARGEST = 12, 23, 30, 180


def inline_kernels(texts, keep=False):
    """Return {path: text} of a build with short kernels put into those that call them. `keep`: those called by kernels only stay callable from
    Python. Raises Failure if a kernel cannot be inlined, or kernels call each other in a circle."""
    program = Program(texts)
    chosen = _kernels_to_inline(program)
    made, under_way = {}, []

    def inline_calls(kernel):
        """Return the kernel's node with the kernels that it calls inside it."""
        if kernel.full in under_way:
            kernel.refuse(kernel.node, "kernels that call each other in a circle")
        if kernel.full not in made:
            under_way.append(kernel.full)
            made[kernel.full] = Inliner(program, kernel, chosen, inline_calls).inline_node()
            under_way.pop()
        return made[kernel.full]

    for kernel in program.kernels.values():
        inline_calls(kernel)
    out = dict(texts)
    for module in program.imported:
        path = program.paths[module]
        mine = [kernel for kernel in program.kernels.values() if kernel.path == path]
        gone = set() if keep else {full for full, only in chosen.items() if only}
        out[path] = _replace_kernels(program, module, texts[path], mine, made, gone)
    return out


def _kernels_to_inline(program):
    """Return {full name: whether only kernels call it} of the kernels that are inlined."""
    uses, weights, found = program.uses, {}, {}  # weights: statements, with those of the kernels that go in

    def weigh_kernel(kernel):
        """Set the weight of a kernel and of those that it calls, in statements with those put into it; add it to `found` if it is inlined."""
        full, called = kernel.full, program.kernels_called(kernel)
        if full in weights:
            return
        size = weights[full] = sum(1 for _ in statements_of(kernel.node.body))
        for each in called:
            weigh_kernel(each)
        weights[full] += sum(weights[each.full] for each in called if each.full in found)
        calls, others = uses[full]
        little = size <= FEW or calls == 1 and size <= ONCE or not others and (calls - 1) * size <= COPIES
        if calls and little and weights[full] <= LARGEST:
            found[full] = others == 0

    for kernel in program.kernels.values():
        weigh_kernel(kernel)
    return found


def _replace_kernels(program, module, text, kernels, made, gone):
    """Return a module's text with its changed kernels at the end and blank lines in their stead; without the kernels `gone` (full names), and imports
    of these. Other lines keep their numbers."""
    lines = text.splitlines(keepends=True)
    tail = []
    for kernel in kernels:
        node = made[kernel.full]
        if node is kernel.node and kernel.full not in gone:
            continue
        first = min(each.lineno for each in kernel.node.decorator_list)
        lines[first - 1 : kernel.node.end_lineno] = ["\n"] * (kernel.node.end_lineno - first + 1)
        if kernel.full not in gone:
            tail += [f"from {source} import {name}\n" for source, name in sorted(getattr(node, "wants", ()))]
            tail.append("\n\n" + ast.unparse(node) + "\n")
    drop_imports(program, module, text, lines, gone)
    return "".join(lines + tail)


def drop_imports(program, module, text, lines, gone):
    """Change the `lines` of a text so that they do not import the kernels `gone` (full names)."""
    for node in ast.walk(tree_of(text)):
        if isinstance(node, ast.ImportFrom) and node.module:
            left = [alias for alias in node.names if _full_name(program, module, alias) not in gone]
            if len(left) < len(node.names):
                names = ", ".join(alias.name + (f" as {alias.asname}" if alias.asname else "") for alias in left)
                indent = lines[node.lineno - 1][: node.col_offset]
                new = f"{indent}from {node.module} import {names}\n" if left else f"{indent}pass\n"
                lines[node.lineno - 1 : node.end_lineno] = [new] + ["\n"] * (node.end_lineno - node.lineno)


def _full_name(program, module, alias):
    """Return the full name of the kernel that an import brings into `module`; None if it brings none."""
    kernel = program.kernel_of_name(module, ast.Name(alias.asname or alias.name))
    return kernel and kernel.full


def is_int(node):
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == INT and len(node.args) == 1


class AsInt(ast.NodeTransformer):
    """Calls that `wanted` says, as int(…), where their value is used."""

    def __init__(self, wanted):
        self.wanted = wanted

    def visit_Expr(self, node):
        self.generic_visit(node.value)
        return node

    def visit_Call(self, node):
        """Return the call, inside int() if `wanted` says, but not inside two."""
        if is_int(node) and self.wanted(node.args[0]):
            self.generic_visit(node.args[0])
            return node
        self.generic_visit(node)
        return cast_node(INT, node) if self.wanted(node) else node


class Renamed(ast.NodeTransformer):
    """A callee's names as the caller's; `names`: {name: node}."""

    def __init__(self, names):
        self.names = names

    def visit_Name(self, node):
        """Return the caller's node for a callee's name: a name, or a copy of an expression. Other names stay."""
        new = self.names.get(node.id)
        if new is None:
            return node
        return name_node(new.id, isinstance(node.ctx, ast.Store)) if isinstance(new, ast.Name) else copy.deepcopy(new)


class Inliner:
    """Of one kernel, the caller."""

    def __init__(self, program, kernel, chosen, make):
        self.program, self.kernel, self.chosen, self.make = program, kernel, chosen, make
        self.kinds = dict(kernel.kinds)
        self.used = {}  # {kind: locals of it in use}: they serve one call after the other
        self.wants = set()

    def inline_node(self):
        """Return a copy of the kernel's node with calls inlined, and others' results as int(); `wants`: imports that it needs. Returns the node
        itself if there is nothing to change. Raises Failure if a statement cannot be inlined."""
        bare = {id(each) for each in ast.walk(self.kernel.node) if self._stays_a_call(each)}
        bare -= {id(each.args[0]) for each in ast.walk(self.kernel.node) if is_int(each)}
        bare -= {id(each.value) for each in ast.walk(self.kernel.node) if isinstance(each, ast.Expr)}
        if not bare and not self.has_calls(self.kernel.node):
            return self.kernel.node
        node = copy.deepcopy(self.kernel.node)
        node.body = [AsInt(self._stays_a_call).visit(each) for each in self.inline_statements(node.body)]
        node.wants = self.wants
        return ast.fix_missing_locations(node)

    def _callee_of(self, node):
        called = self.program.kernel_of_call(self.kernel, node, False)
        return called if called and called.full in self.chosen else None

    def _stays_a_call(self, node):
        """True if a node is a call that is not inlined and returns a number: viper takes its result for an object."""
        called = self.program.kernel_of_call(self.kernel, node)
        return called and called.returns and not self._callee_of(node)

    def has_calls(self, node):
        return node is not None and any(self._callee_of(each) for each in ast.walk(node))

    def kind_of(self, node):
        return self.kernel.kind_of(node, self.kinds)

    def new_local(self, kind):
        """Return a new local's name, `_KIND_N`, and note its kind."""
        number = self.used[kind] = self.used.get(kind, 0) + 1
        made = f"_{kind}_{number}"
        self.kinds[made] = kind
        return made

    def store_value(self, node, out):
        """Store the value in a new local; return its name."""
        kind = self.kind_of(node)
        made = self.new_local(kind)
        out.append(assign_node(made, node))
        return name_node(made)

    # --- statements

    def inline_statements(self, nodes):
        """Return the statements with calls inlined; the locals made for one serve the next again."""
        out = []
        for node in nodes:
            before = dict(self.used)
            out += self.inline_statement(node)
            self.used = before
        return out

    def inline_statement(self, node):
        """Return the statements in place of one: those that must run before it, then it itself. Raises Failure at a loop's else, and at a call in an
        index that is read and written."""
        if isinstance(node, LOOPS) and node.orelse:
            self.kernel.refuse(node, "a loop's else; use a variable")
        out = []
        if isinstance(node, ast.While):
            test = self.inline_expression(node.test, out)
            if out:
                out.append(ast.If(ast.UnaryOp(ast.Not(), test), [ast.Break()], []))
                return [ast.While(ast.Constant(1), out + self.inline_statements(node.body), [])]
            return [ast.While(test, self.inline_statements(node.body), [])]
        if isinstance(node, ast.If):
            test = self.inline_expression(node.test, out)
            return [*out, ast.If(test, self.inline_statements(node.body), self.inline_statements(node.orelse))]
        if isinstance(node, ast.For):
            limits = self.inline_expression(node.iter, out)
            return [*out, ast.For(node.target, limits, self.inline_statements(node.body), [], lineno=1)]
        if isinstance(node, ast.AugAssign) and self.has_calls(node):
            read = copy.deepcopy(node.target)
            read.ctx = ast.Load()
            if self.has_calls(read):
                self.kernel.refuse(node, "a call in an index that is read and written; use a variable for the index")
            node = ast.Assign([node.target], ast.BinOp(read, node.op, node.value), lineno=node.lineno)
        if isinstance(node, ast.Assign):
            return self.inline_assignment(node, out)
        if isinstance(node, ast.Expr) and self._callee_of(node.value):
            self.expand_call(node.value, out, None)
            return out or [ast.Pass()]
        if isinstance(node, (ast.Expr, ast.Return)) and node.value is not None:
            node.value = self.inline_expression(node.value, out)
        return [*out, node]

    def inline_assignment(self, node, out):
        """Return the statements in place of an assignment, behind those of `out`. A call's result goes straight to a single name, without int();
        calls in targets run after the value."""
        target, value = node.targets[0], node.value
        inner = value
        while is_int(inner):
            inner = inner.args[0]
        if len(node.targets) == 1 and isinstance(target, ast.Name) and self._callee_of(inner):
            self.expand_call(inner, out, target.id)
            return out
        node.value = self.inline_expression(value, out)
        if any(self.has_calls(each) for each in node.targets):
            node.value = self.store_value(node.value, out)
            node.targets = [self.inline_expression(each, out) for each in node.targets]
        return [*out, node]

    # --- expressions

    def inline_expression(self, node, out):
        """Return the expression without calls of chosen kernels; the statements that must run before it go to `out`."""
        if not self.has_calls(node):
            return node
        if self._callee_of(node):
            return name_node(self.expand_call(node, out, ""))
        if is_int(node) and self._callee_of(node.args[0]):
            return self.inline_expression(node.args[0], out)
        if isinstance(node, ast.BoolOp):
            return self.inline_logical(node, out)
        if isinstance(node, ast.IfExp):
            test = self.inline_expression(node.test, out)
            made = self.new_local(INT)
            sides = []
            for side in (node.body, node.orelse):
                inside = []
                value = self.inline_expression(side, inside)
                sides.append([*inside, assign_node(made, value)])
            out.append(ast.If(test, *sides))
            return name_node(made)
        if isinstance(node, ast.Compare):
            if any(self.has_calls(each) for each in node.comparators[1:]):
                self.kernel.refuse(node, "a call behind a second comparison; compare one after the other")
            node.left, *node.comparators = self.in_order([node.left, *node.comparators], out)
        elif isinstance(node, ast.BinOp):
            node.left, node.right = self.in_order([node.left, node.right], out)
        elif isinstance(node, ast.UnaryOp):
            node.operand = self.inline_expression(node.operand, out)
        elif isinstance(node, ast.Subscript):
            node.value, node.slice = self.in_order([node.value, node.slice], out)
        elif isinstance(node, ast.Call):
            node.args = self.in_order(node.args, out)
        else:
            self.kernel.refuse(node, f"a call within {ast.unparse(node)[:60]}")
        return node

    def in_order(self, nodes, out):
        """Return expressions in Python's order of evaluation: a value that a later call could change is stored in a local before it."""
        made = []
        for number, node in enumerate(nodes):
            node = self.inline_expression(node, out)
            stable = all(isinstance(each, (ast.Name, ast.Constant, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop, ast.expr_context)) for each in ast.walk(node))
            if not stable and any(self.has_calls(each) for each in nodes[number + 1 :]):
                node = self.store_value(node, out)
            made.append(node)
        return made

    def inline_logical(self, node, out):
        """Inline `a and f(b)` as a condition: f is called only if Python would call it."""
        made = self.new_local(INT)
        both = isinstance(node.op, ast.And)
        inside = [assign_node(made, ast.Constant(int(both)))]
        for value in reversed(node.values):
            before = []
            test = self.inline_expression(value, before)
            inside = [*before, ast.If(test if both else ast.UnaryOp(ast.Not(), test), inside, [])]
        out += [assign_node(made, ast.Constant(int(not both))), *inside]
        return name_node(made)

    # --- a call

    def expand_call(self, node, out, result):
        """Append the called kernel's statements to `out`; return the name of the local with its result. `result`: that name, "" for a new one, None
        if it is not wanted."""
        callee = self._callee_of(node)
        if node.keywords or len(node.args) != len(callee.arguments):
            self.kernel.refuse(node, f"{callee.name}() takes {len(callee.arguments)} arguments, by their places")
        body = copy.deepcopy(self.make(callee))
        kinds = callee.kinds_in(body)
        if result == "":
            if not callee.returns:
                self.kernel.refuse(node, f"{callee.name}() returns nothing")
            result = self.new_local(INT)
        before = dict(self.used)
        stores = {each.id for each in ast.walk(body) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
        names = {}
        values = self.in_order(node.args, out)
        named = [each.id for value in values for each in ast.walk(value) if isinstance(each, ast.Name)]
        for (argument, kind), given in zip(callee.arguments, values):
            known = self.kind_of(given)
            fits = known == kind or kind == OBJECT
            if not fits and known in POINTERS:
                self.kernel.refuse(node, f"{ast.unparse(given)} is {known}, {callee.name}() wants {kind}")
            kept = isinstance(given, ast.Name) and given.id == result and named.count(result) == 1  # `x = f(x)`: x is over with
            plain = isinstance(given, (ast.Name, ast.Constant)) and (argument not in stores or kept)
            if not (fits and plain):
                local = self.new_local(kind)
                out.append(assign_node(local, given if fits else cast_node(kind, given)))
                given = name_node(local)
            names[argument] = given
        last = body.body[-1]
        alone = isinstance(last, ast.Return) and not has_return(body.body[:-1]) and isinstance(last.value, ast.Name)
        if alone and result and result not in named and kinds.get(last.value.id) == INT and last.value.id not in names:
            names[last.value.id] = name_node(result)  # the returned local is the result itself
            body.body.pop()
        for local, kind in kinds.items():
            if local not in names:
                names[local] = name_node(self.new_local(kind))
        names.update(self._global_nodes(callee, body, names))
        statements = [each for each in body.body if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))]
        statements = [Renamed(names).visit(each) for each in statements]
        out += FallThrough(self, result).flatten_returns(statements) or [ast.Pass()]
        self.wants |= getattr(body, "wants", set())
        self.used = before
        if result:
            self.kinds.setdefault(result, INT)
        return result

    def _global_nodes(self, callee, body, names):
        """Return {name: node} of the callee's module globals, as the caller's module reads them."""
        module, mine = callee.module, self.kernel.module
        numbers = self.program.constants[module]
        found = {}
        reads = {each.id for statement in body.body for each in ast.walk(statement) if isinstance(each, ast.Name)}
        for each in reads - names.keys() - set(dir(builtins)) - set(POINTERS) - {"uint", "micropython"}:
            if each in numbers:
                large = not -SMALL <= numbers[each] < SMALL  # an object, as mpy-cross sees it
                found[each] = cast_node(INT, ast.Constant(numbers[each])) if large else ast.Constant(numbers[each])
            elif module != mine:
                source, _, original = self.program.imported[module].get(each, f"{module}.{each}").rpartition(".")
                if self.program.imported[mine].get(each) != f"{source}.{original}":
                    if each in self.program.imported[mine] or original != each:
                        self.kernel.refuse(callee.node, f"{callee.full}() reads {each}, which is something else here")
                    self.wants.add((source, each))
        return found

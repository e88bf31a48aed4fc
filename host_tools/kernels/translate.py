"""A kernel as C. docs/inside/kernels.md says which Python is accepted, and how it works.

    function = unit.function(kernel)    # of unit.Unit, which has those that it calls
    function.function_text(), function.wrapper_text() # C; the wrapper is what Python calls

Numbers are int32_t and wrap, arrays are pointers, all else is an object. A name has the kind of its first assignment. Operations that C may leave
undefined are functions of runtime.c: division, and shifts by a variable. A kernel that works with objects has the module's
table of the interpreter's functions as its first argument, `at`; the others are plain C.
"""

import ast

from host_tools.kernels.program import BOOL, INT, OBJECT, POINTERS, ROOT, kind_of

BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^"}
FUNCTION = {ast.FloorDiv: "divided", ast.Mod: "modulo", ast.LShift: "left", ast.RShift: "right"}
COMPARE = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
C_TYPE = {INT: "int32_t ", BOOL: "int32_t ", OBJECT: "object_t ", "ptr8": "uint8_t *", "ptr16": "uint16_t *", "ptr32": "int32_t *"}


class Function:
    """One kernel on its way to C."""

    def __init__(self, unit, kernel):
        self.unit, self.kernel, self.program = unit, kernel, unit.program
        self.kinds, self.refuse = dict(kernel.kinds), kernel.refuse
        self.c_name = kernel.full.removeprefix("passo.").replace(".", "_")
        self.shared, self.usual = unit.program.marks_of(kernel)
        self.numbers = dict.fromkeys(self.program.constants.get(kernel.module, ()), INT)
        self.other_names = {}  # {local: the kernel that it stands for}
        self.hardware = set()  # pointers made of numbers
        self.array_of = {}  # {object: the pointer to its numbers}
        self._learn_kinds()
        self.with_objects = None  # until it is known

    def _learn_kinds(self):
        """Note the locals that stand for kernels, and the pointers to hardware or to arrays shared with interrupts. Raises Failure if arguments have
        defaults or stars, or a type that kernels have not."""
        arguments, asked = [name for name, _ in self.kernel.arguments], self.kernel.node.args
        if asked.vararg or asked.kwarg or asked.kwonlyargs or asked.posonlyargs or asked.defaults:
            self.refuse(self.kernel.node, "arguments have names and no defaults: write kernel(a: int, b: ptr32)")
        if self.kernel.returns not in (None, INT, BOOL):
            self.refuse(self.kernel.node, f"returns {self.kernel.returns}: write -> int, -> bool or nothing")
        for name, kind in self.kernel.arguments:
            if kind not in C_TYPE:
                self.refuse(self.kernel.node, f"{name}: {kind}; arguments are int, ptr8, ptr16, ptr32, or objects without a type")
        for node in ast.walk(self.kernel.node):
            if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name):
                continue
            name, value = node.targets[0].id, node.value
            kernel = self.program.kernel_of_name(self.kernel.module, value) if not isinstance(value, ast.Name) or value.id not in self.kinds else None
            if kernel:
                self.other_names[name] = kernel
                self.kinds.pop(name, None)
            elif self.kinds[name] in POINTERS and isinstance(value, ast.Call):
                source = value.args[0]
                if self.kind_of(source) in (INT, BOOL):
                    self.hardware.add(name)
                elif isinstance(source, ast.Name) and source.id in arguments and self.kind_of(source) == OBJECT:
                    self.array_of[source.id] = name
                    if source.id in self.shared:
                        self.shared.add(name)

    def kind_of(self, node):
        return kind_of(node, {**self.numbers, **self.kinds}, self.kernel_of_call)

    def kernel_of_call(self, node):
        """Return the kernel that a call calls, also by another name; or None."""
        if isinstance(node.func, ast.Name) and node.func.id in self.other_names:
            return self.other_names[node.func.id]
        return self.program.kernel_of_call(self.kernel, node)

    def is_volatile(self, name):
        return name in self.shared or name in self.hardware

    # --- expressions

    def condition_text(self, node):
        """Return the C of a condition, in which `and`, `or` and `not` may stand."""
        if isinstance(node, ast.BoolOp):
            return "(" + (" && " if isinstance(node.op, ast.And) else " || ").join(map(self.condition_text, node.values)) + ")"
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return f"!{self.condition_text(node.operand)}"
        if self.kind_of(node) == OBJECT:
            self.refuse(node, f"{ast.unparse(node)} is an object: write int(…), or compare")
        return self.value_text(node)

    def number_text(self, node):
        if self.kind_of(node) not in (INT, BOOL):
            self.refuse(node, f"{ast.unparse(node)} is no number: write int(…)")
        return self.value_text(node)

    def value_text(self, node):
        """Return the C of an expression. Raises Failure if kernels have no expression of its kind."""
        method = getattr(self, "_value_of_" + type(node).__name__.lower(), None)
        if method is None:
            self.refuse(node, f"{ast.unparse(node)[:60]}: kernels have numbers, arrays, calls and attributes only")
        return method(node)

    def _value_of_constant(self, node):
        """Return the C of a whole number of 32 bits, from 2^31 on as the negative number of the same bits. Raises Failure if it is another
        constant."""
        if type(node.value) not in (int, bool):
            self.refuse(node, f"{node.value!r}: kernels have whole numbers only")
        value = int(node.value)
        if not -(1 << 31) <= value < 1 << 32:
            self.refuse(node, f"{value} has more than 32 bits")
        value -= (value >> 31 & 1) << 32 if value > 0 else 0
        return str(value) if value > -(1 << 31) else "INT32_MIN"

    def _value_of_name(self, node):
        """Return the C of a local or an argument, `v_NAME`, or the number of a module's constant. Raises Failure if it is another name."""
        if node.id in self.kinds:
            return "v_" + node.id
        numbers = self.program.constants.get(self.kernel.module, {})
        if node.id in numbers:
            return self._value_of_constant(ast.Constant(numbers[node.id]))
        if node.id in self.other_names:
            self.refuse(node, f"{node.id} is a kernel: call it, or have it given as an argument")
        self.refuse(node, f"{node.id} is no local, no argument and no constant: constants are whole numbers under names in capitals")

    def in_sequence(self, nodes, values, form):
        """Return the C of `form(*values)`, evaluated in Python's order, which C does not promise: with temporaries, if a value calls or is read from
        an array."""
        calls = [any(isinstance(each, ast.Call) for each in ast.walk(node)) or "looked(" in value for node, value in zip(nodes, values)]
        reads = [call or "[" in value for call, value in zip(calls, values)]
        if not any(calls) or sum(reads) < 2:
            return form(*values)
        names = [f"o{number}" for number in range(len(values))]
        first = " ".join(f"__auto_type {name} = {value};" for name, value in zip(names, values))
        return f"({{ {first} {form(*names)}; }})"

    def _value_of_binop(self, node):
        """Return the C of two numbers and their operator; // % << >> are functions of runtime.c. Raises Failure if kernels have no such operator."""
        values = [self.number_text(node.left), self.number_text(node.right)]
        if type(node.op) in FUNCTION:
            return self.in_sequence([node.left, node.right], values, lambda left, right: f"{FUNCTION[type(node.op)]}({left}, {right})")
        if type(node.op) not in BINARY:
            self.refuse(node, f"{ast.unparse(node)[:60]}: operators are + - * // % << >> & | ^ ~")
        return self.in_sequence([node.left, node.right], values, lambda left, right: f"({left} {BINARY[type(node.op)]} {right})")

    def _value_of_unaryop(self, node):
        if isinstance(node.op, ast.Not):
            return self.condition_text(node)
        return f"({'~' if isinstance(node.op, ast.Invert) else '-'}{self.number_text(node.operand)})"

    def _value_of_compare(self, node):
        """Return the C of a comparison, a chain of them joined by &&. Raises Failure if a value amid a chain is neither a name nor a constant, or it
        is no comparison of numbers."""
        parts, left = [], node.left
        for operator, right in zip(node.ops, node.comparators):
            if type(operator) not in COMPARE:
                self.refuse(node, f"{ast.unparse(node)[:60]}: comparisons are of numbers")
            values = [self.number_text(left), self.number_text(right)]
            parts.append(self.in_sequence([left, right], values, lambda a, b: f"({a} {COMPARE[type(operator)]} {b})"))
            if right is not node.comparators[-1] and not isinstance(right, (ast.Name, ast.Constant)):
                self.refuse(node, f"{ast.unparse(right)[:60]} between two comparisons: use a variable")
            left = right
        return "(" + " && ".join(parts) + ")" if len(parts) > 1 else parts[0]

    def _value_of_ifexp(self, node):
        if self.kind_of(node.body) != self.kind_of(node.orelse) and OBJECT in (self.kind_of(node.body), self.kind_of(node.orelse)):
            self.refuse(node, f"{ast.unparse(node)[:60]}: one is a number, the other an object")
        return f"({self.condition_text(node.test)} ? {self.value_text(node.body)} : {self.value_text(node.orelse)})"

    def _element_text(self, node):
        """Return (C of the element, whether interrupts or hardware change it)."""
        if self.kind_of(node.value) not in POINTERS:
            self.refuse(node, f"{ast.unparse(node.value)} is no array: write ptr32(…)")
        hardware = isinstance(node.value, ast.Call) and self.kind_of(node.value.args[0]) in (INT, BOOL)
        shared = hardware or isinstance(node.value, ast.Name) and self.is_volatile(node.value.id)
        return f"{self.value_text(node.value)}[{self.number_text(node.slice)}]", shared

    def _value_of_subscript(self, node):
        element, shared = self._element_text(node)
        return f"looked({element})" if shared else f"(int32_t){element}"

    def _value_of_boolop(self, node):
        self.refuse(node, f"{ast.unparse(node)[:60]} as a value: write … if … else …")

    def _value_of_attribute(self, node):
        if self.kind_of(node.value) != OBJECT:
            self.refuse(node, f"{ast.unparse(node.value)} is no object: give it as an argument without a type")
        return f"load_attr({self.value_text(node.value)}, {self.unit.name_text(node.attr)})"

    def _value_of_call(self, node):
        """Return the C of a call: int(), ptr8() to ptr32(), of a kernel, a method, or a function given as an argument; the latter's usual kernel is
        called directly. Raises Failure if it is another call, or names arguments."""
        if node.keywords:
            self.refuse(node, f"{ast.unparse(node)[:60]}: arguments go by their places")
        name = node.func.id if isinstance(node.func, ast.Name) else None
        if name == INT and len(node.args) == 1:
            given = self.value_text(node.args[0])
            kind = self.kind_of(node.args[0])
            return f"to_int(at, {given})" if kind == OBJECT else f"(int32_t)(uintptr_t){given}" if kind in POINTERS else given
        if name in POINTERS and name not in self.kinds:
            kind = self.kind_of(node.args[0])
            if kind == OBJECT:
                return f"(({C_TYPE[name]})array_of(at, {self.value_text(node.args[0])}))"
            volatile = "volatile " if kind not in POINTERS else ""
            return f"(({volatile}{C_TYPE[name]})(uintptr_t){self.value_text(node.args[0])})"
        if name == ROOT and name not in self.kinds and len(node.args) == 1:
            return f"root({self.number_text(node.args[0])})"
        kernel = self.kernel_of_call(node)
        if kernel:
            return self._direct_call(kernel, node)
        listed = [self.object_text(each) for each in node.args]
        if isinstance(node.func, ast.Attribute):
            base, method = self.value_text(node.func.value), self.unit.name_text(node.func.attr)
            form = lambda *given: f"call_method({', '.join([base, method, str(len(given)), *given])})"  # noqa: E731
            return self.in_sequence(node.args, listed, form)
        if name is None or self.kinds.get(name) != OBJECT:
            self.refuse(node, f"{ast.unparse(node.func)}() is no kernel: kernels call kernels, methods, and functions given as arguments")
        other = self.in_sequence(node.args, listed, lambda *given: f"call_object({', '.join([self.value_text(node.func), str(len(given)), *given])})")
        usual = self.program.kernels.get(self.usual.get(name))
        if usual not in self.unit.kernels:
            return other
        wrapper = self.unit.function_of(usual).wrapper_name()
        return f"(is_kernel({self.value_text(node.func)}, {wrapper}) ? (void){self._direct_call(usual, node)} : (void){other})"

    def _direct_call(self, kernel, node):
        """Return the C that calls a kernel's own function, each argument as its kind. Raises Failure if their count is wrong."""
        callee = self.unit.function_of(kernel)
        if len(node.args) != len(kernel.arguments):
            self.refuse(node, f"{kernel.name}() takes {len(kernel.arguments)} arguments")
        given = []
        for (name, kind), each in zip(kernel.arguments, node.args):
            if kind in POINTERS:
                given.append(self.pointer_text(each, kind, callee.is_volatile(name), kernel))
            else:
                given.append(self.object_text(each) if kind == OBJECT else self.number_text(each))
        first = ["at"] if callee.needs_objects() else []
        return self.in_sequence(node.args, given, lambda *values: f"{callee.c_name}({', '.join([*first, *values])})")

    def pointer_text(self, node, wanted, shared, callee):
        """Return the C of an argument of `callee` as a pointer of the type `wanted`. Raises Failure if it is a number, or an array shared with
        interrupts which the callee does not take for `shared`."""
        kind = self.kind_of(node)
        name = node.id if isinstance(node, ast.Name) else None
        name = self.array_of.get(name, name)
        if name and self.is_volatile(name) and not shared:
            self.refuse(node, f"{name} is shared with interrupts, and {callee.full}()'s module does not say so: # Shared with interrupts: …")
        if self.kinds.get(name) in POINTERS:
            return f"({C_TYPE[wanted]})v_{name}" if self.kinds[name] != wanted else f"v_{name}"
        if kind in POINTERS:
            return self.value_text(node)
        if kind != OBJECT:
            self.refuse(node, f"{ast.unparse(node)} is a number, {callee.full}() wants {wanted}: write {wanted}(…)")
        return f"array_of(at, {self.value_text(node)})"

    def object_text(self, node):
        """Return the C of an expression as an object; numbers and pointers are converted."""
        if self.kind_of(node) == OBJECT:
            return self.value_text(node)
        if self.kind_of(node) in POINTERS:
            return f"to_pointer(at, {self.value_text(node)})"
        return f"to_object(at, {self.value_text(node)})"

    def needs_objects(self):
        """True if it, or a kernel that it calls, calls the interpreter."""
        if self.with_objects is None:
            self.with_objects = False  # a kernel that calls this one again adds nothing
            for node in ast.walk(self.kernel.node):
                if isinstance(node, ast.Attribute) and self.kind_of(node) == OBJECT and not self.is_kernel_name(node):
                    self.with_objects = True
                elif isinstance(node, ast.Call):
                    kernel = self.kernel_of_call(node)
                    plain = isinstance(node.func, ast.Name) and node.func.id in (INT, *POINTERS, ROOT, "range")
                    if kernel and self.unit.function_of(kernel).needs_objects() or not kernel and not plain:
                        self.with_objects = True
                    if not (kernel and node.args == []) and any(self.kind_of(each) == OBJECT for each in node.args):
                        self.with_objects = True
        return self.with_objects

    def is_kernel_name(self, node):
        return self.program.kernel_of_name(self.kernel.module, node) is not None or ast.unparse(node).startswith("micropython.")

    # --- statements

    def block_text(self, body, depth):
        return "".join("    " * depth + line + "\n" for node in body for line in self.statement_lines(node))

    def inner_lines(self, body):
        return [f"    {line}" for node in body for line in self.statement_lines(node)]

    def statement_lines(self, node):
        """Return the lines of C of a statement."""
        if isinstance(node, ast.Expr):
            return [] if isinstance(node.value, ast.Constant) else [f"{self.value_text(node.value)};"]
        if isinstance(node, ast.Assign):
            return self._assign_lines(node)
        if isinstance(node, ast.AugAssign):
            if isinstance(node.target, ast.Subscript) and not isinstance(node.target.slice, ast.Constant):
                if any(isinstance(each, (ast.Call, ast.Subscript)) for each in ast.walk(node.target.slice)):
                    self.refuse(node, f"{ast.unparse(node.target)} with an operator: the index is computed twice: use a variable for it")
            read = ast.copy_location(ast.BinOp(_as_read(node.target), node.op, node.value), node)
            return self._store_lines(node.target, self._value_of_binop(read))
        if isinstance(node, ast.While) and not node.orelse:
            return [f"while ({self.condition_text(node.test)}) {{", *self.inner_lines(node.body), "}"]
        if isinstance(node, ast.For) and not node.orelse:
            return self._for_lines(node)
        if isinstance(node, ast.If):
            lines = [f"if ({self.condition_text(node.test)}) {{", *self.inner_lines(node.body), "}"]
            if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
                first, *rest = self.statement_lines(node.orelse[0])
                lines[-1:] = ["} else " + first, *rest]
            elif node.orelse:
                lines[-1:] = ["} else {", *self.inner_lines(node.orelse), "}"]
            return lines
        if isinstance(node, ast.Return):
            if node.value is None or not self.kernel.returns:
                if node.value is not None:
                    self.refuse(node, "returns a value: write -> int behind the arguments")
                return ["return;"]
            return [f"return {self.number_text(node.value)};"]
        simple = {ast.Break: ["break;"], ast.Continue: ["continue;"], ast.Pass: []}
        if type(node) not in simple:
            self.refuse(node, f"{type(node).__name__.lower()}: statements are =, while, for … in range(…), if, break, continue, return, pass and calls")
        return simple[type(node)]

    def _assign_lines(self, node):
        """Return the lines of C of an assignment; none if the name stands for a kernel. Raises Failure if a target is neither a name nor an element,
        or its kind is another than the value's."""
        if isinstance(node.targets[0], ast.Name) and node.targets[0].id in self.other_names:
            return []
        if len(node.targets) > 1 and not isinstance(node.value, (ast.Name, ast.Constant)):
            self.refuse(node, "several targets: assign a number or a name to them")
        kind = self.kind_of(node.value)
        lines = []
        for target in node.targets:
            if not isinstance(target, (ast.Name, ast.Subscript)):
                self.refuse(node, f"{ast.unparse(target)} = …: write an assignment for each variable or element of an array")
            known = self.kind_of(target)
            if known != kind and {known, kind} != {INT, BOOL}:
                self.refuse(node, f"{ast.unparse(target)} is {known}, {ast.unparse(node.value)[:40]} is {kind}")
            lines += self._store_lines(target, self.value_text(node.value))
        return lines

    def _store_lines(self, target, value):
        """Return the lines of C that store the C `value` in a name or an element. An element that interrupts or hardware change is written behind
        settled()."""
        if isinstance(target, ast.Name):
            if self.kind_of(target) in POINTERS and self.is_volatile(target.id) and "volatile" not in value and target.id not in self.shared:
                value = f"(volatile {C_TYPE[self.kinds[target.id]]}){value}"
            return [f"{self._value_of_name(target)} = {value};"]
        element, shared = self._element_text(target)
        if shared or "(" in value:
            return [f"{{ int32_t next = {value}; {'settled(); ' if shared else ''}{element} = next; }}"]
        return [f"{element} = {value};"]

    def _for_lines(self, node):
        """Return the lines of C of a loop over range(), whose limits are computed once. Raises Failure if it is another loop."""
        call = node.iter
        if not (isinstance(call, ast.Call) and ast.unparse(call.func) == "range" and 1 <= len(call.args) <= 2 and isinstance(node.target, ast.Name)):
            self.refuse(node, "for: write for NAME in range(…), with one number or two")
        first, end = ([ast.Constant(0)] + call.args)[-2:]
        name, count = "v_" + node.target.id, f"end_{node.target.id}_{node.lineno}"
        head = f"{{ int32_t next = {self.number_text(first)}, {count} = {self.number_text(end)}; for (; next < {count}; next++) {{"
        return [head, f"    {name} = next;", *self.inner_lines(node.body), "} }"]

    # --- text

    def declaration_text(self, name, kind):
        return f"{'volatile ' if kind in POINTERS and self.is_volatile(name) else ''}{C_TYPE[kind]}v_{name}"

    def head_text(self):
        arguments = ["context_t at"] if self.needs_objects() else []
        arguments += [self.declaration_text(name, kind) for name, kind in self.kernel.arguments]
        return f"static {'int32_t' if self.kernel.returns else 'void'} {self.c_name}({', '.join(arguments) or 'void'})"

    def function_text(self):
        """Return the kernel's C function: its locals begin as 0, and it returns 0 if its end is reached."""
        body = self.block_text(self.kernel.node.body, 1)
        known = {name for name, _ in self.kernel.arguments}
        local = "".join(f"    {self.declaration_text(name, kind)} = 0;\n" for name, kind in self.kinds.items() if name not in known)
        last = "    return 0;\n" if self.kernel.returns and not isinstance(self.kernel.node.body[-1], ast.Return) else ""
        return f"// {self.kernel.full}\n{self.head_text()} {{\n{local}{body}{last}}}\n\n"

    def wrapper_name(self):
        return f"call_{self.c_name}"

    def wrapper_text(self):
        """Return the C function that Python calls: arguments are objects, as of viper."""
        given = ["at"] if self.needs_objects() else []
        for number, (_, kind) in enumerate(self.kernel.arguments):
            given.append(f"args[{number}]" if kind == OBJECT else f"{'to_int' if kind == INT else 'array_of'}(at, args[{number}])")
        call = f"{self.c_name}({', '.join(given)})"
        made = f"to_{'bool' if self.kernel.returns == BOOL else 'object'}(at, {call})"
        result = f"return {made};" if self.kernel.returns else f"{call};\n    return none(at);"
        return (
            f"static object_t {self.wrapper_name()}(context_t at, size_t count, size_t named, object_t *args) {{\n"
            f"    if (count != {len(self.kernel.arguments)} || named) wrong_count(at, {len(self.kernel.arguments)}, count);\n    {result}\n}}\n\n"
        )


    def pc_function(self):
        """Return the C function that ctypes calls on a PC."""
        given = (["at"] if self.needs_objects() else []) + ["v_" + name for name, _ in self.kernel.arguments]
        head = self.head_text().removeprefix("static ").replace(f" {self.c_name}(", f" pc_{self.c_name}(")
        return f"{head} {{\n    {'return ' if self.kernel.returns else ''}{self.c_name}({', '.join(given)});\n}}\n"


def _as_read(node):
    return ast.parse(ast.unparse(node), mode="eval").body

"""One module of machine code as one text of C.

    unit = Unit(program, kernels)       # kernels that Python calls; those called by them are added
    unit.text(runtime)                  # C, behind the text of runtime.c; pc_text(): for a PC
    unit.names                          # of attributes and functions, in the order in which the C numbers them
"""

from host_tools.kernels.translate import Function

ALWAYS_NAMED = "kernels", "array", "_code", "i"  # the first names of a module: runtime.c knows their places


class Unit:
    """One module of machine code."""

    def __init__(self, program, kernels, stays=False):
        """`stays`: in a UF2 it runs from flash, and is not copied into memory."""
        self.program, self.kernels, self.functions, self.names, self.stays = program, kernels, {}, list(ALWAYS_NAMED), stays
        self.called = [self.function_of(kernel) for kernel in kernels]

    def function_of(self, kernel):
        """Return the Function of a kernel, made once; None while it is made."""
        if kernel.full not in self.functions:
            self.functions[kernel.full] = None  # no kernel needs itself to be made
            self.functions[kernel.full] = Function(self, kernel)
        return self.functions[kernel.full]

    def name_text(self, name):
        if name not in self.names:
            self.names.append(name)
        return f"NAME({self.names.index(name)})"

    def python_name(self, kernel):
        """Return the name of a kernel in the module: short, because a board keeps each name for ever."""
        return f"_{[each.kernel.full for each in self.called].index(kernel.full)}"

    def text(self, runtime):
        """Return the C of the module: `runtime`, the text of runtime.c, all functions with their wrappers, and define_all(), which gives Python the
        kernels."""
        heads, bodies, wrapped = self._c_parts()
        heads += "".join(f"static object_t {each.wrapper_name()}(context_t at, size_t count, size_t named, object_t *args);\n" for each in wrapped)
        stores = "".join(f"    define(at, {self.name_text(self.python_name(each.kernel))}, (const char *){each.wrapper_name()} + away, arrays);\n" for each in self.called)
        bodies += "".join(each.wrapper_text() for each in wrapped)
        first = "#define STAYS\n" if self.stays else ""
        return f"{first}{runtime}\n{heads}\n{bodies}ONCE void define_all(context_t at, object_t arrays, intptr_t away) {{\n{stores}}}\n"

    def pc_text(self, runtime):
        """Return the C for a library of a PC: a function pc_… for each kernel that Python calls."""
        heads, bodies, wrapped = self._c_parts()
        heads += "".join(f"const char {each.wrapper_name()}[1];  // stands for the kernel, given as an argument\n" for each in wrapped)
        return f"{runtime}\n{heads}\n{bodies}" + "".join(each.pc_function() for each in self.called)

    def _c_parts(self):
        """Return (C of all heads, C of all functions, functions that are called as objects, too)."""
        texts = {}
        while texts.keys() != self.functions.keys():  # a text may want more of them
            for full in [each for each in self.functions if each not in texts]:
                texts[full] = self.functions[full].function_text()
        functions = list(self.functions.values())
        wrapped = [each for each in functions if each in self.called or any(each.wrapper_name() in text for text in texts.values())]
        return "".join(each.head_text() + ";\n" for each in functions), "".join(texts.values()), wrapped

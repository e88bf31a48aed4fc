"""Values that an NGC program can read: its own parameters, and those with the interpreter's state.

Parameters 1 to 30 and named ones without an underscore belong to a subroutine; a call saves and restores them. Numbered
parameters are 0 until they are set. Values that only the machine knows (probed positions, work offsets that the program does not set) are refused.
"""

from host_tools.programs.program_errors import MACHINE_ONLY, PARAMETER, ProgramError

LOCALS = range(1, 31)
MOST = 5602
_MACHINE = ((5061, 5070), (5161, 5169), (5181, 5189), (5210, 5219), (5221, 5390), (5399, 5399))


class State:
    """`told`: {number or name: function that returns its value}."""

    def __init__(self, told):
        self._told = told
        self._numbered = {}
        self._names = [{}]
        self._globals = {"_value": 0.0, "_value_returned": 0.0}
        self._saved = []

    def has(self, name):
        if isinstance(name, int):
            return name in self._told or 0 < name <= MOST
        return name in self._told or name in self._scope_of(name)

    def get(self, name):
        """Return the value of a parameter: a number, or a name without its brackets. Raises ProgramError."""
        if name in self._told:
            return float(self._told[name]())
        if not isinstance(name, int):
            if name not in self._scope_of(name):
                raise ProgramError(PARAMETER, "#<{}>", name)
            return self._scope_of(name)[name]
        self._check_number(name)
        if name not in self._numbered and any(low <= name <= high for low, high in _MACHINE):
            raise ProgramError(MACHINE_ONLY, "#{}", name)
        return self._numbered.get(name, 0.0)

    def set(self, name, value):
        """Set a parameter, by number or name. Raises ProgramError if it is one that the interpreter itself has, or its number is out of range."""
        if name in self._told:
            raise ProgramError(PARAMETER, "#{} cannot be set", name if isinstance(name, int) else "<" + name + ">")
        if isinstance(name, int):
            self._check_number(name)
            self._numbered[name] = value
        else:
            self._scope_of(name)[name] = value

    def _scope_of(self, name):
        return self._globals if name.startswith("_") else self._names[-1]

    @staticmethod
    def _check_number(number):
        if not 0 < number <= MOST:
            raise ProgramError(PARAMETER, "#{}", number)

    def enter_call(self, arguments):
        """Begin a subroutine: save the local parameters, and set its arguments. Raises ProgramError."""
        self._saved.append([self._numbered.get(number, 0.0) for number in LOCALS])
        self._names.append({})
        if len(arguments) > len(LOCALS):
            raise ProgramError(PARAMETER, "{} arguments at most", len(LOCALS))
        self._numbered.update(enumerate(arguments, 1))
        self._globals.update(_value=0.0, _value_returned=0.0)

    def leave_call(self, value):
        """End a subroutine, with a value or None: restore the local parameters."""
        self._numbered.update(zip(LOCALS, self._saved.pop()))
        self._names.pop()
        if value is not None:
            self._globals.update(_value=value, _value_returned=1.0)

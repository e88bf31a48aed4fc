"""A stand-in for MicroPython's `micropython` module under CPython: the same names, none of the effects."""


def const(value):
    return value


def native(function):
    return function


def viper(function):
    return function


def asm_thumb(function):
    """A PC cannot run it: calling it is an error, importing it is not."""

    def unavailable(*_):
        raise NotImplementedError(function.__name__ + " is machine code of the board: a PC cannot run it")

    return unavailable


def heap_lock():
    pass


def heap_unlock():
    pass


def kbd_intr(character):
    pass


def alloc_emergency_exception_buf(size):
    pass


def opt_level(level=None):
    return 0


def schedule(function, argument):
    """Runs at once: CPython has no interrupt to defer it from."""
    function(argument)

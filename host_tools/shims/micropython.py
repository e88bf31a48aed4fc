"""A stand-in for MicroPython's `micropython` module under CPython: the same names, none of the effects."""


def const(value):
    return value


def native(function):
    return function


def viper(function):
    return function


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

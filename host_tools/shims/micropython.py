"""A stand-in for MicroPython's `micropython` module under CPython: the same names, none of the effects.

Kernels also name types that only viper's compiler knows, ptr8, ptr16 and ptr32: CPython reads them as built-in functions.
"""

import builtins


def pointer(array):
    return array


builtins.ptr8 = builtins.ptr16 = builtins.ptr32 = pointer


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

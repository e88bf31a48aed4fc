"""The wiring of a board file as a table of texts, pin by pin.

    for row in wiring_rows(check(boards.load("router_3axis"))):
        print(row)                          # ("GP2", "4", "X driver and motor", "STEP", "pulse 3 µs, DIR 5 µs ahead")
"""

from host_tools.wiring.modules import module_of
from host_tools.wiring.parts import REGISTER_BIT, parts_of


def wiring_rows(board):
    """Return (pin, position on the module, part, terminal, notes) of each terminal of a checked board file, by pin."""
    found = [(terminal.pin, part, terminal.label) for part in parts_of(board) for terminal in part.terminals]
    module = module_of(board, {pin for pin, _, _ in found if not isinstance(pin, tuple)}, set())
    found.sort(key=lambda each: each[0] if isinstance(each[0], tuple) else ("", each[0]))
    return [(_pin_name(pin, module), "" if isinstance(pin, tuple) else module.position(pin), part.title, label, " ".join(part.notes))
            for pin, part, label in found]  # fmt: skip


def _pin_name(pin, module):
    """Return the name of a pin, or of a register's bit."""
    if not isinstance(pin, tuple):
        return module.label(pin)
    way, number = pin
    chip, bit = divmod(number - REGISTER_BIT, 8)
    name, letter = ("74HC165", "") if way == "in" else ("74HC595", "Q")
    return f"{number}: {name} {chip + 1}, {letter}{'ABCDEFGH'[bit]}"

"""The modules that carry the chips: which pin lies where on their edges.

    module = module_of(check(boards.load("router_3axis")))      # module.left, module.right: [(label, pin or None), ...] from the top

A Raspberry Pi Pico, a DevKitC with 38 pins, or a plain list of the pins in use. Pins that a board file names, and that no edge has, are
in `loose`.
"""

from dataclasses import dataclass

from host_tools.language import _

_PICO_LEFT = "0 1 GND 2 3 4 5 GND 6 7 8 9 GND 10 11 12 13 GND 14 15".split()
_PICO_RIGHT = "VBUS VSYS GND 3V3_EN 3V3 VREF 28 GND 27 26 RUN 22 GND 21 20 19 18 GND 17 16".split()
_DEVKIT_LEFT = "3V3 EN 36 39 34 35 32 33 25 26 27 14 12 GND 13 9 10 11 5V".split()
_DEVKIT_RIGHT = "GND 23 22 1 3 21 GND 19 18 5 17 16 4 0 2 15 8 7 6".split()
MKS = "mks_dlc32"  # by name: the chip alone does not tell it from other ESP32 boards
_CHIPS = {"rp2040": "Raspberry Pi Pico", "rp2350": "Raspberry Pi Pico 2", "esp32": "ESP32 DevKitC"}


@dataclass
class Module:
    """`numbers`: pin numbers of the left and the right edge from the top, or None."""

    title: str
    prefix: str
    left: list
    right: list
    loose: list
    numbers: tuple = None

    def label(self, pin):
        """Return the name of a pin of the chip."""
        return f"{self.prefix}{pin}"

    def position(self, pin):
        """Return the number of a pin in the module's print or drawing; "" if it has none."""
        for side, numbers in zip((self.left, self.right), self.numbers or ()):
            for number, (_, other) in zip(numbers, side):
                if other == pin:
                    return str(number)
        return ""


def module_of(board, pins, right):
    """Return the module of a checked board file; `pins`: all of the chip's that it names, `right`: those that a plain list has on its right."""
    chip = board["chip"]
    if chip in ("rp2040", "rp2350"):
        wireless = board.get("network") is not None or "pico_w" in board["name"]
        edges = _edge_pads(_PICO_LEFT, "GP"), _edge_pads(_PICO_RIGHT, "GP")
        numbers = range(1, 21), range(40, 20, -1)
        return _make_module(_CHIPS[chip] + (" W" if wireless else ""), "GP", *edges, pins, numbers)
    if chip == "esp32" and board["name"] != MKS:
        return _make_module(_CHIPS[chip], "GPIO", _edge_pads(_DEVKIT_LEFT, "GPIO"), _edge_pads(_DEVKIT_RIGHT, "GPIO"), pins)
    title = "Makerbase MKS DLC32 V2" if board["name"] == MKS else chip.upper() + " " + _("board")
    known = sorted(pins - right)
    half = len(known) if right else (len(known) + 1) // 2
    left, right = ([(f"GPIO{pin}", pin) for pin in some] for some in (known[:half], sorted(right) or known[half:]))
    return _make_module(title, "GPIO", [("3V3", None), *left], [("GND", None), *right], pins)


def _make_module(title, prefix, left, right, pins, numbers=None):
    """Return a Module; pins that neither edge has are its loose ones."""
    there = {pin for _, pin in left + right}
    return Module(title, prefix, left, right, sorted(pin for pin in pins if pin not in there), numbers)


def _edge_pads(names, prefix):
    """Return [(label, pin or None)] of an edge of the module; a name of digits is a pin."""
    return [(prefix + name, int(name)) if name.isdigit() else (name, None) for name in names]

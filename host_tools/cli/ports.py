"""`passo ports`: the serial ports that look like a board."""

from host_tools.failure import Failure
from host_tools.language import _

# Vendor and product of the chips that boards have at their USB plug; a product of None means any of that vendor.
_BOARDS = [
    (0x2E8A, 0x0005, "RP2040 or RP2350 with MicroPython"),
    (0x2E8A, None, "Raspberry Pi RP2040 or RP2350"),
    (0x303A, None, "Espressif ESP32 with USB"),
    (0x10C4, 0xEA60, "CP210x serial adapter (many ESP32 boards)"),
    (0x1A86, 0x7523, "CH340 serial adapter (ESP32 and others)"),
    (0x1A86, 0x55D4, "CH9102 serial adapter (ESP32 and others)"),
    (0x0403, 0x6001, "FT232R serial adapter"),
    (0x0403, 0x6015, "FT231X serial adapter"),
]


def kind_of(vendor, product):
    """Return the kind of board by its USB numbers, or None if they are no board's."""
    for known_vendor, known_product, kind in _BOARDS:
        if vendor == known_vendor and product in (known_product, product if known_product is None else known_product):
            return kind
    return None


def find_boards():
    """Return [(port, kind, serial number)] of the boards that are connected now."""
    from serial.tools import list_ports

    boards = []
    for port in sorted(list_ports.comports(), key=lambda item: item.device):
        kind = kind_of(port.vid, port.pid)
        if kind:
            boards.append((port.device, kind, port.serial_number or ""))
    return boards


def only_port():
    """Return the port of the one board that is connected. Raises Failure if there is none, or more than one."""
    boards = find_boards()
    if not boards:
        raise Failure("no board is connected; name its port with --port")
    if len(boards) > 1:
        raise Failure("several boards are connected ({}); choose one with --port", ", ".join(item[0] for item in boards))
    return boards[0][0]


def ports():
    """List the serial ports that look like a board.

    Examples:

        passo ports
    """
    from rich.console import Console
    from rich.table import Table

    boards = find_boards()
    if not boards:
        raise Failure("no board is connected (a virtual one starts with: passo board)")
    table = Table(_("port"), _("board"), _("serial number"))
    for row in boards:
        table.add_row(*row)
    Console().print(table)

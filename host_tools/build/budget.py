"""What a board file uses of its chip: pins, PIO, shift registers. `passo build` prints it.

    budget(check(BOARD))        # [("pins", "26 of 26 of a Pico"), ("PIO", "5 of 8 state machines, …"), …]
"""

from host_tools.language import _
from passo.config.boardfile import claimed_pins

PICO_PINS = (*range(23), 26, 27, 28)  # that a Pico brings out
RP2_BLOCKS = {"rp2040": 2, "rp2350": 3}
_MACHINES = 4  # of a PIO block
_BLOCK = 32  # instructions
_ESP32_KB = 209  # of memory for heap, machine code and drivers, with MicroPython 1.27 as it comes and no PSRAM
# What the firmware takes of it, kB: (its language, with Wi-Fi, with the page). Measured on MicroPython's qemu port, drivers and Wi-Fi reckoned.
_ESP32_NEEDS = {
    ("plotter", False, False): 155, ("plotter", True, True): 276, ("torch", True, False): 250,
    ("grbl", False, False): 317, ("grbl", True, False): 386, ("grbl", True, True): 418,
}  # fmt: skip


def budget(board):
    """[(name, text)] of a checked board."""
    claimed = sorted(pin for pin, _ in claimed_pins(board))
    rows = [(_("pins"), _pins(board, claimed))]
    if board["chip"] in RP2_BLOCKS:
        rows.append(("PIO", _pio(board)))
    if board["registers"]:
        rows.append((_("shift registers"), _registers(board)))
    if board["chip"].startswith("esp32"):
        rows.append((_("memory"), memory(board)))
    uarts = [(board["inverter"]["port"], _("inverter"))] if board["inverter"] else []
    uarts += [(link["port"], _("link {}", link["name"])) for link in board["links"] if link["port"] != "usb"]
    rows.append((_("serial lines"), ", ".join(f"{port}: {who}" for port, who in sorted(uarts)) or _("none but USB")))
    return rows


def memory(board):
    """Whether a checked board fits into an ESP32 without PSRAM, as a sentence."""
    languages = {link["protocol"] for link in board["links"]}
    language = next((each for each in ("grbl", "torch", "plotter") if each in languages), None)
    page = any(link["port"] == "page" for link in board["links"])
    need = _ESP32_NEEDS.get((language, bool(board["network"]), page))
    if board["chip"] != "esp32" or need is None:
        return _("not counted for this chip and these links: take a module with PSRAM (docs/wiring.md, ESP32)")
    if need > _ESP32_KB:
        return _("{} kB wanted, {} there without PSRAM: it does not fit; take a module with PSRAM (docs/wiring.md, ESP32)", need, _ESP32_KB)
    return _("{} kB wanted, {} there without PSRAM", need, _ESP32_KB)


def _pins(board, claimed):
    if board["chip"] not in RP2_BLOCKS:
        return _("{} in use: {}", len(claimed), ", ".join(map(str, claimed)))
    inside = [pin for pin in claimed if pin not in PICO_PINS]
    free = [pin for pin in PICO_PINS if pin not in claimed]
    text = _("{} of {} of a Pico", len(claimed) - len(inside), len(PICO_PINS))
    if inside:
        text += _("; not brought out: {}", ", ".join(map(str, inside)))
    return text + (_("; free: {}", ", ".join(map(str, free))) if free else _("; none free"))


def _pio(board):
    """Of the player in block 0, and the encoders, whose program wants all of block 1."""
    blocks = RP2_BLOCKS[board["chip"]]
    encoders = len(board["encoders"])
    player = 1
    parts = [_("player 1 in block 0")]
    if encoders:
        parts.append(_("encoders {} in block 1, whose {} instructions they fill", encoders, _BLOCK))
    free = [_MACHINES - player, 0 if encoders else _MACHINES, *[_MACHINES] * (blocks - 2)]
    parts.append(_("free: {}", ", ".join(_("{} in block {}", count, block) for block, count in enumerate(free) if count)))
    return _("{} of {} state machines: {}", player + encoders, blocks * _MACHINES, "; ".join(parts))


def _registers(board):
    from passo.records import REGISTER_BIT

    inputs = sum(item["pin"] >= REGISTER_BIT for item in board["inputs"])
    outputs = sum(item["pin"] >= REGISTER_BIT for item in board["outputs"]) + (board["registers"]["tool"] >= 0)
    return _("{} of {} inputs, {} of {} outputs", inputs, 8 * board["registers"]["inputs"], outputs, 8 * board["registers"]["outputs"])

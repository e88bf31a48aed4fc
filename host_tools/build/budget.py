"""Counts the pins, state machines and shift registers that a board file uses of its chip. `passo build` prints it.

    budget_rows(check(BOARD))   # [("pins", "26 of 26 of a Pico"), ("PIO", "5 of 8 state machines, …"), …]
"""

from host_tools.build.reference import load_manifests
from host_tools.failure import Failure
from host_tools.language import _
from passo.config.board_error import options_by_value
from passo.config.boardfile import pin_claims

PICO_PINS = (*range(23), 26, 27, 28)  # that a Pico brings out
RP2_BLOCKS = {"rp2040": 2, "rp2350": 3}
_MACHINES = 4  # of a PIO block
_BLOCK = 32  # instructions
# Of memory for heap, machine code and drivers, with MicroPython 1.27 and no PSRAM: as files, frozen. There are 209, in pieces, of which a start
# from files cannot use all.
ESP32_KB = {"esp32": (175, 209)}
PSRAM_PINS = {"esp32": (16, 17)}  # that it takes
# kB that the firmware takes of it, as files and frozen (docs/inside/build.md): (its language, with Wi-Fi, with the page). Counted on MicroPython's
# qemu port: tests_host/cores/test_esp32_memory.py; drivers and Wi-Fi reckoned.
ESP32_NEEDS = {
    ("plotter", False, False): (180, 64), ("plotter", True, True): (279, 121), ("torch", True, False): (268, 112),
    ("grbl", False, False): (361, 123), ("grbl", True, False): (437, 175), ("grbl", True, True): (462, 183),
}  # fmt: skip
ESP32_POWER = (20, 4)  # more, of a laser or a spindle whose power is PWM
# The heap of stock MicroPython 1.27 on a Pico, and a Pico W, in kB; how much of it has to stay free; and the share of each key of a board file,
# machine code and arrays included: measured on the emulated Pico (tests_host/pico/test_pico_budget.py). Stored jobs keep 14, and want JOB_KB
# in large pieces while one is stored.
PICO_KB, PICO_W_KB, FREE_KB = 246, 205, 20
LANGUAGES_KB = {"grbl": 166, "pulses": 150, "torch": 124, "keys": 124, "plotter": 124}
ADDITIONS_KB = {"motion": 3, "drives": 6, "stalls": 6}
LINKS_KB = {"page": 30, "http": 16, "tcp": 16}
FRAMES_KB, JOB_KB = 6, 10
BROKER_KB = 12  # reckoned: 8 with the UF2, where its module lies in flash


def budget_rows(board):
    """Return [(name, text)] of a checked board."""
    claimed = sorted({pin for pin, _ in pin_claims(board)})
    rows = [(_("pins"), _pins_text(board, claimed))]
    if board["chip"] in RP2_BLOCKS:
        rows.append(("PIO", _pio_text(board)))
    if board.get("registers"):
        rows.append((_("shift registers"), _registers_text(board)))
    if board["chip"].startswith("esp32"):
        rows.append((_("memory"), memory_text(board)))
    elif board["chip"] == "rp2040":
        rows.append((_("memory"), _("some {} kB of {} on stock MicroPython", heap_kb(board), _stock_kb(board))))
    uarts = [(board["inverter"]["port"], _("inverter"))] if board.get("inverter") else []
    uarts += [(board["drivers"]["port"], _("drivers"))] if board.get("drivers") else []
    uarts += [(link["port"], _("link {}", link["name"])) for link in board["links"] if link["port"] != "usb"]
    rows.append((_("serial lines"), ", ".join(f"{port}: {who}" for port, who in sorted(uarts)) or _("none but USB")))
    return rows


def esp32_needs(board):
    """Return (kB as files, kB frozen) that a checked board takes of an ESP32's memory, or None if nobody has counted it."""
    languages = {link["protocol"] for link in board["links"]}
    language = next((each for each in ("grbl", "torch", "plotter") if each in languages), None)
    page = any(link["port"] == "page" for link in board["links"])
    found = ESP32_NEEDS.get((language, bool(board.get("network")), page))
    if found and board["spindle"]["pwm"]:
        return tuple(kb + more for kb, more in zip(found, ESP32_POWER))
    return found


def heap_kb(board):
    """Return the heap in kB that a checked board takes of a Pico with stock MicroPython: its largest language, and each key and link."""
    kinds = {link["port"] for link in board["links"]}
    taken = max(LANGUAGES_KB[link["protocol"]] for link in board["links"])
    taken += sum(getattr(manifest, "HEAP_KB", 0) for key, manifest in load_manifests().items() if board.get(key) or key in options_by_value(board))
    taken += sum(cost for name, cost in ADDITIONS_KB.items() if getattr(board.get("additions"), name, None))
    taken += sum(cost for kind, cost in LINKS_KB.items() if kind in kinds)
    taken += BROKER_KB * bool((board.get("network") or {}).get("broker"))
    return taken + JOB_KB * bool(board.get("jobs")) + FRAMES_KB * any(link["frames"] for link in board["links"])


def _stock_kb(board):
    """Return the heap in kB of a Pico, or a Pico W, with stock MicroPython."""
    return PICO_W_KB if board.get("network") else PICO_KB


def memory_text(board):
    """Return a sentence about the memory that a checked board needs and an ESP32 has."""
    (there, _frozen), found = ESP32_KB.get(board["chip"], (None, None)), esp32_needs(board)
    if board["psram"]:
        return _("in the module's PSRAM")
    if there is None or found is None:
        return _("not counted for this chip and these links: take a module with PSRAM (docs/start/wiring.md, ESP32)")
    return _("{} kB wanted, {} there without PSRAM", found[0], there)


def check_module(board, name):
    """Raise Failure if a checked board asks for more than its module has, or a Pico's stock MicroPython."""
    if board["chip"] == "rp2040":
        if heap_kb(board) + FREE_KB > _stock_kb(board):
            raise Failure(
                "{} wants Passo's UF2 (docs/inside/build.md, make uf2): on stock MicroPython it takes some {} kB of memory, there are {}, and {} have "
                "to stay free", name, heap_kb(board), _stock_kb(board), FREE_KB
            )  # fmt: skip
        return
    (there, _frozen), found = ESP32_KB.get(board["chip"], (None, None)), esp32_needs(board)
    taken = sorted({pin for pin, who in pin_claims(board)} & set(PSRAM_PINS.get(board["chip"], ()))) if board["psram"] else ()
    if taken:
        raise Failure("{}: pin {} of a module with PSRAM is the PSRAM's", name, taken[0])
    if there and found and found[0] > there and not board["psram"]:
        raise Failure(
            "{}: {} kB of memory wanted, {} there: it does not start. Take a module with PSRAM and say \"psram\": True, or freeze the firmware into "
            "MicroPython, where it takes {} kB (docs/inside/build.md, An image for an ESP32)", name, found[0], there, found[1]
        )  # fmt: skip


def _pins_text(board, claimed):
    """Return a sentence about the pins in use, not brought out, and free."""
    if board["chip"] not in RP2_BLOCKS:
        return _("{} in use: {}", len(claimed), ", ".join(map(str, claimed)))
    inside = [pin for pin in claimed if pin not in PICO_PINS]
    free = [pin for pin in PICO_PINS if pin not in claimed]
    text = _("{} of {} of a Pico", len(claimed) - len(inside), len(PICO_PINS))
    if inside:
        text += _("; not brought out: {}", ", ".join(map(str, inside)))
    return text + (_("; free: {}", ", ".join(map(str, free))) if free else _("; none free"))


def _pio_text(board):
    """Return a sentence about state machines: the player's in block 0, and the encoders', whose program wants all of block 1."""
    blocks = RP2_BLOCKS[board["chip"]]
    encoders = len(board.get("encoders", ()))
    player = 1
    parts = [_("player 1 in block 0")]
    if encoders:
        parts.append(_("encoders {} in block 1, whose {} instructions they fill", encoders, _BLOCK))
    free = [_MACHINES - player, 0 if encoders else _MACHINES, *[_MACHINES] * (blocks - 2)]
    parts.append(_("free: {}", ", ".join(_("{} in block {}", count, block) for block, count in enumerate(free) if count)))
    return _("{} of {} state machines: {}", player + encoders, blocks * _MACHINES, "; ".join(parts))


def _registers_text(board):
    """Return a sentence about the bits of shift registers in use."""
    from passo.records import REGISTER_BIT

    inputs = sum(item["pin"] >= REGISTER_BIT for item in board["inputs"])
    outputs = sum(item["pin"] >= REGISTER_BIT for item in board["outputs"]) + (board["registers"]["tool"] >= 0)
    return _("{} of {} inputs, {} of {} outputs", inputs, 8 * board["registers"]["inputs"], outputs, 8 * board["registers"]["outputs"])

"""What a board file uses of its chip: pins, PIO, shift registers. `passo build` prints it.

    budget(check(BOARD))        # [("pins", "26 of 26 of a Pico"), ("PIO", "5 of 8 state machines, …"), …]
"""

from passo.config.boardfile import claimed_pins

PICO_PINS = (*range(23), 26, 27, 28)  # that a Pico brings out
RP2_BLOCKS = {"rp2040": 2, "rp2350": 3}
_MACHINES = 4  # of a PIO block
_BLOCK = 32  # instructions


def budget(board):
    """[(name, text)] of a checked board."""
    claimed = sorted(pin for pin, _ in claimed_pins(board))
    rows = [("pins", _pins(board, claimed))]
    if board["chip"] in RP2_BLOCKS:
        rows.append(("PIO", _pio(board)))
    if board["registers"]:
        rows.append(("shift registers", _registers(board)))
    uarts = [(board["inverter"]["port"], "inverter")] if board["inverter"] else []
    uarts += [(link["port"], f"link {link['name']}") for link in board["links"] if link["port"] != "usb"]
    rows.append(("serial lines", ", ".join(f"{port}: {who}" for port, who in sorted(uarts)) or "none but USB"))
    return rows


def _pins(board, claimed):
    if board["chip"] not in RP2_BLOCKS:
        return f"{len(claimed)} in use: {', '.join(map(str, claimed))}"
    inside = [pin for pin in claimed if pin not in PICO_PINS]
    free = [pin for pin in PICO_PINS if pin not in claimed]
    text = f"{len(claimed) - len(inside)} of {len(PICO_PINS)} of a Pico"
    if inside:
        text += f"; not brought out: {', '.join(map(str, inside))}"
    return text + (f"; free: {', '.join(map(str, free))}" if free else "; none free")


def _pio(board):
    """Of the player in block 0, and the encoders, whose program wants all of block 1."""
    blocks = RP2_BLOCKS[board["chip"]]
    encoders = len(board["encoders"])
    player = 1
    parts = ["player 1 in block 0"]
    if encoders:
        parts.append(f"encoders {encoders} in block 1, whose {_BLOCK} instructions they fill")
    free = [_MACHINES - player, 0 if encoders else _MACHINES, *[_MACHINES] * (blocks - 2)]
    parts.append("free: " + ", ".join(f"{count} in block {block}" for block, count in enumerate(free) if count))
    return f"{player + encoders} of {blocks * _MACHINES} state machines: {'; '.join(parts)}"


def _registers(board):
    from passo.records import REGISTER_BIT

    inputs = sum(item["pin"] >= REGISTER_BIT for item in board["inputs"])
    outputs = sum(item["pin"] >= REGISTER_BIT for item in board["outputs"]) + (board["registers"]["tool"] >= 0)
    return f"{inputs} of {8 * board['registers']['inputs']} inputs, {outputs} of {8 * board['registers']['outputs']} outputs"

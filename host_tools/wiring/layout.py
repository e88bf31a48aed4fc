"""Places the parts of a wiring drawing, and routes each wire. Units are mm on a sheet of A4, y downwards.

    sheet = arrange_sheet(board)          # sheet.module, sheet.parts, sheet.bits, sheet.wires

Pins of the module lie on even multiples of HALF, terminals of parts on odd ones, crossings above and below the module between them, so
that two wires never run along each other. Each wire has a vertical track of its own in the channel between parts and module; tracks
are sorted so that few wires cross.

        parts │ channel │ module │ channel │ parts                              without registers
        parts │ channel │ module │ channel │ registers │ parts of their bits    with registers
"""

from dataclasses import dataclass

from host_tools.failure import Failure
from host_tools.wiring.modules import module_of
from host_tools.wiring.parts import REGISTER_BIT, chips_of, parts_of

PITCH = 4.4
HALF = PITCH / 2
TOP, BOTTOM = 36.0, 240.0
PLAIN = {"left": (6.0, 62.0), "module": (84.0, 126.0), "right": (148.0, 204.0)}
WITH_REGISTERS = {"left": (6.0, 59.0), "module": (80.0, 113.0), "right": (131.0, 153.0), "bits": (157.0, 204.0)}


@dataclass
class Placed:
    """A part in its box; `points`: (terminal, x, y) of its terminals; `inner`: the side that its terminals are on."""

    part: object
    left: float
    top: float
    right: float
    bottom: float
    inner: str
    points: list


@dataclass
class Wire:
    """From a pin's pad to terminals: `ways` are lists of (x, y), the first begins at the pad; `joints` are where others begin."""

    pin: object
    ends: list
    ways: list
    joints: list


@dataclass
class Sheet:
    """A sheet of A4: parts, wires and the module with their positions, in mm."""

    board: dict
    columns: dict
    module: object
    top: float
    pads: dict
    parts: list
    bits: dict
    wires: list


def arrange_sheet(board):
    """Return the Sheet of a checked board file. Raises Failure if its parts find no room on it."""
    found = parts_of(board)
    registers = any(part.name == "registers" for part in found)
    columns = WITH_REGISTERS if registers else PLAIN
    direct = [part for part in found if not _is_behind_register(part)]
    used = {terminal.pin for part in direct for terminal in part.terminals}
    right = {terminal.pin for part in direct if part.name == "registers" for terminal in part.terminals}
    module = module_of(board, used, right)
    rows = max(len(module.left), len(module.right)) + len(module.loose)
    top = _snap_to_pitch((TOP + BOTTOM - rows * PITCH) / 2)
    pads = _pad_positions(module, columns["module"], top)
    placed = _place_parts(direct, pads, columns, registers, board)
    bits = {}
    if registers:
        bank = next(each for each in placed if each.part.name == "registers")
        bits = _bit_positions(bank, chips_of(board))
        placed += _place_beside_bits([part for part in found if _is_behind_register(part)], bits, columns["bits"])
    wires = _route_wires(pads, placed, columns, top, top + rows * PITCH)
    wires += [Wire(pin, [(each, terminal)], [[bits[pin], (x, y)]], []) for each in placed for terminal, x, y in each.points
              if isinstance(pin := terminal.pin, tuple)]  # fmt: skip
    return Sheet(board, columns, module, top, pads, placed, bits, wires)


def _is_behind_register(part):
    """True if a part's terminals are bits of a shift register."""
    return isinstance(part.terminals[0].pin, tuple)


def _snap_to_pitch(y):
    """Return y (mm), rounded to a multiple of PITCH from TOP."""
    return TOP + round((y - TOP) / PITCH) * PITCH


def _pad_positions(module, edges, top):
    """Return {pin: (x, y)} of the module's edges; pins that no edge has stand below, on the left."""
    pads = {}
    for x, side in zip(edges, (module.left, module.right)):
        for row, (_, pin) in enumerate(side):
            if pin is not None:
                pads[pin] = x, top + row * PITCH
    rows = max(len(module.left), len(module.right))
    for row, pin in enumerate(module.loose):
        pads[pin] = edges[0], top + (rows + row) * PITCH
    return pads


# --- parts


def slot_height(part):
    """Return the height of a part's slot in mm, with the gap to the next: a multiple of PITCH."""
    rows = max(len(part.terminals), (len(part.notes) + 2) // 2)
    return (rows + 1) * PITCH


def _place_parts(direct, pads, columns, registers, board):
    """Return each part as a Placed, beside the pins that it has most of; with registers all stand left but these. Raises Failure."""
    middle = sum(columns["module"]) / 2
    sides = {"left": [], "right": []}
    for part in direct:
        right = sum(pads[terminal.pin][0] > middle for terminal in part.terminals)
        beside = "right" if 2 * right > len(part.terminals) else "left"
        sides[("right" if part.name == "registers" else "left") if registers else beside].append(part)
    room = BOTTOM - TOP
    for full, other in (("left", "right"), ("right", "left")):
        while not registers and sum(map(slot_height, sides[full])) > room and sum(map(slot_height, sides[other])) + slot_height(sides[full][-1]) < room:
            sides[other].append(sides[full].pop())
    placed = []
    for side, some in sides.items():
        placed += _place_column(some, pads, columns[side], "right" if side == "left" else "left", chips_of(board))
    return placed


def _mean_y(part, pads):
    """Return the mean y of the pads that a part is wired to, in mm."""
    return sum(pads[terminal.pin][1] for terminal in part.terminals) / len(part.terminals)


def _place_column(some, pads, edges, inner, chips):
    """Return the parts of a column as Placed, each as near to its pins as the others leave it. Raises Failure if they are too many."""
    some = sorted(some, key=lambda part: (_mean_y(part, pads), part.name))
    heights = [bank_rows(chips) * PITCH if part.name == "registers" else slot_height(part) for part in some]
    if sum(heights) > BOTTOM - TOP:
        raise Failure("{} parts do not fit on one side of the sheet; the table has them all", len(some))
    tops = _spread_slots([_mean_y(part, pads) - tall / 2 for part, tall in zip(some, heights)], heights)
    placed = []
    for part, top, tall in zip(some, tops, heights):
        x = edges[1] if inner == "right" else edges[0]
        first = top + HALF + (PITCH if part.name == "registers" else 0)  # below its heading
        points = [(terminal, x, first + row * PITCH) for row, terminal in enumerate(part.terminals)]
        placed.append(Placed(part, edges[0], top, edges[1], top + tall - 1.2, inner, points))
    return placed


def _spread_slots(wished, heights):
    """Return the tops of slots that do not overlap, near the wished ones: neighbours that would overlap are moved as one block, by the mean of their
    wishes."""
    blocks = []  # [members, sum of (wish - offset), height]
    for wish, tall in zip(wished, heights):
        blocks.append([1, wish, tall])
        while len(blocks) > 1 and _block_start(blocks[-2]) + blocks[-2][2] > _block_start(blocks[-1]):
            members, total, tall_ = blocks.pop()
            before = blocks[-1]
            before[1] += total - members * before[2]
            before[0] += members
            before[2] += tall_
    tops, at = [], iter(heights)
    lowest = TOP
    for block in blocks:
        y = max(lowest, min(_snap_to_pitch(_block_start(block)), _snap_to_pitch(BOTTOM - block[2])))
        for _ in range(block[0]):
            tops.append(y)
            y += next(at)
        lowest = y
    over = max(0, round((lowest - BOTTOM) / PITCH + 0.49)) if tops else 0
    for index in reversed(range(len(tops) if over else 0)):
        limit = (tops[index + 1] if index + 1 < len(tops) else _snap_to_pitch(BOTTOM)) - heights[index]
        tops[index] = min(tops[index], limit)
    return tops


def _block_start(block):
    """Return the top of a block: the mean of its members' wishes."""
    return block[1] / block[0]


# --- shift registers


def bank_rows(chips):
    """Return the rows of the box of all registers: a heading and eight bits a chip, and one below."""
    return 9 * (chips["in"] + chips["out"]) + 1


def _bit_positions(bank, chips):
    """Return {pin: (x, y)} of the registers' bits, on the outer side of their box."""
    bits, row = {}, 0
    for way in ("in", "out"):
        for chip in range(chips[way]):
            row += 1
            for bit in range(8):
                bits[way, REGISTER_BIT + 8 * chip + bit] = bank.right, bank.top + HALF + row * PITCH
                row += 1
    return bits


def _place_beside_bits(behind, bits, edges):
    """Return parts as Placed beside their bits. Terminals of one part on bits that are no neighbours stand apart, under the same title."""
    placed = []
    for part in behind:
        runs = []
        for terminal in sorted(part.terminals, key=lambda terminal: bits[terminal.pin][1]):
            y = bits[terminal.pin][1]
            if runs and abs(y - runs[-1][-1][2] - PITCH) < 0.1:
                runs[-1].append((terminal, edges[0], y))
            else:
                runs.append([(terminal, edges[0], y)])
        for run in runs:
            placed.append(Placed(part, edges[0], run[0][2] - HALF + 0.3, edges[1], run[-1][2] + HALF - 0.3, "left", run))
    return placed


# --- wires


def _route_wires(pads, placed, columns, top, bottom):
    """Return the Wires of the module's pins. A pin with parts on both sides goes around the module, above or below."""
    nets = {}
    for each in placed:
        for terminal, x, y in each.points:
            if not isinstance(terminal.pin, tuple):
                nets.setdefault(terminal.pin, []).append((each, terminal, x, y))
    middle = sum(columns["module"]) / 2
    channels = {"left": {}, "right": {}}  # {pin: (ys at the parts, ys at the module)}
    bands, above, below = {}, 0, 0
    for pin, ends in sorted(nets.items()):
        x, y = pads[pin]
        home = "left" if x < middle else "right"
        sides = {"left" if end[2] < middle else "right" for end in ends}
        if sides - {home}:
            if y < (top + bottom) / 2:
                above += 1
                bands[pin] = top - HALF / 2 - (above + 2) * HALF  # above the USB plug
            else:
                bands[pin] = bottom + HALF / 2 + below * HALF
                below += 1
        for side in sides | ({home} if pin in bands else set()):
            outer = [end[3] for end in ends if ("left" if end[2] < middle else "right") == side]
            inner = ([y] if side == home else []) + ([bands[pin]] if pin in bands else [])
            channels[side][pin] = outer, inner
    tracks = {
        "left": _assign_tracks(channels["left"], columns["left"][1], columns["module"][0], False),
        "right": _assign_tracks(channels["right"], columns["module"][1], columns["right"][0], True),
    }
    return [_route_wire(pin, nets[pin], pads[pin], bands.get(pin), tracks, middle) for pin in sorted(nets)]


def _route_wire(pin, ends, pad, band, tracks, middle):
    """Return the Wire of a pin. `band`: y of its way around the module, or None; `tracks`: {side: {pin: x}}; `middle`: x of the module's middle."""
    home = "left" if pad[0] < middle else "right"
    ways, joints = [], []
    for number, (each, terminal, x, y) in enumerate(ends):
        side = "left" if x < middle else "right"
        track = tracks[side][pin]
        trunk = [pad, (tracks[home][pin], pad[1])] if side == home else [pad, (tracks[home][pin], pad[1]), (tracks[home][pin], band), (track, band)]
        ways.append([*trunk, (track, y), (x, y)])
        if number:
            joints.append((track, y))
    if band is not None and any(("left" if end[2] < middle else "right") == home for end in ends):
        joints.append((tracks[home][pin], pad[1]))
    return Wire(pin, [(each, terminal) for each, terminal, _, _ in ends], ways, joints)


def _assign_tracks(nets, low, high, mirrored):
    """Return {pin: x} of the vertical tracks of a channel between x = low and high; the parts are at low, or at high if mirrored."""
    spans = {pin: (min(outer + inner), max(outer + inner)) for pin, (outer, inner) in nets.items()}
    order = sorted(nets, key=lambda pin: (spans[pin][0], str(pin)))
    moved = True
    while moved:
        moved = False
        for index in range(len(order) - 1):
            one, two = order[index : index + 2]
            if _count_crossings(nets, spans, two, one) < _count_crossings(nets, spans, one, two):
                order[index : index + 2] = two, one
                moved = True
    levels = {}
    for pin in order:
        levels[pin] = 1 + max((levels[other] for other in levels if _spans_meet(spans[pin], spans[other])), default=0)
    step = (high - low) / (max(levels.values(), default=0) + 1)
    return {pin: (high - level * step if mirrored else low + level * step) for pin, level in levels.items()}


def _spans_meet(one, two):
    """True if two vertical spans (low, high) overlap, or nearly so."""
    return one[0] < two[1] + HALF + 0.1 and two[0] < one[1] + HALF + 0.1


def _count_crossings(nets, spans, near, far):
    """Return how often two wires cross, one on the track nearer to the parts: its ways to the module cross the far track, ways of the far wire to its
    parts cross the near one."""
    low, high = spans[far]
    crossing = sum(low < y < high for y in nets[near][1])
    low, high = spans[near]
    return crossing + sum(low < y < high for y in nets[far][0])

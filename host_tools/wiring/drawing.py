"""A wiring drawing as SVG, one sheet of A4.

    text = wiring_svg(check(boards.load("router_3axis")))

Each wire is a path with `data-pin`, `data-part` and `data-terminal`; each pad of the module has `data-pad`. Texts are as wide as
DejaVu Sans or Verdana at most, and made smaller where they would not fit.
"""

from xml.sax.saxutils import escape, quoteattr

from host_tools.language import _, current_language
from host_tools.wiring.layout import PITCH, TOP, arrange_sheet
from host_tools.wiring.parts import REGISTER_BIT, chips_of, common_enable, motors_of
from host_tools.wiring.symbols import COLOURS, GROUNDED, LIGHTER, symbol_of

INK, PAPER, PALE, POWER = "#1a1a1a", "#ffffff", "#f3f5f8", "#c81010"
# Widths in DejaVu Sans, in thousandths of the size; others are 640.
_WIDTHS = {
    280: "ijlI|'", 320: ".,:; ", 360: "-", 400: "rft()[]/\\", 530: "sczxvky", 550: "JFEL", 600: "aeoghTu", 870: "wmM→×−…", 790: "OQGHNDU+=<>", 1000: "W%@",
}  # fmt: skip
_WIDTH_OF = {letter: width for width, letters in _WIDTHS.items() for letter in letters}
_BOLD = 1.12


def wiring_svg(board):
    """Return the SVG of a checked board file. Raises Failure if its parts find no room."""
    sheet = arrange_sheet(board)
    title = _("Wiring of {}", board["name"])
    first, last = extent_of(sheet)
    supply, bottom = _supply_elements(sheet, last + 8)
    shift = TOP - 4 - first
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="210mm" height="{_number_text(bottom + shift)}mm" viewBox="0 0 210 {_number_text(bottom + shift)}"'
        f' role="img" lang="{current_language()}" font-family="DejaVu Sans, Verdana, sans-serif" fill="{INK}">',
        f"<title>{escape(title)}</title>",
        f'<rect width="210" height="{_number_text(bottom + shift)}" fill="{PAPER}"/>',
        *_heading_elements(sheet, title),
        f'<g transform="translate(0 {_number_text(shift)})">',
        *_module_elements(sheet),
        *[line for wire in sheet.wires for line in _wire_elements(wire)],
        *[line for placed in sheet.parts for line in _part_elements(sheet, placed)],
        *supply,
        "</g>",
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def extent_of(sheet):
    """Return (top, bottom) of module, parts and wires, in mm."""
    rows = max(len(sheet.module.left), len(sheet.module.right)) + len(sheet.module.loose)
    ys = [y for wire in sheet.wires for way in wire.ways for _x, y in way]
    tops = [sheet.top - 5.6, *(placed.top for placed in sheet.parts), *ys]
    return min(tops), max(sheet.top + rows * PITCH, *(placed.bottom for placed in sheet.parts), *ys)


# --- texts


def text_width(text, size, bold=False):
    """Return an upper bound of a text's width in mm. `size`: of the letters, mm."""
    return sum(_WIDTH_OF.get(letter, 640) for letter in text) * size / 1000 * (_BOLD if bold else 1)


def _text_element(x, y, text, size=2.5, anchor="start", bold=False, fill=None, most=None):
    """Return a text whose baseline is at y (mm); `most`: the width to which it is reduced."""
    if most is not None and text:
        size = min(size, round(size * most / text_width(text, size, bold), 2))
    more = (f' text-anchor="{anchor}"' if anchor != "start" else "") + (' font-weight="bold"' if bold else "")
    more += f' fill="{fill}"' if fill else ""
    return f'<text x="{_number_text(x)}" y="{_number_text(y)}" font-size="{_number_text(size)}"{more}>{escape(text)}</text>'


def _number_text(number):
    """Return a number with two decimals at most."""
    return f"{number:.2f}".rstrip("0").rstrip(".")


def _box_element(left, top, right, bottom, stroke, fill=PAPER, radius=1.0, wide=0.35):
    """Return a box with round corners, in mm."""
    size = f'width="{_number_text(right - left)}" height="{_number_text(bottom - top)}"'
    return f'<rect x="{_number_text(left)}" y="{_number_text(top)}" {size} rx="{_number_text(radius)}" fill="{fill}" stroke="{stroke}" stroke-width="{_number_text(wide)}"/>'


# --- the sheet's pieces


def _heading_elements(sheet, title):
    """Return the title, the module's name and the legend of colours."""
    legend = [
        ("driver", _("motors")), ("switch", _("switches, sensors")), ("stop", _("emergency stop")), ("contact", _("tool")),
        ("relay", _("relays, lamps")), ("encoder", _("encoders")), ("serial", _("serial lines")), ("registers", _("registers")),
    ]  # fmt: skip
    kinds = {COLOURS[placed.part.kind] for placed in sheet.parts}
    shown = [(kind, text) for kind, text in legend if COLOURS[kind] in kinds or kind == "stop"]
    lines = [_text_element(6, 13, title, 5, bold=True)]
    lines.append(_text_element(6, 19, _("{}. All pins take 3.3 V at most. Seen from above, USB at the top.", sheet.module.title), 2.7, most=198))
    x = 6.0
    for kind, text in shown:
        lines.append(f'<path d="M{_number_text(x)} 25H{_number_text(x + 5)}" stroke="{COLOURS[kind]}" stroke-width="1"/>')
        lines.append(_text_element(x + 6, 25.9, text, 2.4))
        x += 9 + text_width(text, 2.4)
    return lines


def _module_elements(sheet):
    """Return the module with its pads; pins that no edge has stand below it."""
    module, (left, right) = sheet.module, sheet.columns["module"]
    rows = max(len(module.left), len(module.right))
    top, bottom = sheet.top - 3.4, sheet.top + (rows - 1) * PITCH + 3.4
    middle = (left + right) / 2
    lines = [_box_element(left, top, right, bottom, INK, PALE, 2, 0.5)]
    if module.title.startswith(("Rasp", "ESP32 Dev")):
        lines.append(_box_element(middle - 4.5, top - 2.2, middle + 4.5, top + 1.6, INK, PAPER, 0.6))
        lines.append(_text_element(middle, top + 0.5, "USB", 2.2, "middle"))
    room = (right - left) / 2 - 2.5
    for side, x, direction in ((module.left, left, 1), (module.right, right, -1)):
        numbers = module.numbers[0 if direction > 0 else 1] if module.numbers else [""] * len(side)
        for row, (number, (label, pin)) in enumerate(zip(numbers, side)):
            y = sheet.top + row * PITCH
            lines += _pad_elements(x, y, direction, label, pin, number, room, pin in _pins_of(sheet))
    for row, pin in enumerate(module.loose):
        y = sheet.top + (rows + row) * PITCH
        lines += _pad_elements(left, y, 1, _("{}: on the module only", module.label(pin)), pin, "", right - left - 2.5, True)
    return lines


def _pins_of(sheet):
    """Return the pins that have a wire."""
    return {wire.pin for wire in sheet.wires}


def _pad_elements(x, y, direction, label, pin, number, room, used):
    """Return a pad at (x, y) and its label. `direction`: 1 on the left edge, −1 on the right one; `room`: width of the label, mm."""
    colour = INK if used else "#9aa3ad"
    fill = {"GND": INK, "3V3": POWER, "VBUS": POWER, "VSYS": POWER, "5V": POWER}.get(label, colour if used else PAPER)
    data = f' data-pad="{pin}"' if pin is not None else ""
    anchor = "start" if direction > 0 else "end"
    name = label if number == "" else f"{number} {label}" if direction > 0 else f"{label} {number}"
    tone = fill if label in ("3V3", "VBUS", "VSYS", "5V") else INK if used or label == "GND" else "#5c6670"
    return [
        f'<circle cx="{_number_text(x)}" cy="{_number_text(y)}" r="0.9" fill="{fill}" stroke="{colour}" stroke-width="0.3"{data}/>',
        _text_element(x + 1.8 * direction, y + 0.9, name, 2.4, anchor, bold=used, fill=tone, most=room),
    ]


def _wire_elements(wire):
    """Return the paths of a wire, and a dot at each joint."""
    part, terminal = wire.ends[0][0].part, wire.ends[0][1]
    colour = LIGHTER.get(part.kind, COLOURS[part.kind]) if part.terminals.index(terminal) % 2 else COLOURS[part.kind]
    pin = f"{wire.pin[0]} {wire.pin[1]}" if isinstance(wire.pin, tuple) else str(wire.pin)
    lines = []
    for (placed, terminal), way in zip(wire.ends, wire.ways):
        path = "M" + "L".join(f"{_number_text(x)} {_number_text(y)}" for x, y in way)
        data = f'data-pin="{pin}" data-part={quoteattr(placed.part.name)} data-terminal={quoteattr(terminal.label)}'
        lines.append(f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="0.45" stroke-linejoin="round" {data}/>')
    lines += [f'<circle cx="{_number_text(x)}" cy="{_number_text(y)}" r="0.7" fill="{colour}"/>' for x, y in wire.joints]
    return lines


def _part_elements(sheet, placed):
    """Return the box of a part with its terminals, texts and symbol."""
    if placed.part.name == "registers":
        return _bank_elements(sheet, placed)
    part, colour = placed.part, COLOURS[placed.part.kind]
    behind = isinstance(part.terminals[0].pin, tuple)
    lines = [f"<g data-box={quoteattr(part.name)}>", _box_element(placed.left, placed.top, placed.right, placed.bottom, colour)]
    inward = -1 if placed.inner == "right" else 1
    labels = max((text_width(terminal.label, 2.4) for terminal, _x, _y in placed.points), default=0)
    for terminal, x, y in placed.points:
        lines.append(f'<circle cx="{_number_text(x)}" cy="{_number_text(y)}" r="0.7" fill="{colour}"/>')
        if terminal.label:
            lines.append(_text_element(x + 1.6 * inward, y + 0.9, terminal.label, 2.4, "end" if inward < 0 else "start"))
    lines += _part_texts(placed, labels + 3.2 if labels else 2.2, behind)
    lines.append("</g>")
    return lines


def _part_texts(placed, margin, behind):
    """Return title, notes and supply of a part, and its symbol on the side away from its terminals. `margin`: mm that the terminals take."""
    part, colour = placed.part, COLOURS[placed.part.kind]
    middle = (placed.top + placed.bottom) / 2
    tall = placed.bottom - placed.top
    tight = tall < 5
    field = 0 if tight and behind else 11
    if placed.inner == "right":
        left, right, centre = placed.left + max(field, 1.5), placed.right - margin, placed.left + 5.8
    else:
        left, right, centre = placed.left + margin, placed.right - max(field, 1.5), placed.right - 5.8
    notes = [] if tight else part.notes[: max(1, int((tall - 3) / 3.1))]
    rows = [(part.title, True)] + [(note, False) for note in notes]
    first = middle - 3.1 * (len(rows) - 1) / 2 + 0.9
    lines = [_text_element(left, first + 3.1 * row, text, 2.4 if not bold else 2.5, bold=bold, fill=colour if bold else None, most=right - left)
             for row, (text, bold) in enumerate(rows)]  # fmt: skip
    if field:
        raised = 1.2 if part.supply and part.kind not in GROUNDED else 0
        where = f"translate({_number_text(centre)} {_number_text(middle - raised)})" + (" scale(.8)" if raised and tall < 8 else "")
        lines.append(f'<g transform="{where}" fill="none" stroke="{colour}" stroke-width="0.35">{symbol_of(part.kind, part.opens)}</g>')
        if raised:
            lines.append(_text_element(centre, placed.bottom - 0.9, " ".join(part.supply), 1.9, "middle", fill=POWER if "M+" in part.supply else None))
    return lines


def _bank_elements(sheet, placed):
    """Return the box of all shift registers: lines from the module on one side, bits on the other."""
    chips, colour = chips_of(sheet.board), COLOURS["registers"]
    lines = ['<g data-box="registers">', _box_element(placed.left, placed.top, placed.right, placed.bottom, colour)]
    for terminal, x, y in placed.points:
        lines += [f'<circle cx="{_number_text(x)}" cy="{_number_text(y)}" r="0.7" fill="{colour}"/>', _text_element(x + 1.6, y + 0.9, terminal.label, 2.2)]
    y = placed.top + PITCH / 2
    for way, name in (("in", "74HC165"), ("out", "74HC595")):
        for chip in range(chips[way]):
            title = name + (f" · {chip + 1}" if chips[way] > 1 else "")
            lines.append(_text_element((placed.left + placed.right) / 2, y + 0.9, title, 2.4, "middle", True, colour, placed.right - placed.left - 2))
            for bit in range(8):
                number = REGISTER_BIT + 8 * chip + bit
                lines += _bit_elements(sheet, way, number, ("Q" if way == "out" else "") + "ABCDEFGH"[bit])
            y += 9 * PITCH
    return [*lines, "</g>"]


def _bit_elements(sheet, way, number, letter):
    """Return a bit of a shift register with its label. `way`: "in" or "out"."""
    x, y = sheet.bits[way, number]
    used = any(wire.pin == (way, number) for wire in sheet.wires)
    colour = COLOURS["registers"] if used else "#9aa3ad"
    return [
        f'<circle cx="{_number_text(x)}" cy="{_number_text(y)}" r="0.7" fill="{colour if used else PAPER}" stroke="{colour}" stroke-width="0.3" data-pad="{way} {number}"/>',
        _text_element(x - 1.6, y + 0.9, f"{number} {letter}", 2.2, "end", fill=None if used else "#5c6670"),
    ]


# --- supplies


def _supply_elements(sheet, top):
    """Return (elements, lower edge in mm) of the power's way, below the drawing: supply, emergency stop, and the parts behind it."""
    y = top + 8
    stop = next((item for item in sheet.board["inputs"] if item["halt"]), None)
    lines = [_text_element(6, top, _("Power"), 3, bold=True)]
    lines += [_box_element(6, y - 5, 40, y + 5, POWER), _text_element(23, y - 0.4, _("supply M+"), 2.5, "middle", True, POWER, 32)]
    lines.append(_text_element(23, y + 3.2, _("by their data sheets"), 2.4, "middle", most=32))
    lines.append(f'<path d="M40 {_number_text(y)}H48M82 {_number_text(y)}H94M91.6 {_number_text(y - 1.4)}L94 {_number_text(y)}L91.6 {_number_text(y + 1.4)}" fill="none" stroke="{POWER}" stroke-width="0.9"/>')
    lines += [_box_element(48, y - 5, 82, y + 5, POWER), _text_element(65, y - 2, _("E-STOP, latching"), 2.5, "middle", True, POWER, 32)]
    lines.append(f'<path d="M50 {_number_text(y + 2)}H61L69 {_number_text(y + 2.3)}M67 {_number_text(y + 2)}V{_number_text(y + 0.4)}M69 {_number_text(y + 2)}H80" fill="none" stroke="{POWER}" stroke-width="0.5"/>')
    second = _("2nd contact: input {}", stop["name"]) if stop else _("no input: 2nd contact unused")
    lines.append(_text_element(65, y + 8.4, second, 2.2, "middle", most=40))
    fed = ", ".join(placed.part.title for placed in sheet.parts if "M+" in placed.part.supply)
    rows = _wrap_text(_("M+ feeds: {}. A program cannot replace this switch.", fed), 2.5, 108)
    lines += [_text_element(96, y - 3.2 + 3.4 * row, text, 2.5) for row, text in enumerate(rows)]
    y += 14
    for note in _power_notes(sheet):
        for row in _wrap_text("• " + note, 2.4, 196):
            lines.append(_text_element(6, y, row, 2.4))
            y += 3.5
    return lines, y + 3


def _power_notes(sheet):
    """Yield sentences about supply, outputs at the start, registers and drivers' enable."""
    board = sheet.board
    yield _("The board has its 5 V from USB. 3V3 feeds sensors and pull-ups. All GND pins are one ground: supply, drivers and sensors join there.")
    yield _("Give each output that must not switch on at the start 10 kΩ: to GND if it is active high, to 3V3 if it is active low.")
    chips = chips_of(board)
    if chips["in"]:
        yield _("CLK: CLK of the 74HC165, SRCLK of the 74HC595. LATCH: SH/LD and RCLK. QH: that of the first 74HC165; SER: that of the first 74HC595.")
    elif chips["out"]:
        yield _("CLK: SRCLK of all registers. LATCH: RCLK. SER: that of the first; the next has QH' of the one before. OE: 10 kΩ to 3V3.")
    if board["drive"]["kind"] == "step_dir" and common_enable(board) is None and len(motors_of(board)) > 1:
        names = [item["name"] for item in board["outputs"]]
        yield _("EN of all drivers goes to the output enable.") if "enable" in names else _("EN of the drivers stays open, or as their manual says.")


def _wrap_text(text, size, most):
    """Return the lines of a text that are `most` mm wide at most."""
    rows = [""]
    for word in text.split():
        longer = f"{rows[-1]} {word}".strip()
        if text_width(longer, size) > most and rows[-1]:
            rows.append(word)
        else:
            rows[-1] = longer
    return rows

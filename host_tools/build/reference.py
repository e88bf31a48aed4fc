"""Writes the tables of docs/reference that repeat what the firmware knows: board-file keys, pins, settings, errors.

    python -m host_tools.build.reference          # writes board-file.md, pins.md, settings.md and errors.md anew

Of each page only what stands between its two marks is made; the rest is written by hand. tests_host/rules/test_docs.py fails
while a page is not current.
"""

import re
from importlib import import_module

from host_tools import boards, options
from host_tools.build import tree
from host_tools.failure import Failure
from host_tools.resources import FIRMWARE, ROOT

DOCS = ROOT / "docs" / "reference"
BEGIN = "<!-- made by python -m host_tools.build.reference: change the firmware's table, not these lines -->"
END = "<!-- end -->"
EXAMPLE = next(name for name in ("router_3axis", *boards.names()) if name in boards.names())


def page_text(name):
    """Return the text that a page of PAGES should have. Raises Failure if a table cannot be made."""
    path = DOCS / name
    text = path.read_text(encoding="utf-8")
    wanted = "\n".join([BEGIN, "", *PAGES[name](), "", END])
    found = re.subn(re.escape(BEGIN) + ".*?" + re.escape(END), lambda _: wanted, text, flags=re.DOTALL)
    if found[1] != 1:
        raise Failure("{} must have the two marks once", path)
    return found[0]


# --- board file


def board_keys():
    """Return the lines of a table for each section of the schema. Raises Failure if a key has no meaning, or a meaning no key."""
    from passo.config import boardfile

    rows = []
    sections, meanings = section_texts()
    for section, (title, intro) in sections.items():
        rules, note = _section_rules(boardfile, section)
        rows += ["", f"### {title}", "", intro + note, "", "| key | value | default | meaning |", "| --- | --- | --- | --- |"]
        for key, rule in rules.items():
            path = f"{section}.{key}" if section else key
            if path in sections:
                continue
            meaning = meanings.pop(path, None)
            if meaning is None:
                raise Failure("neither host_tools/build/board_keys.py nor an option's words.py says what {} means", path)
            rows.append(f"| `{key}` | {_kind_text(rule)} | {_default_text(rule, boardfile.MUST)} | {meaning} |")
    if meanings:
        raise Failure("host_tools/build/board_keys.py, or an option's words.py, has keys that no board file has: {}", ", ".join(meanings))
    return rows[1:]


def all_rules(boardfile):
    """Return the whole schema, with the keys that few boards have."""
    own = {key: rule for manifest in load_manifests().values() for key, rule in manifest.RULES.items()}
    rules = {**boardfile._BOARD, **own}
    for manifest in load_manifests().values():
        if hasattr(manifest, "extend"):
            manifest.extend(rules)
    return rules


def section_texts():
    """Return (SECTIONS, MEANINGS) of board_keys.py, and those of options behind them."""
    from host_tools.build.board_keys import MEANINGS, SECTIONS

    sections, meanings = dict(SECTIONS), dict(MEANINGS)
    for own in options.words_of_options().values():
        sections.update(getattr(own, "SECTIONS", {}))
        meanings.update(getattr(own, "MEANINGS", {}))
    return sections, meanings


def load_manifests():
    """Return {key: manifest} of all options."""
    return {folder.name: import_module(f"passo.options.{folder.name}.manifest") for folder in sorted((FIRMWARE / tree.OPTIONS).iterdir()) if (folder / tree.MANIFEST).is_file()}


def key_paths(rules, prefix=""):
    """Yield the dotted paths of all keys of a schema that have no section of their own."""
    for key, rule in rules.items():
        inner = rule[0] if isinstance(rule, list) else rule
        if isinstance(inner, dict):
            yield from key_paths(inner, prefix + key + ".")
        else:
            yield prefix + key


def _section_rules(boardfile, name):
    """Return (the rules of a section, a sentence that says if it may be left out)."""
    rules = all_rules(boardfile)
    if not name:
        return rules, ""
    *sections, last = name.split(".")
    for section in sections:
        rules = rules[section]
    rule = rules[last]
    optional = " May be left out."
    if isinstance(rule, list):
        return rule[0], f" {rule[1]} … {rule[2]} of them." + ("" if rule[1] else optional)
    return rule, optional if name in (*boardfile._OPTIONAL, *load_manifests()) else " Needed."


def spi_pins(board):
    """Yield (pin, wire, note) of drivers on SPI."""
    config = board.get("spi_drivers")
    if not config:
        return
    for key, wire in (("sck", "SCK"), ("tx", "SDI"), ("rx", "SDO")):
        yield config[key], f"drivers {wire}", ""
    for cs in dict.fromkeys(motor["cs"] for motor in config["motors"]):
        yield cs, "drivers CS of " + ", ".join(motor["axis"] for motor in config["motors"] if motor["cs"] == cs), ""


def _number_text(value):
    """Return a number with spaces between thousands."""
    return f"{value:,}".replace(",", " ")


def _kind_text(rule):
    """Return the values that a rule allows: choices, bounds, or a length."""
    if isinstance(rule[0], str):
        return ", ".join(f'`"{choice}"`' for choice in rule)
    kind, _, least, most = rule
    if kind is bool:
        return "True or False"
    bounds = f"{_number_text(least)} … {_number_text(most)}"
    if kind is int:
        return bounds
    if least == most:
        bounds = str(least)
    return {str: "text of {} characters", list: "list of {} numbers", dict: "dict of {} entries"}[kind].format(bounds)


def _default_text(rule, must):
    """Return the default of a rule, or that its key is needed."""
    if isinstance(rule[0], str):
        return f'`"{rule[0]}"`'
    if rule[1] is must:
        return "**needed**"
    return f"`{rule[1]!r}`".replace("'", '"')


# --- pins


def pin_rows():
    """Return the lines of a table for each board file: pins in their order, and for a Pico a drawing of its edges; boards that are alike together."""
    from passo.config.boardfile import check

    from host_tools import boards

    found = {}  # the rows of a board: names of the boards that have them
    for name in boards.names():
        board = check(boards.load(name))
        esp32 = board["chip"].startswith("esp32")
        uses = sorted(_pins_in_use(board))
        picture = () if esp32 else _pico_drawing({pin: short for pin, short, _ in uses})
        table = [f"| {_pin_name(pin, esp32, short)} | {short}{about} |" for pin, short, about in uses]
        found.setdefault((*picture, "| pin | goes to |", "| --- | --- |", *table), []).append(name)
    rows = []
    for lines, names in found.items():
        rows += ["", f"### {', '.join(names)}", "", *lines]
    return rows[1:]


def _pin_name(pin, esp32, short):
    """Return the name of a pin, or of a register's bit (100 and above)."""
    if pin >= 100:
        side = "" if short.startswith("in ") else "Q"
        return f"{pin}: register {(pin - 100) // 8 + 1}, {side}{'ABCDEFGH'[(pin - 100) % 8]}"
    return f"{'GPIO' if esp32 else 'GP'}{pin}"


def _pins_in_use(board):
    """Yield (pin, its use, a note) of each pin in use."""
    from host_tools.wiring.parts import motor_pins

    coils = motor_pins(board["drive"]["kind"])
    for axis in board["axes"]:
        for pin, coil in zip(axis["pins"], coils):
            yield pin, f"motor {axis['name'].upper()} {coil.upper()}", ""
    yield board["tool"]["pin"], "tool", _active_text(board["tool"])
    if board.get("gantry"):
        for pin, coil in zip(board["gantry"]["pins"], coils):
            yield pin, f"motor {board['gantry']['axis'].upper()}2 {coil.upper()}", ""
    for item in board.get("encoders", ()):
        for pin, wire in zip(item["pins"], "AB"):
            yield pin, f"encoder {item['motor'].upper()} {wire}", ", pull-up"
    if board.get("registers"):
        for key in ("clock", "latch", "in", "out"):
            yield board["registers"][key], f"registers' {key}", ""
        for item in board["registers"]["edges"]:
            yield item["pin"], f"edges of {item['inputs'].replace(' ', ', ')}", ""
        if board["registers"]["tool"] >= 0:
            yield board["registers"]["tool"], "out tool", _active_text(board["tool"])
    if board.get("servo"):
        yield board["servo"]["pin"], "servo", ", 50 Hz"
    if board.get("drivers"):
        yield board["drivers"]["tx"], "drivers TX", f", {board['drivers']['baud']} baud, behind 1 kΩ"
        yield board["drivers"]["rx"], "drivers RX", ", the same wire"
    yield from spi_pins(board)
    if board.get("inverter"):
        yield board["inverter"]["tx"], "inverter TX", f", {board['inverter']['baud']} baud"
        yield board["inverter"]["rx"], "inverter RX", ""
    for key, pin in board.get("shift", {}).items():
        if pin >= 0:
            yield pin, f"registers' {key}", ""
    if board["spindle"]["pwm"]:
        yield board["spindle"]["pin"], "tool PWM", f", {board['spindle']['pwm_hz']} Hz"
    for item in board["inputs"]:
        pull = "" if item["pin"] >= 100 else f", pull-{item['pull']}"
        yield item["pin"], f"in {item['name']}", f"{_active_text(item)}{pull}{', halts' if item['halt'] else ''}"
    for item in board["outputs"]:
        yield item["pin"], f"out {item['name']}", _active_text(item)
    for link in board["links"]:
        if link["port"].startswith("uart"):
            uart = link["port"].upper()
            yield link["tx"], f"{uart} TX", f", to the RX of the other side: {link['protocol']}, {link['baud']} baud"
            yield link["rx"], f"{uart} RX", ", from the TX of the other side"


# A Pico from above, USB at the top: pins 1 … 20 down the left side, 40 … 21 down the right one.
_LEFT = "GP0 GP1 GND GP2 GP3 GP4 GP5 GND GP6 GP7 GP8 GP9 GND GP10 GP11 GP12 GP13 GND GP14 GP15".split()
_RIGHT = "VBUS VSYS GND 3V3_EN 3V3 VREF GP28 GND GP27 GP26 RUN GP22 GND GP21 GP20 GP19 GP18 GND GP17 GP16".split()


def _pico_drawing(uses):
    """Yield the lines of a drawing of a Pico. `uses`: {pin: text}."""
    labels = {f"GP{pin}": text for pin, text in uses.items()}
    width = max(len(text) for text in labels.values())
    yield f"    {'':{width}}          ┌─ USB ─┐"
    for number, (left, right) in enumerate(zip(_LEFT, _RIGHT), 1):
        yield (
            f"    {labels.get(left, ''):>{width}}  {left:>4} {number:2} │       │ {41 - number} {right:<6} {labels.get(right, '')}"
        ).rstrip()
    yield f"    {'':{width}}          └───────┘"
    yield ""


def _active_text(item):
    """Return the level at which an input or output is active, as a note."""
    return f", active {'high' if item['active'] else 'low'}"


# --- settings


def setting_rows():
    """Return a row for each setting, with its value on the example board; it has not those of rare keys."""
    from passo.config import boardfile, setting_numbers

    from host_tools.clients.setting_names import rule_of

    board = boardfile.check(boards.load(EXAMPLE))
    rows = [f"| setting | meaning | unit | bounds | `{EXAMPLE}` |", "| --- | --- | --- | --- | ---: |"]
    for number, (_, places, default, _, _) in sorted(setting_numbers.make(board).items()):
        name, unit, least, most = rule_of(number, len(board["axes"]))
        value = default / 10**places
        rows.append(f"| `${number}` | {name} | {unit} | {least:g} … {most:.10g} | {value:.{places}f} |")
    for number, languages in ((150, "plotter, torch"), (151, "plotter, torch"), (170, "torch"), (171, "torch"), (180, "plotter"), (181, "pulses"), (182, "pulses")):
        name, unit, least, most = rule_of(number, len(board["axes"]))
        rows.append(f"| `${number}` | {name} (language {languages}) | {unit} | {least:g} … {most:.10g} | – |")
    for option, own in options.words_of_options().items():
        numbers = [*getattr(own, "SETTINGS", {}), *(first + axis for first in getattr(own, "AXIS_SETTINGS", {}) for axis in range(len(board["axes"])))]
        for number in numbers:
            name, unit, least, most = rule_of(number, len(board["axes"]))
            rows.append(f"| `${number}` | {name} ([key `{getattr(own, 'KEY', option)}`]({own.PAGE})) | {unit} | {least:g} … {most:.10g} | – |")
    return rows


# --- errors


def error_rows():
    """Return a row for each number; those of the compiler behind the firmware's."""
    from host_tools.programs import program_errors

    texts = sorted(options.error_texts().items()) + sorted(program_errors.TEXTS.items())
    return ["| number | meaning |", "| ---: | --- |", *[f"| {number} | {text} |" for number, text in texts]]


PAGES = {"board-file.md": board_keys, "pins.md": pin_rows, "settings.md": setting_rows, "errors.md": error_rows}

if __name__ == "__main__":
    for _name in PAGES:
        (DOCS / _name).write_text(page_text(_name), encoding="utf-8")
        print(f"docs/reference/{_name}")

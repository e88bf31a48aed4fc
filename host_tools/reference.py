"""Writes the tables of docs/ that repeat what the firmware knows: board-file keys, pins, settings, errors.

    python -m host_tools.reference          # writes board-file.md, wiring.md, settings.md and errors.md of docs/ anew

Of each page only what stands between its two marks is made; the rest is written by hand. tests_host/test_docs.py fails
while a page is not current.
"""

import re

from host_tools.failure import Failure
from host_tools.resources import ROOT

DOCS = ROOT / "docs"
BEGIN = "<!-- made by python -m host_tools.reference: change the firmware's table, not these lines -->"
END = "<!-- end -->"
EXAMPLE = "router_3axis"


def text(name):
    """What a page of PAGES should hold. Raises Failure if a table cannot be made."""
    path = DOCS / name
    text = path.read_text(encoding="utf-8")
    wanted = "\n".join([BEGIN, "", *PAGES[name](), "", END])
    found = re.subn(re.escape(BEGIN) + ".*?" + re.escape(END), lambda _: wanted, text, flags=re.DOTALL)
    if found[1] != 1:
        raise Failure(f"{path} must have the two marks once")
    return found[0]


# --- board file


def board_keys():
    """A table a section of the schema."""
    from passo.control import boardfile

    from host_tools.board_keys import MEANINGS, SECTIONS

    rows = []
    meanings = dict(MEANINGS)
    for section, (title, intro) in SECTIONS.items():
        rules, note = _section(boardfile, section)
        rows += ["", f"### {title}", "", intro + note, "", "| key | value | default | meaning |", "| --- | --- | --- | --- |"]
        for key, rule in rules.items():
            path = f"{section}.{key}" if section else key
            if path in SECTIONS:
                continue
            meaning = meanings.pop(path, None)
            if meaning is None:
                raise Failure(f"host_tools/board_keys.py does not say what {path} means")
            rows.append(f"| `{key}` | {_kind(rule)} | {_default(rule, boardfile.MUST)} | {meaning} |")
    if meanings:
        raise Failure(f"host_tools/board_keys.py has keys that no board file has: {', '.join(meanings)}")
    return rows[1:]


def keys(rules, prefix=""):
    """The dotted paths of all keys of a schema that have no section of their own."""
    for key, rule in rules.items():
        inner = rule[0] if isinstance(rule, list) else rule
        if isinstance(inner, dict):
            yield from keys(inner, prefix + key + ".")
        else:
            yield prefix + key


def _section(boardfile, name):
    """(the rules of a section, what to say of its presence)."""
    if not name:
        return boardfile._BOARD, ""
    rule = boardfile._BOARD[name]
    optional = " May be left out."
    if isinstance(rule, list):
        return rule[0], f" {rule[1]} … {rule[2]} of them." + ("" if rule[1] else optional)
    return rule, optional if name in boardfile._OPTIONAL else " Needed."


def _number(value):
    return f"{value:,}".replace(",", " ")


def _kind(rule):
    if isinstance(rule[0], str):
        return ", ".join(f'`"{choice}"`' for choice in rule)
    kind, _, least, most = rule
    if kind is bool:
        return "True or False"
    bounds = f"{_number(least)} … {_number(most)}"
    if kind is int:
        return bounds
    if least == most:
        bounds = str(least)
    return {str: "text of {} characters", list: "list of {} numbers", dict: "dict of {} entries"}[kind].format(bounds)


def _default(rule, must):
    if isinstance(rule[0], str):
        return f'`"{rule[0]}"`'
    if rule[1] is must:
        return "**needed**"
    return f"`{rule[1]!r}`".replace("'", '"')


# --- pins


def pins():
    """A table of each board file's pins, in their order."""
    from passo.control.boardfile import check

    from host_tools import boards

    rows = []
    for name in boards.names():
        board = check(boards.load(name))
        rows += ["", f"### {name}", "", f"| {board['chip']} | goes to |", "| --- | --- |"]
        prefix = "GPIO" if board["chip"].startswith("esp32") else "GP"
        rows += [f"| {prefix}{pin} | {what} |" for pin, what in sorted(_pins(board))]
    return rows[1:]


def _pins(board):
    from passo.drives import pbl3770a, unipolar

    coils = {"step_dir": ("step", "dir"), "unipolar": unipolar.PINS, "pbl3770a": pbl3770a.PINS}[board["drive"]["kind"]]
    for axis in board["axes"]:
        for pin, coil in zip(axis["pins"], coils):
            yield pin, f"motor {axis['name'].upper()}: {coil.upper()}"
    yield board["tool"]["pin"], f"tool; {_active(board['tool'])}"
    if board["spindle"]["pwm"]:
        yield board["spindle"]["pin"], f"PWM of the tool's power, {board['spindle']['pwm_hz']} Hz"
    for item in board["inputs"]:
        halt = ", halts" if item["halt"] else ""
        yield item["pin"], f"input `{item['name']}`; {_active(item)}, pull-{item['pull']}{halt}"
    for item in board["outputs"]:
        yield item["pin"], f"output `{item['name']}`; {_active(item)}"
    for link in board["links"]:
        if link["port"] != "usb":
            about = f"link `{link['name']}`: {link['protocol']}, {link['baud']} baud"
            yield link["tx"], f"{link['port'].upper()} TX, to the PC's RX; {about}"
            yield link["rx"], f"{link['port'].upper()} RX, from the PC's TX"


def _active(item):
    return f"active {'high' if item['active'] else 'low'}"


# --- settings


def settings():
    """A row a setting, with its value on the example board."""
    from passo.control import boardfile, setting_table

    from host_tools import boards
    from host_tools.setting_names import rule

    board = boardfile.check(boards.load(EXAMPLE))
    rows = [f"| setting | meaning | unit | bounds | `{EXAMPLE}` |", "| --- | --- | --- | --- | ---: |"]
    for number, (_, places, default, _, _) in sorted(setting_table.make(board).items()):
        name, unit, least, most = rule(number, len(board["axes"]))
        value = default / 10**places
        rows.append(f"| `${number}` | {name} | {unit} | {least:g} … {most:.10g} | {value:.{places}f} |")
    return rows


# --- errors


def errors():
    """A row a number."""
    from passo import errors as table

    return ["| number | meaning |", "| ---: | --- |", *[f"| {number} | {table.text(number)} |" for number in table.numbers()]]


PAGES = {"board-file.md": board_keys, "wiring.md": pins, "settings.md": settings, "errors.md": errors}

if __name__ == "__main__":
    for _name in PAGES:
        (DOCS / _name).write_text(text(_name), encoding="utf-8")
        print(f"docs/{_name}")

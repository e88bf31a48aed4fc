"""`passo wiring`: each pin of a board file leads to its part, once; no text lies on another, no wire runs along another or through a box."""

import copy
import re
import subprocess
import xml.etree.ElementTree as ElementTree
from functools import lru_cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from host_tools import boards, interpreter, language
from host_tools.failure import Failure
from host_tools.resources import ROOT
from host_tools.wiring import table
from host_tools.wiring.drawing import wiring_svg
from host_tools.wiring.parts import REGISTER_BIT, common_enable, motors_of, parts_of
from passo.config.boardfile import check, pin_claims

ImageFont = pytest.importorskip("PIL.ImageFont")
matplotlib = pytest.importorskip("matplotlib")
SVG = "{http://www.w3.org/2000/svg}"
THOUSANDTH = 0.001  # the font is measured at a size of 1000


@pytest.fixture(params=("en", "pt"))
def spoken(request):
    language.choose_language(request.param)
    yield request.param
    language.choose_language(None)


def checked(name):
    return check(boards.load(name))


def expected(board):
    """{pin as `data-pin` has it: names of the parts that it leads to}, by the claims of the firmware's own check."""
    claims = pin_claims(board)
    power = "power" if board["tool"]["pin"] >= REGISTER_BIT else "tool"
    whole = {"tool": "tool", "spindle's power": power, "input of the registers": "registers", "input of the card": "card", "drivers": "drivers", "spi_drivers": "drivers", **{name: name for name in ("inverter", "card", "servo")}}
    begun = {"axis ": "motor_", "input of encoder ": "encoder_", "input ": "in_", "output ": "out_", "link ": "link_"}
    found = {}
    for pin, who in claims:
        name = re.sub(r"(?<=.) (tx|rx|sck|mosi|miso|cs|pin)$", "", who)
        part = whole.get(name)
        if part is None and name.startswith(("registers'", "shift.")):
            part = "registers"
        if part is None and "registers' edges" in name:
            part = f"edge_{pin}"
        if part is None:
            start = next(each for each in begun if name.startswith(each))
            part = begun[start] + name.removeprefix(start)
        key = str(pin) if pin < REGISTER_BIT else f"out {pin}"
        found[key] = {part}
    for way, items in (("in", board["inputs"]), ("out", board["outputs"])):
        found.update({f"{way} {item['pin']}": {f"{way}_{item['name']}"} for item in items if item["pin"] >= REGISTER_BIT})
    if board.get("registers") and board["registers"]["tool"] >= 0:
        found[f"out {board['registers']['tool']}"] = {"tool_out"}
    if common_enable(board) is not None:
        found[str(common_enable(board))] = {f"motor_{name}" for name, _ in motors_of(board)}
    return found


@lru_cache
def font(bold):
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), 1000)


def moved(element, x, y):
    found = re.search(r"translate\(([-\d.]+) ([-\d.]+)\)", element.get("transform", ""))
    return (x + float(found[1]), y + float(found[2])) if found else (x, y)


def elements(root):
    """(element, x and y of its origin, name of the box it stands in) of all of a drawing."""

    def walk(element, x, y, box):
        for child in element:
            inside = child.get("data-box", box)
            yield child, x, y, inside
            yield from walk(child, *moved(child, x, y), inside)

    yield from walk(root, 0, 0, None)


def text_boxes(root):
    """[(text, left, top, right, bottom, box)]"""
    found = []
    for element, x, y, box in elements(root):
        if element.tag == SVG + "text":
            size = float(element.get("font-size"))
            wide = font(element.get("font-weight") == "bold").getlength(element.text) * size * THOUSANDTH
            left = x + float(element.get("x")) - {"middle": wide / 2, "end": wide}.get(element.get("text-anchor"), 0)
            base = y + float(element.get("y"))
            found.append((element.text, left, base - 0.73 * size, left + wide, base + 0.2 * size, box))
    return found


def boxes(root):
    """{part or "": (left, top, right, bottom)}; "" is the module."""
    found = {}
    for element, x, y, box in elements(root):
        if element.tag == SVG + "rect" and (box is not None or element.get("stroke-width") == "0.5"):
            left, top = x + float(element.get("x")), y + float(element.get("y"))
            found.setdefault(box or "", []).append((left, top, left + float(element.get("width")), top + float(element.get("height"))))
    return found


def wires(root):
    """[(pin, part, terminal, points)]"""
    found = []
    for element, x, y, _ in elements(root):
        if element.get("data-pin"):
            points = [(x + float(a), y + float(b)) for a, b in re.findall(r"([\d.-]+) ([\d.-]+)", element.get("d"))]
            found.append((element.get("data-pin"), element.get("data-part"), element.get("data-terminal"), points))
    return found


def pads(root):
    found = {}
    for element, x, y, _ in elements(root):
        if element.get("data-pad"):
            assert element.get("data-pad") not in found, "a pad twice"
            found[element.get("data-pad")] = x + float(element.get("cx")), y + float(element.get("cy"))
    return found


def meet(one, two, by=0.0):
    return one[0] < two[2] - by and two[0] < one[2] - by and one[1] < two[3] - by and two[1] < one[3] - by


def pieces(drawn):
    """[(pin, left, top, right, bottom)] of the straight pieces of all wires."""
    return [(pin, min(a[0], b[0]), min(a[1], b[1]), max(a[0], b[0]), max(a[1], b[1]))
            for pin, _, _, points in drawn for a, b in zip(points, points[1:])]  # fmt: skip


def faults(text, board):
    """Return the faults of a drawing."""
    root = ElementTree.fromstring(text)
    drawn, frames, found = wires(root), boxes(root), []
    led = {}
    for pin, part, _, points in drawn:
        led.setdefault(pin, []).append(part)
        if points[0] != pads(root)[pin]:
            found.append(f"the wire of {pin} does not begin at its pad")
        if not any(min(abs(points[-1][0] - box[0]), abs(points[-1][0] - box[2])) < 0.02 and box[1] <= points[-1][1] <= box[3] for box in frames[part]):
            found.append(f"the wire of {pin} does not end at {part}")
    wanted = {pin: sorted(names) for pin, names in expected(board).items()}
    if {pin: sorted(names) for pin, names in led.items()} != wanted:
        found.append(f"wires lead to {led}, not {wanted}")
    texts = text_boxes(root)
    wide, tall = map(float, root.get("viewBox").split()[2:])
    found += [f"{one[0]!r} lies on {two[0]!r}" for at, one in enumerate(texts) for two in texts[:at] if meet(one[1:5], two[1:5])]
    found += [f"{one[0]!r} leaves the sheet" for one in texts if not (0 < one[1] and one[3] < wide and 0 < one[2] and one[4] < tall)]
    for each in texts:
        if each[5] is not None and not any(box[0] < each[1] and each[3] < box[2] and box[1] < each[2] and each[4] < box[3] for box in frames[each[5]]):
            found.append(f"{each[0]!r} leaves the box of {each[5]}")
    lines = pieces(drawn)
    for at, one in enumerate(lines):
        found += [f"the wire of {one[0]} passes through {name}" for name, some in frames.items() for box in some if meet(one[1:], box, 0.05)]
        for two in lines[:at]:
            along = (one[1] == one[3]) == (two[1] == two[3]) and (one[2] == one[4]) == (two[2] == two[4])
            if one[0] != two[0] and along and meet((one[1] - 0.2, one[2] - 0.2, one[3] + 0.2, one[4] + 0.2), (two[1] - 0.2, two[2] - 0.2, two[3] + 0.2, two[4] + 0.2)):
                found.append(f"the wires of {one[0]} and {two[0]} run along each other")
    kept = [box for some in frames.values() for box in some]
    found += ["two boxes lie on each other" for at, one in enumerate(kept) for two in kept[:at] if meet(one, two)]
    return found + (["the sheet is longer than A4"] if tall > 297 else [])


@pytest.mark.parametrize("name", boards.names())
def test_a_shipped_board_is_drawn(name, spoken):
    board = checked(name)
    text = wiring_svg(board)
    assert faults(text, board) == []
    assert f'lang="{spoken}"' in text


PINS = [*range(23), 26, 27, 28]


@settings(max_examples=25, deadline=None)
@given(st.permutations(PINS), st.sampled_from(["router_3axis", "plotter_2014", "laser_xy", "lpt_router"]))
def test_any_pins_are_drawn(pins, name):
    """A player that takes any pins; the pins of the serial line stay where the chip has them."""
    board = copy.deepcopy(boards.load(name))
    board["player"] = "timer"
    kept = {pin for link in board["links"] if link["port"] == "uart0" for pin in (link["tx"], link["rx"])}
    free = iter(pin for pin in pins if pin not in kept)
    for axis in board["axes"]:
        axis["pins"] = [next(free) for _ in axis["pins"]]
    for item in [board["tool"], *board.get("inputs", ()), *board.get("outputs", ())]:
        item["pin"] = next(free)
    if board.get("spindle", {}).get("pwm"):
        board["spindle"]["pin"] = next(free)
    whole = check(board)
    assert faults(wiring_svg(whole), whole) == []


def test_faults_are_found():
    board = checked("router_3axis")
    text = wiring_svg(board)
    one, two = re.findall(r'<text x="[\d.]+" y="[\d.]+"', text)[5:7]
    wire = re.search(r'<path d="M84 ([\d.]+)L.*?data-pin="2".*?>', text)
    for changed in (
        text.replace(two, one),
        text.replace(wire[0], ""),
        text.replace(wire[0], wire[0].replace('data-part="motor_x"', 'data-part="motor_y"')),
        text.replace(f"M84 {wire[1]}L", f"M84 {float(wire[1]) + 4.4}L"),
        text.replace("limit_x: limit X", "limit_x: limit X " * 3),
    ):
        assert changed != text and faults(changed, board)


@pytest.mark.parametrize("name", boards.names())
def test_the_table_has_each_pin_once(name, spoken):
    board = checked(name)
    rows = table.wiring_rows(board)
    assert len(rows) == sum(map(len, expected(board).values())) == sum(len(part.terminals) for part in parts_of(board))
    assert all(len(row) == 5 and row[0] and row[2] for row in rows)
    assert len({row[0] for row in rows}) == len(expected(board))


def test_positions_are_those_of_the_pico():
    rows = {row[0]: row[1] for row in table.wiring_rows(checked("router_3axis"))}
    assert rows["GP0"] == "1" and rows["GP15"] == "20" and rows["GP16"] == "21" and rows["GP27"] == "32"


def test_a_sheet_too_small():
    board = boards.load("mill_2004")
    whole = check(copy.deepcopy(board))
    whole["links"] = [{"name": f"l{number}", "port": "uart1", "tx": 4, "rx": 5, "baud": 9600, "protocol": "grbl"} for number in range(9)]
    with pytest.raises(Failure, match="parts do not fit"):
        wiring_svg(whole)


def passo(*words):
    return subprocess.run([*interpreter.passo(), *words], cwd=ROOT, capture_output=True, text=True)


def test_the_command(tmp_path):
    out = tmp_path / "router.svg"
    assert passo("wiring", "router_3axis", "--out", str(out)).stdout == f"{out}\n"
    assert out.read_text(encoding="utf-8") == wiring_svg(checked("router_3axis"))
    assert re.search(r"GP27\s+32\s+stop", passo("wiring", "router_3axis").stdout)
    wrong = passo("wiring", "router_3axis", "--out", "router.png")
    assert wrong.returncode == 1 and "SVG" in wrong.stderr
    assert "unknown board" in passo("wiring", "nothing").stderr

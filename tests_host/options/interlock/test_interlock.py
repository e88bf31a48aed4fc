"""The interlock's tables: the mill's against its document's equations, the pins against both, other machines' against rules."""

import ast
import inspect
import random
import re
from itertools import product

import pytest
from mill_equations import EQUATIONS, allowed

from host_tools import boards
from host_tools.cli.interlock import Row, Table, draw_table, truth_table
from host_tools.failure import Failure
from host_tools.resources import ROOT
from host_tools.sim.machine import VirtualMachine
from passo.options.interlock import manifest_table
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.protocols.plotter.host import COMMANDS, packet
from passo.protocols.torch import protocol as torch
from passo.options.interlock.steps_viper import INTERLOCK_TOOL, find_denied

pytestmark = pytest.mark.quick
MILL = Table(boards.load("mill_2004"))
NAMES = ("bxa", "bxb", "bya", "byb", "bza", "bzb", "dx1", "dx2", "dy", "dz", "urg", "pal", "sel")


def combinations(names):
    return [dict(zip(names, levels)) for levels in product((0, 1), repeat=len(names))]


# --- the mill's rows are its document's equations


def test_every_equation_of_the_document_is_a_row():
    assert set(MILL.rows) == set(EQUATIONS) and len(EQUATIONS) == 19


@pytest.mark.parametrize("name", EQUATIONS)
def test_row_is_the_documents_equation(name):
    """Over every combination of the inputs of either, which covers every combination of all."""
    row, equation = MILL.rows[name], EQUATIONS[name]
    names = list(inspect.signature(equation).parameters)
    assert set(row.names) <= set(names)
    for states in combinations(names):
        assert row.is_true(states) == bool(equation(**states)), states


def test_the_parallel_port_never_moves_x2():
    for states in combinations(("bxa", "bxb", "dx1", "dx2", "hx2c", "sx2c", "sel")):
        assert not (MILL.rows["hx2"].is_true(states) and not states["sel"])
    assert not any(name.endswith("p") for name in MILL.rows["hx2"].names + MILL.rows["sx2"].names)


def test_a_parallel_port_program_on_the_table():
    """The external multiplexer as the rows have it, with random pulses from both sources: no carriage passes a limit by more
    than the step that hits it, X2 never moves by the port, and an emergency stop cuts the drives, not the pulses."""
    rng = random.Random(5)
    places, ends = {"x": 5, "x2": 5, "y": 5, "z": 5}, (0, 40)
    states = dict.fromkeys(NAMES, 0)
    states.update(dx1=1, dx2=1, dy=1, dz=1)
    moved = {"x": 0, "x2": 0, "y": 0, "z": 0}
    cut = 0
    for count in range(20_000):
        if count % 50 == 0:
            states.update(sel=rng.randrange(2), urg=int(rng.random() < 0.1), pal=int(rng.random() < 0.2))
        for axis, low, high in (("x", "bxa", "bxb"), ("y", "bya", "byb"), ("z", "bzb", "bza")):
            states[low], states[high] = int(places[axis] <= ends[0]), int(places[axis] >= ends[1])
        for name in ("hxc", "hx2c", "hyc", "hzc", "hxp", "hyp", "hzp", "sxc", "sx2c", "syc", "szc", "sxp", "syp", "szp", "rc0"):
            states[name] = rng.randrange(2)
        states["hx2c"], states["sx2c"] = states["hxc"], states["sxc"]
        enabled = MILL.rows["enm"].is_true(states)
        for axis in places:
            if not MILL.rows["h" + axis].is_true(states):
                continue
            assert axis != "x2" or states["sel"]
            if not enabled:
                cut += states["urg"]
                continue
            step = 1 if MILL.rows["s" + axis].is_true(states) else -1
            assert not (axis == "z" and step < 0 and states["pal"])
            places[axis] += step
            moved[axis] += 1
            assert axis == "x2" or ends[0] <= places[axis] <= ends[1]
    assert min(moved.values()) > 1000 and cut > 100


# --- the pins are at most stricter


def pins(states):
    """Return the mask of all that the compiled masks forbid. `states`: by the document's names."""
    now = 0
    for number, name in enumerate(MILL.inputs):
        now |= states[{"stop": "urg", "probe": "pal"}.get(name, name)] << number
    return find_denied(MILL.masks["table"], now), find_denied(MILL.masks["unasked"], now)


def test_pins_are_never_looser_than_the_equations():
    """Every combination of all inputs. Steps and spindle are stricter only by the emergency stop."""
    bits = MILL.bits
    for states in combinations(NAMES):
        forbidden, not_by_itself = pins(states)
        for axis in "xyz":
            for sign, forward in (("+", 1), ("-", 0)):
                may = not forbidden & bits[axis + sign]
                assert may == (bool(allowed(axis, forward, states)) and not states["urg"]), (axis, sign, states)
        may = not forbidden & bits["enable"]
        assert may == bool(EQUATIONS["enm"](rc0=1, sel=states["sel"], urg=states["urg"]))
        may = not forbidden & bits["tool"]
        assert may == bool(EQUATIONS["s_tvt"](rc1=1, sel=states["sel"], urg=states["urg"]))
        may = not forbidden & bits["vacuum"]
        assert may == bool(EQUATIONS["s_asp"](rc2=1, sel=states["sel"], asp=0))
        assert not (may and not EQUATIONS["s_asp"](rc2=1, sel=states["sel"], asp=1))
        alone = not not_by_itself & bits["enable"]
        assert alone == bool(EQUATIONS["enm"](rc0=0, sel=states["sel"], urg=states["urg"]))
    gated = MILL.masks["unasked"][1]
    assert gated & bits["enable"] and not gated & INTERLOCK_TOOL, "the spindle never by itself"


def test_without_leave_nothing_is_on_unasked():
    board = boards.load("mill_2004")
    board["interlock"] = {**board["interlock"], "unasked_ms": 0}
    assert check(board)["additions"].masks["unasked"][:2] == [0, 0]


def test_what_a_filter_may_wait_for_is_known():
    """Inputs whose rise may forbid, and those whose fall may: none of the mill's is both."""
    rise = {name for number, name in enumerate(MILL.inputs) if MILL.masks["rise"] >> number & 1}
    fall = {name for number, name in enumerate(MILL.inputs) if MILL.masks["fall"] >> number & 1}
    assert rise == {"bxa", "bxb", "bya", "byb", "bza", "bzb", "stop", "probe"}
    assert fall == {"dx1", "dx2", "dy", "dz", "sel"}


# --- other machines: the tables of docs/use/interlock.md against the rules stated beside them


def documented():
    """[(board name, inputs, interlock, rules)] of the page."""
    text = (ROOT / "docs" / "use" / "interlock.md").read_text(encoding="utf-8")
    found = []
    for part in text.split("\n### ")[1:]:
        name = part.splitlines()[0].strip("` ")
        code = "\n".join(line[4:] for line in part.splitlines() if line.startswith("    "))
        rules = re.findall(r"^- `(.+?)` only if `(.+?)`", part, re.MULTILINE)
        found.append(pytest.param(name, ast.literal_eval("{" + code + "}"), rules, id=name))
    return found


def with_table(name, section):
    board = boards.load(name)
    board["inputs"] = list(board.get("inputs", ())) + section.get("inputs", [])
    board["interlock"] = section["interlock"]
    return board


@pytest.mark.parametrize("name, section, rules", documented())
def test_a_documented_table_keeps_its_rules(name, section, rules):
    """Every combination of all inputs: a gated step or output is allowed exactly if its rule, in Python's words, is true."""
    table = Table(with_table(name, section))
    gated = table.rows_of_gates()
    assert {each for names, _ in rules for each in names.split("` `")} == set(gated), "a rule for each"
    for names, rule in rules:
        meaning = compile(rule, "rule", "eval")
        for states in combinations(table.inputs):
            for each in names.split("` `"):
                assert gated[each].is_true(states) == bool(eval(meaning, {}, states)), (each, states)


@pytest.mark.parametrize("name, section, rules", documented())
def test_a_documented_table_lets_the_machine_run_and_stops_it(name, section, rules):
    """On the plant: it homes, if it can; then its emergency stop, or the first limit, ends what is under way."""
    board = with_table(name, section)
    board["links"] = [{**board["links"][0], "protocol": "grbl"}]
    machine = VirtualMachine(board, start=(400,) * len(board["axes"]) if name != "router_3axis" else (400, 400, -400), trace=None)
    machine.run_ms(30)
    machine.send(b"$H\n" if board.get("homing") else b"$X\n")
    machine.settle()
    assert b"ok" in machine.take() and machine.plant.errors == []
    has_stop = any(item["name"] == "stop" for item in board["inputs"])
    machine.send(b"$20=0\n")
    machine.send(b"$MOTORS=1\n" if name == "torch_manipulator" else b"\n")
    machine.run_ms(100)
    machine.send(b"G91G1X3F300\n" if has_stop else b"G91G1X-9F600\n")
    machine.run_ms(300)
    if has_stop:
        machine.plant.set_input(machine.port.now, "stop", True)
    machine.run_ms(100)
    machine.settle()
    assert b"ALARM:1" in machine.take() and machine.app.controller.machine.log.entries[-1][2] in ("stop", "barrier_x")
    if board.get("homing"):
        assert machine.app.controller.position() == machine.plant.position, "exact"
    assert machine.plant.errors == []


def language_machine(name, protocol, **changes):
    """A machine of another language with its documented table."""
    section = next(param.values[1] for param in documented() if param.id == name)
    board = {**with_table(name, section), **changes}
    board["links"] = [{**board["links"][0], "protocol": protocol}]
    machine = VirtualMachine(board, start=(400, 400), trace=None)
    machine.app.controller.machine.guarded = 0
    machine.app.controller.machine.unlock()
    machine.run_ms(30)
    return machine


def log_of(machine):
    return [entry[1:] for entry in machine.app.controller.machine.log.entries]


@pytest.mark.parametrize(
    "board, protocol, press, towards, away",
    [
        ("torch_manipulator", "torch", "stop", torch.move(40, 4000, 0, 0), None),
        ("plotter_2014", "plotter", "barrier_y", packet(COMMANDS["DOWN"]), packet(COMMANDS["UP"])),
        ("laser_xy", "pulses", "limit_x", b"{jog x -40}", b"{jog x 40}"),
    ],
)
def test_every_language_is_refused_what_is_forbidden(board, protocol, press, towards, away):
    """Nothing moves, and the log names the input; away from it the axis moves."""
    machine = language_machine(board, protocol, **({"step_program": {}} if protocol == "pulses" else {}))
    machine.send({"torch": torch.frame("CONNECT"), "plotter": packet(COMMANDS["UP"]), "pulses": b""}[protocol])
    machine.run_ms(100)
    machine.settle()
    before = list(machine.plant.position)
    interlock = machine.port.veto
    interlock.take_change(interlock._names.index(press), 1)
    machine.send(towards)
    for _ in range(8):
        machine.cycle()
    assert machine.plant.position == before and {(131, press), (220, press)} & set(log_of(machine)), log_of(machine)
    if away:
        interlock.take_change(interlock._names.index(press), 1)
        machine.send(away)
        machine.run_ms(30)
        machine.settle()
        assert machine.plant.position != before and machine.app.controller.machine.alarm == 0
    machine.settle()
    at = list(machine.plant.position)
    machine.run_ms(100)
    if protocol == "torch":  # without its relays it is an alarm
        machine.send(torch.passo(torch.UNLOCK_OF) + torch.frame("CONNECT"))
        machine.run_ms(100)
        assert machine.app.controller.machine.alarm == 220
        machine.send(torch.frame("STOP"))
        machine.run_ms(30)
        machine.send(torch.passo(torch.UNLOCK_OF))
        machine.run_ms(30)
        machine.send(torch.frame("CONNECT"))
        machine.run_ms(100)
    machine.send(towards)
    machine.run_ms(30)
    machine.settle()
    assert machine.plant.position != at, "the pin is not active: it is allowed again"


def test_four_machines_have_tables():
    assert {param.id for param in documented()} == {"router_3axis", "laser_xy", "plotter_2014", "torch_manipulator"}


# --- errors in a table


def small(rows, **more):
    board = boards.load("router_3axis")
    board["interlock"] = {"rows": rows, **more}
    return board


@pytest.mark.parametrize(
    "rows, more, said",
    [
        ({"x+": "!limit_q"}, {}, "limit_q is neither an input"),
        ({"x+": "!limit_x & limit_x"}, {}, "never true"),
        ({"x+": "!(limit_x)"}, {}, "is no name"),
        ({"x+": ""}, {}, "is no name"),
        ({"x+": "a | "}, {}, "is no name"),
        ({"foo": "!stop"}, {}, "gate nothing"),
        ({"hx": "a & b & !stop"}, {"signals": {"a": "x.step", "b": "y.step"}}, "more than one"),
        ({"x": "a & !stop"}, {"signals": {"a": "y.step"}}, "more than one"),
        ({"hx": "a & !stop"}, {"signals": {"a": "x.stop"}}, "no axis's step or dir"),
        ({"hx": "a & there"}, {"signals": {"a": "x.step"}, "elsewhere": "there"}, "can never be"),
        ({}, {"limits": {"x": "limit_x"}}, "no direction 'x'"),
        ({}, {"limits": {"x+": "limit_q"}}, "neither an input"),
        ({"x+": 3}, {}, "in an interlock with texts behind them"),
        ({"x+": "!stop"}, {"row": {}}, "unknown key 'row'"),
    ],
)
def test_errors(rows, more, said):
    with pytest.raises(BoardError, match=re.escape(said)):
        check(small(rows, **more))


def test_filters_are_for_inputs_that_count():
    board = small({"x+": "!limit_x"})
    board["inputs"] = [{**item, "filter_us": 50} if item["name"] == "door" else item for item in board["inputs"]]
    with pytest.raises(BoardError, match="filter_us is for inputs"):
        check(board)
    del board["interlock"]
    with pytest.raises(BoardError, match="filter_us is for limits"):
        check(board)
    board = boards.load("mill_2004")
    board["inputs"] = [{**item, "filter_us": 50} if item["name"] == "stop" else item for item in board["inputs"]]
    with pytest.raises(BoardError, match="exclude each other"):
        check(board)


def test_a_checked_board_may_be_checked_again():
    once = check(boards.load("mill_2004"))
    assert check(once)["interlock"] == once["interlock"] and "rows" not in once["interlock"]


def test_products_that_another_covers_are_left_out():
    masks = check(small({"x+": "!stop | !stop & !door | !limit_x & door & !stop"}))["additions"].masks
    assert masks["table"][0] == 1


# --- the command


def test_truth_table_and_picture(tmp_path):
    lines = truth_table(MILL.rows_of_gates()["tool"])
    assert lines == ["tool = !stop", "    stop  tool", "       0     1", "       1     0"]
    assert len(truth_table(MILL.rows["hx"])) == 2 + 2**9
    draw_table(MILL, tmp_path / "mill.png")
    assert (tmp_path / "mill.png").stat().st_size > 5000
    with pytest.raises(Failure, match="has no interlock"):
        Table(boards.load("router_3axis"))


def test_a_row_reads_what_parse_made():
    row = Row("x", manifest_table.parse_row("a & !b | c"))
    assert [row.is_true(dict(zip("abc", levels))) for levels in product((False, True), repeat=3)] == [
        False, True, False, True, True, True, False, True
    ]  # fmt: skip

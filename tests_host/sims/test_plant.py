"""The plant against the tables and figures of the 2014 plotter's document, and against pins that break its rules."""

import random

import pytest

from host_tools import boards
from host_tools.sim.decoders import Pbl3770a, StepDir, Unipolar
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.input_faults import Fault
from host_tools.sim.parts import Barrier, Solenoid
from host_tools.sim.plant import Plant

MS = 12_500

UNIPOLAR = {
    "wave": "1000 0100 0010 0001",
    "full": "1100 0110 0011 1001",
    "half": "1000 1100 0100 0110 0010 0011 0001 1001",
}
BIPOLAR_HALF = "++0---0+", "0+++0---"


def unipolar_patterns(mode):
    """Levels of one motor, S1 lowest, from the table as printed."""
    return [sum(1 << i for i, coil in enumerate(text) if coil == "1") for text in UNIPOLAR[mode].split()]


def winding(sign, percent):
    """PH I0 I1 of one PBL3770A."""
    i0, i1 = {100: (0, 0), 60: (1, 0), 20: (0, 1), 0: (1, 1)}[percent if sign != "0" else 0]
    return (sign == "+") | i0 << 1 | i1 << 2


def bipolar_patterns(mode, percent=60):
    pairs = list(zip(*BIPOLAR_HALF))
    if mode == "full":
        pairs = [pair for pair in pairs if "0" not in pair]
    return [winding(a, percent) | winding(b, percent) << 3 for a, b in pairs]


def microsteps(mode):
    """One quarter as the currents are, the other three by turning it."""
    quarter = {"quarter": ((100, 0), (60, 20), (60, 60), (20, 60))}.get(mode) or (
        (100, 0), (100, 20), (60, 20), (100, 60), (60, 60), (60, 100), (20, 60), (20, 100),
    )  # fmt: skip
    patterns = []
    for turn in range(4):
        for a, b in quarter:
            for _ in range(turn):
                a, b = -b, a
            patterns.append(winding("0+-"[(a > 0) - (a < 0)], abs(a)) | winding("0+-"[(b > 0) - (b < 0)], abs(b)) << 3)
    return patterns


class Errors(list):
    def __call__(self, tick, text):
        self.append((tick, text))


def walk(decoder, patterns, shift=0):
    """Feed patterns one after the other; returns the position after each."""
    levels = position = 0
    positions = []
    for tick, pattern in enumerate(patterns):
        new = pattern << shift
        position += decoder.decode(tick, new, new ^ levels)
        levels = new
        positions.append(position)
    return positions


CASES = [(Unipolar, mode, unipolar_patterns(mode)) for mode in UNIPOLAR] + [
    (Pbl3770a, mode, bipolar_patterns(mode, percent)) for mode in ("full", "half") for percent in (100, 60, 20)
] + [(Pbl3770a, mode, microsteps(mode)) for mode in ("quarter", "eighth")]


@pytest.mark.parametrize("kind, mode, patterns", CASES)
@pytest.mark.parametrize("shift", (0, 6))
def test_coil_tables_forward_and_back(kind, mode, patterns, shift):
    errors = Errors()
    turns = patterns * 3
    assert walk(kind(mode, shift, 0, errors), turns, shift) == list(range(len(turns)))
    assert walk(kind(mode, shift, 0, errors), turns[::-1], shift) == [-i for i in range(len(turns))]
    assert errors == []


@pytest.mark.parametrize("kind, mode, patterns", CASES)
def test_coils_follow_random_steps(kind, mode, patterns):
    rng = random.Random(5)
    errors = Errors()
    place, places = 0, [0]
    for _ in range(500):
        place += rng.choice((-1, 1))
        places.append(place)
    assert walk(kind(mode, 0, 0, errors), [patterns[p % len(patterns)] for p in places]) == places
    assert errors == []


def test_half_steps_of_a_turn():
    decoder = Unipolar("half", 0, 0, Errors())
    assert decoder.phase is None and decoder.released
    seen = []
    for pattern in unipolar_patterns("half"):
        decoder.decode(0, pattern, 15)
        seen.append(decoder.phase)
    assert seen == list(range(0, 32, 4))


@pytest.mark.parametrize("kind, mode, patterns", CASES)
def test_a_skipped_state_is_an_error(kind, mode, patterns):
    errors = Errors()
    positions = walk(kind(mode, 0, 0, errors), [patterns[0], patterns[2]])
    assert [tick for tick, _ in errors] == [1] and "jumped" in errors[0][1]
    assert positions == ([0, 0] if len(patterns) == 4 else [0, 2])


def test_opposite_coils_and_strange_patterns_are_errors():
    for pattern in (0b0101, 0b1010, 0b0111, 0b1111):
        errors = Errors()
        assert walk(Unipolar("half", 0, 0, errors), [1, pattern, 1]) == [0, 0, 0]
        assert errors == [(1, f"coil pattern {format(pattern, '04b')[::-1]} is none of the drive's")]
    errors = Errors()
    walk(Unipolar("full", 0, 0, errors), [0b0011, 0b0010])  # a half-step state
    assert len(errors) == 1


def test_unequal_winding_currents_are_an_error():
    errors = Errors()
    decoder = Pbl3770a("half", 0, 0, errors)
    walk(decoder, [winding("+", 60) | winding("+", 60) << 3, winding("+", 60) | winding("+", 20) << 3])
    assert [tick for tick, _ in errors] == [1]


def test_all_off_keeps_the_place():
    errors = Errors()
    decoder = Unipolar("half", 0, 0, errors)
    half = unipolar_patterns("half")
    assert walk(decoder, [half[0], half[1], 0, half[1], half[2]]) == [0, 1, 1, 1, 2]
    assert walk(decoder, [0]) == [0] and decoder.released and errors == []
    # Released by hand at position 2, switched on again half a turn away: nobody knows which way it goes.
    assert walk(decoder, [half[6]]) == [0] and len(errors) == 1


def test_pbl3770a_currents():
    decoder = Pbl3770a("half", 0, 0, Errors())
    for percent in (100, 60, 20):
        decoder.decode(0, winding("+", percent) | winding("-", percent) << 3, 63)
        assert decoder.current == percent and not decoder.released
    # PH means nothing in a winding without current.
    decoder.decode(0, (winding("0", 0) | 1) << 3 | winding("0", 0), 63)
    assert decoder.current == 0 and decoder.released


def test_inverted_coils():
    errors = Errors()
    patterns = unipolar_patterns("half") * 2
    assert walk(Unipolar("half", 4, 0xF0, errors), [p ^ 15 for p in patterns], 4) == list(range(16))
    assert errors == []


# --- STEP/DIR: pulse 2 µs = 25 ticks, set-up 5 µs = 62.5 ticks


def play(decoder, *edges):
    """[(tick, levels)] → steps at each; STEP is bit 0, DIR bit 1."""
    now = decoder._inverted
    steps = []
    for tick, levels in edges:
        steps.append(decoder.decode(tick, levels, levels ^ now))
        now = levels
    return steps


def step_dir(errors, inverted=0):
    return StepDir(0, 1, inverted, 2, 5, errors)


def test_step_dir_steps_both_ways():
    errors = Errors()
    edges = (0, 2), (63, 3), (88, 2), (113, 3), (138, 2), (200, 0), (263, 1), (288, 0)
    assert play(step_dir(errors), *edges) == [0, 1, 0, 1, 0, 0, -1, 0]
    assert errors == []


@pytest.mark.parametrize("inverted", (1, 2, 3))
def test_step_dir_polarity(inverted):
    errors = Errors()
    edges = [(0, 2), (63, 3), (88, 2), (200, 0), (263, 1), (288, 0)]
    edges = [(tick, levels ^ inverted) for tick, levels in edges]
    assert play(step_dir(errors, inverted), *edges) == [0, 1, 0, 0, -1, 0]
    assert errors == []


@pytest.mark.parametrize(
    "edges, steps, error",
    [
        ([(0, 2), (62, 3), (90, 2)], [0, 1, 0], (62, "STEP too soon after DIR")),
        ([(0, 3), (30, 2)], [1, 0], (0, "STEP too soon after DIR")),
        ([(0, 1), (24, 0)], [-1, 0], (24, "STEP pulse too short")),
        ([(0, 1), (25, 0), (49, 1), (80, 0)], [-1, 0, -1, 0], (49, "STEP low for too short a time")),
        ([(0, 1), (10, 3), (30, 2)], [-1, 0, 0], (10, "DIR changed during a STEP pulse")),
    ],
)
def test_step_dir_violations(edges, steps, error):
    errors = Errors()
    assert play(step_dir(errors), *edges) == steps
    assert errors == [error]


# --- barriers, carriage, solenoid, whole plants


def barrier(bounce_ms=0, position=100, seed=1):
    return Barrier("b", 0, position, bounce_ms * MS, random.Random(seed))


def test_barrier_follows_the_carriage():
    b = barrier()
    assert not b.is_active(0)
    b.cross_edge(10)
    assert b.is_active(10) and b.due == float("inf")
    b.cross_edge(20)
    assert not b.is_active(20)
    assert barrier(position=0).is_active(0) and barrier(position=-5).is_active(0)


def test_switch_at_the_high_end():
    b = Barrier("b", 640, 100, 0, random.Random(1), high=True)
    assert not b.is_active(0) and b.last == 639
    b.cross_edge(10)
    assert b.is_active(10)
    assert Barrier("b", 640, 640, 0, random.Random(1), high=True).is_active(0)


@pytest.mark.parametrize("start", [(-600, 100, -32000), None])
def test_the_router_homes_on_its_own_switches(start):
    """X and Y at their low ends, Z at the top, from anywhere; then the whole travel is there."""
    machine = VirtualMachine("router_3axis", start=start, bounce_ms=2, seed=3)
    machine.run_ms(20)
    assert machine.ask(b"$H\n", 4).endswith(b"ok\r\n")
    assert machine.plant.position == machine.app.controller.position() == [0, 0, 0]
    machine.send(b"G0 X30 Y20 Z-80\nG0 X0 Y0 Z0\n")
    machine.settle()
    assert machine.plant.position == [0, 0, 0]
    assert not machine.plant.errors, "a sensor that trips lets the pulse under way end"


@pytest.mark.parametrize("what", [b"\x18", b"\x84", b"limit"])
def test_what_stops_at_once_cuts_no_pulse_short(what):
    """At any tick of a pulse, and with any next order to the pins: the motors' release, a jog."""
    machine = VirtualMachine("router_3axis", start=(30_000, 20_000, -20_000))
    machine.run_ms(20)
    assert machine.ask(b"$H\n", 4, 100_000).endswith(b"ok\r\n")
    chance = random.Random(7)
    for _ in range(150):
        machine.send(b"$J=G91X%dF5000\n" % chance.choice((-60, 60)) if chance.random() < 0.5 else b"G91G1X%dY9F4900\n" % chance.choice((-50, 50)))
        machine.run_ms(chance.randint(20, 60))
        machine.port.advance(chance.randint(1, 2500))
        if what == b"limit":
            machine.app.controller.machine.raise_alarm(201, "limit_x")
            machine.app.controller.machine.motors.release()
        machine.send(b"\x18" if what == b"limit" else what)
        machine.run_ms(10)
        machine.send(b"\x18")
        machine.run_ms(5)
        machine.send(b"$X\n")
        machine.run_ms(5)
        assert not machine.plant.errors


def test_barrier_bounces_and_settles():
    for seed in range(50):
        b = barrier(bounce_ms=4, seed=seed)
        b.cross_edge(1000)
        edges = []
        while b.due != float("inf"):
            edges.append(b.due)
            b.run()
        assert b.is_active(10**9) and len(edges) % 2 == 0
        assert edges == sorted(set(edges)) and all(1000 < tick <= 1000 + 4 * MS for tick in edges)
    assert any(edges), "chatter there must be"


def test_faults_of_inputs():
    for text, times in (
        ("dead", {0: True, 9 * MS: True}), ("stuck@3", {3 * MS - 1: False, 3 * MS: True}), ("pressed@2-4", {0: False, 2 * MS: True, 4 * MS - 1: True, 4 * MS: False}),
        ("broken@1", {0: False, MS: True}), ("bounces@5", {5 * MS: False}),
    ):  # fmt: skip
        fault = Fault("b", text, random.Random(1))
        assert {tick: fault.is_present(tick) for tick in times} == times, text
        assert bool(fault.bounce_ticks()) == text.startswith("bounces") and all(5 * MS < tick <= 10 * MS for tick in fault.bounce_ticks())
    for wrong in ("tired", "dead@", "dead@x", "@3", "", "bounces", "pressed@4-4", "dead@3@4"):
        with pytest.raises(ValueError, match="dead, stuck"):
            Fault("b", wrong, random.Random(1))


def test_solenoid_takes_its_time():
    s = Solenoid(60, 30)
    s.switch_coil(100, True)
    assert (s.value, s.due) == (0, 160)
    s.run()
    assert s.value == 1000
    s.switch_coil(200, False)
    assert s.due == 230
    s.switch_coil(210, True)  # let go and pressed again: it never left
    assert s.due == float("inf") and s.value == 1000


class Rows(list):
    def add_row(self, tick, position, tool):
        self.append((tick, *position, tool))


def plant_2014(**options):
    """The 2014 table with its pins attached: x coils are bits 0…3, y 4…7, the tool 8."""
    plant = Plant(boards.load("plotter_2014"), **options)
    plant.trace = Rows()
    names = [f"{axis}_s{i}" for axis in "xy" for i in (1, 2, 3, 4)] + ["tool"]
    plant.attach(0, names, 0)
    return plant


class Pins:
    """Drives a plant's pins: half steps of two unipolar motors, and the tool."""

    def __init__(self, plant):
        self.plant = plant
        self.phases = [0, 0]
        self.levels = 0
        self.tool = 0
        self.put(0)

    def put(self, tick):
        half = unipolar_patterns("half")
        levels = half[self.phases[0] % 8] | half[self.phases[1] % 8] << 4 | self.tool << 8
        self.plant.edges(tick, levels, levels ^ self.levels)
        self.levels = levels

    def step(self, tick, x, y=0):
        self.phases[0] += x
        self.phases[1] += y
        self.put(tick)


def test_plant_moves_and_traces_a_row_a_word():
    plant = plant_2014(start=(10, 20))
    pins = Pins(plant)
    pins.step(100, 1)
    pins.step(200, 1, -1)
    pins.put(300)
    assert plant.position == [12, 19]
    assert plant.trace == [(100, 11, 20, 0), (200, 12, 19, 0)]


def test_tool_arrives_between_the_steps():
    plant = plant_2014(start=(0, 0))
    pins = Pins(plant)
    pins.tool = 1
    pins.put(1000)
    arrival = 1000 + 60 * MS
    assert plant.next_event() == arrival
    pins.step(arrival - 1, 1)
    pins.step(arrival + 5, 1)
    assert plant.trace == [(arrival - 1, 1, 0, 0), (arrival, 1, 0, 1000), (arrival + 5, 2, 0, 1000)]
    assert plant.next_event() is None


def test_barriers_of_the_plant():
    plant = plant_2014(start=(-38, 500))
    pins = Pins(plant)
    assert plant.input(0, "barrier_x") == 0 and plant.input(0, "barrier_y") == 0
    pins.step(100, -1)
    assert plant.input(100, "barrier_x") == 0
    pins.step(200, -1)
    assert plant.position[0] == -40 and plant.input(200, "barrier_x") == 1
    pins.step(300, 1)
    assert plant.input(300, "barrier_x") == 0


def test_hard_end_stalls_and_is_recorded():
    plant = plant_2014(start=(-139, 0))
    pins = Pins(plant)
    for i in range(1, 5):
        pins.step(i * 100, -1)
    assert plant.position[0] == -140 and plant.carriages[0].lost == 3
    assert plant.errors == [(200, "x ran into its hard end at -140")]
    pins.step(900, 1)
    assert plant.position[0] == -139
    assert len(plant.trace) == 2


def test_start_is_checked_or_random():
    seen = {tuple(Plant(boards.load("plotter_2014"), seed=seed).position) for seed in range(20)}
    assert len(seen) == 20
    assert all(-140 <= x <= 4100 and -140 <= y <= 3100 for x, y in seen)
    assert Plant(boards.load("plotter_2014"), seed=3).position == Plant(boards.load("plotter_2014"), seed=3).position
    with pytest.raises(ValueError, match="hard ends"):
        plant_2014(start=(-141, 0))
    with pytest.raises(ValueError, match="one an axis"):
        plant_2014(start=(1,))
    with pytest.raises(ValueError, match="no input lid; the machine has barrier_x, barrier_y"):
        plant_2014(faults={"lid": "dead"})


def router():
    board = dict(boards.load("plotter_2014"))
    board["drive"] = {"kind": "step_dir", "step_active": 0}
    board["axes"] = [
        {"name": name, "pins": [2 * i, 2 * i + 1], "steps_per_m": 80_000, "travel_steps": 800, "reversed": name == "y"}
        for i, name in enumerate("xyz")
    ]
    board["homing"] = None
    board["outputs"] = [{"name": "enable", "pin": 20, "active": 0}]
    board["inputs"] = [{"name": "stop", "pin": 21, "active": 0}]
    return board


def test_step_dir_plant_with_enable_and_reversed_axis():
    plant = Plant(router(), start=(0, 0, 0))
    names = ["x_step", "y_step", "z_step", "x_dir", "y_dir", "z_dir", "tool"]
    levels = 0b010111  # STEP active low, Y's DIR the other way round
    plant.attach(0, names, levels)

    def put(tick, new):
        nonlocal levels
        plant.edges(tick, new, new ^ levels)
        levels = new

    def pulse(tick):
        put(tick, levels & ~0b111)
        put(tick + 25, levels | 0b111)

    pulse(1000)
    assert plant.position == [0, 0, 0]
    assert plant.errors[0] == (1000, "x stepped while the drivers are disabled") and plant.error_count == 3
    plant.output(1500, "enable", 0)
    put(1600, levels ^ 0b111000)
    pulse(2000)
    assert plant.position == [1, 1, 1]
    assert plant.error_count == 3


def test_other_inputs():
    plant = Plant(router(), start=(0, 0, 0))
    assert plant.input(0, "stop") == 1
    plant.set_input(0, "stop", True)
    assert plant.input(0, "stop") == 0
    with pytest.raises(ValueError):
        plant.set_input(0, "lid", True)


def test_mirrored_coil_motor():
    board = dict(boards.load("plotter_2014"))
    board["axes"] = [dict(axis, reversed=axis["name"] == "x") for axis in board["axes"]]
    plant = Plant(board, start=(100, 100))
    plant.attach(0, [f"{axis}_s{i}" for axis in "xy" for i in (1, 2, 3, 4)] + ["tool"], 0)
    pins = Pins(plant)
    pins.step(10, 1, 1)
    assert plant.position == [99, 101]

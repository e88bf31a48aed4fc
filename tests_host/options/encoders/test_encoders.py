"""Encoders on a whole virtual router: each loss is found, its size is exact, and nothing else is taken for one."""

import random
import re

import gantry
import pytest

from host_tools import boards
from passo import errors
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.options.encoders.errors import ALARM_STEPS_MISSING, COUNTS_LOST, POSITION_VERIFIED, STEPS_MADE_UP

LIMIT = 8


def board(name="router_3axis", **changes):
    board = boards.load(name)
    pins = {"x": 18, "y": 20, "z": 22}
    board["encoders"] = [
        {"motor": motor, "pins": [pin, pin + 1], "pulses": 1000 if motor == "z" else 500, "steps": 400, "limit_steps": LIMIT, **changes}
        for motor, pin in pins.items()
    ]
    return board


class Router(gantry.Router):
    def __init__(self, unlock=True, seed=1, made=None, **changes):
        gantry.Router.__init__(self, made or board(**changes), unlock, seed=seed)


def test_what_is_lost_is_made_up_for_at_the_end_of_the_move():
    """At random places, by random amounts below the limit, of all kinds: afterwards it stands where it should."""
    chance = random.Random(5)
    router = Router(correct=True)
    made_up = dict.fromkeys("xyz", 0)
    for turn in range(12):
        motor, steps = chance.choice("xyz"), chance.randint(1, LIMIT - 1)
        direction = -1 if turn % 2 else 1
        fault, lost = chance.choice([
            (fault, lost) for fault, lost in (("stall", -direction * steps), ("slip", steps), ("back", -steps)) if abs(made_up[motor] + lost) <= LIMIT
        ])  # fmt: skip
        made_up[motor] += lost
        if fault == "stall":
            router.plant.stall_motor(motor, steps)
        else:
            router.plant.slip_motor(motor, steps if fault == "slip" else -steps)
        back = "-" if turn % 2 else ""
        router.go(f"G1X{back}5Y{back}4Z{back}3F2000")
        assert router.noted(STEPS_MADE_UP)[-1] == f"{motor} {lost:+d}", "its size, exactly"
        assert router.off() == [0, 0, 0] and router.controller.state == "idle"
    assert len(router.noted(STEPS_MADE_UP)) == 12
    assert router.controller.position() == [0, 0, 0]


@pytest.mark.parametrize("motor", "xyz")
@pytest.mark.parametrize("feed", (300, 3000))
def test_a_stalled_motor_is_an_alarm_that_tells_how_many_steps_and_where(motor, feed):
    router = Router()
    router.go("G1X1Y1Z1F1000")
    router.plant.stall_motor(motor, 10_000)
    said = router.go(f"G1{motor}20F{feed}")
    number, places = re.search(rf"ALARM:30\r\n\[MSG:Steps missing: {motor} (-\d+) at (.*)\]", said).groups()
    missing = -int(number)
    steps_mm = {"x": 320, "y": 320, "z": 400}[motor]
    a_check = 3 * feed * steps_mm // 60_000 + 2
    assert LIMIT < missing <= LIMIT + a_check
    assert places == " ".join(f"{axis}{at + (missing if axis == motor else 0)}" for axis, at in zip("xyz", router.controller.position()))
    assert router.noted(ALARM_STEPS_MISSING) == [f"{motor} {number} at {places}"]
    assert router.noted(POSITION_VERIFIED) == [f"{motor} {number}"], "known to the step once it stands"
    assert router.plant.carriages["xyz".index(motor)].lost == missing
    assert router.off() == [0, 0, 0] and not router.controller.machine.homed


def test_a_motor_that_is_turned_while_it_stands_is_an_alarm():
    router = Router()
    router.go("G1X1F1000")
    router.plant.slip_motor("y", LIMIT)
    router.machine.run_ms(50)
    assert router.controller.state == "idle"
    router.plant.slip_motor("y", 1)
    router.machine.run_ms(50)
    assert b"ALARM:30" in router.machine.take() and router.noted(ALARM_STEPS_MISSING)[0].startswith("y +9 at")


def test_counts_that_never_came_are_found_too():
    router = Router()
    router.plant.lose_counts("x", 5 * LIMIT + 5)
    assert "[MSG:Steps missing: x -9 at" in router.go("G1X1F1000")


def test_the_index_pulse_tells_an_encoder_that_loses_counts_from_a_motor_that_loses_steps():
    made = board(limit_steps=200)
    made["encoders"][0]["index"] = "repl"
    router = Router(made=made)
    router.go("G1X20F3000")
    router.go("G1X-40F3000")
    assert not router.noted(COUNTS_LOST)
    router.plant.slip_motor("x", 30)
    router.go("G1X20F3000")
    assert not router.noted(COUNTS_LOST), "the motor is somewhere else, and so is its encoder"
    router.plant.lose_counts("x", 150)
    router.go("G1X20F3000")
    assert router.noted(COUNTS_LOST) == ["x -150 counts"]


def test_made_up_in_vain_is_an_alarm():
    """A motor that cannot move: three tries, then the alarm; each ends."""
    router = Router(correct=True)
    router.go("G1X1F1000")
    router.plant.slip_motor("x", -5)
    router.plant.stall_motor("x", 1000)
    router.machine.run_ms(100)
    router.go("G1Y1F1000")
    router.machine.run_ms(5000)
    assert len(router.noted(STEPS_MADE_UP)) <= 3
    assert router.controller.machine.alarm == ALARM_STEPS_MISSING


@pytest.mark.parametrize("counts, home", [(5, "$H"), (-15, "$H"), (10, "$HX")])
def test_what_is_made_up_in_one_direction_counts_toward_the_limit(counts, home):
    """An encoder that loses counts, or counts noise, a few at each move: the axis drifts no further than the limit. Homing begins anew."""
    router = Router(unlock=False, correct=True)
    router.go("$H")
    for _ in range(2):
        router.go("G90")
        router.go("G1X20F3000")
        router.go("G91")
        before = router.plant.position[0] - router.controller.position()[0]
        for turn in range(2 * LIMIT):
            router.plant.lose_counts("x", counts)
            said = router.go(f"G1X{'-' if turn % 2 else ''}1F2000")
            if "ALARM:30" in said:
                break
            assert abs(router.plant.position[0] - before - router.controller.position()[0]) <= LIMIT
        figure = re.search(r"Steps missing: x ([-+]\d+), ([-+]\d+) made up since homing at x", said)
        assert figure and abs(int(figure[1]) + int(figure[2])) > LIMIT >= abs(int(figure[2]))
        router.plant.encoders["x"].lost = 0
        router.machine.send(b"\x18")
        router.machine.run_ms(200)
        router.go("$H")
        assert router.controller.machine.homed
        router.go(home)
        assert router.plant.position == [0, 0, 0]
    for turn in range(3 * LIMIT):
        router.plant.slip_motor("y", 2 if turn % 2 else -2)
        router.go("G1Y1F3000")
    assert router.controller.state == "idle", "slips in both directions must cancel"


def test_after_a_halt_at_speed_the_position_is_verified():
    router = Router(unlock=False)
    assert "ok" in router.go("$H")
    router.go("G90")
    router.go("G1X50F3000")
    router.ask("G1X10F4000")
    router.machine.run_ms(300)
    router.plant.slip_motor("x", 3)  # the rotor runs on
    router.machine.send(b"\x18")
    router.machine.run_ms(200)
    assert "ALARM:3" in router.machine.take().decode()
    assert router.noted(POSITION_VERIFIED) == ["x +3"]
    machine = router.controller.machine
    assert machine.homed and router.plant.position == router.controller.position()


def test_motors_without_current_may_be_turned_by_hand():
    router = Router()
    router.go("G1X1Y1F1000")
    router.ask("$SLP")
    router.machine.run_ms(200)
    router.plant.slip_motor("x", 1234)
    router.machine.run_ms(200)
    assert router.off() == [0, 0, 0] and not router.noted(ALARM_STEPS_MISSING)


def test_counts_are_shown_and_zeroed():
    router = Router()
    router.go("G1X2Y-1Z-1F1000")
    assert "[ENC:x,3200,0," in router.ask("$ENC") and "[ENC:z,-4000,0," in router.ask("$ENC")
    router.ask("$ENC=0")
    assert "[ENC:x,0,0,0]\r\n[ENC:y,0,0,0]\r\n[ENC:z,0,0,0]\r\nok" in router.ask("$ENC")
    router.go("G1X-2F1000")
    assert "[ENC:x,-3200,0," in router.ask("$ENC")
    shown = ""
    for _ in range(12):
        router.machine.send(b"?")
        router.machine.run_ms(5)
        shown += router.machine.take().decode()
    assert "|En:-3200,0,0" in shown


def run_about(steps, seed):
    """Random moves at up to the fastest, of `steps` in all: none is taken for an error."""
    chance = random.Random(seed)
    router = Router(limit_steps=2)
    router.ask("G90")
    at = [0, 0, 0]
    while steps > 0:
        to = [chance.randint(-60, 60), chance.randint(-50, 50), chance.randint(-20, 20)]
        steps -= sum(abs(a - b) * each for a, b, each in zip(to, at, (320, 320, 400)))
        at = to
        router.ask("G1X%dY%dZ%dF%d" % (*to, chance.choice((300, 2000, 5000))))
    router.go("G0X0Y0Z0")
    entries = [entry for entry in router.controller.machine.log.entries if entry[1] != errors.WORDS_LATE]
    assert not entries and router.off() == [0, 0, 0]


def test_nothing_is_taken_for_an_error():
    run_about(200_000, 1)


@pytest.mark.slow
@pytest.mark.unmeasured
def test_nothing_is_taken_for_an_error_in_ten_million_steps():
    run_about(10_000_000, 3)


@pytest.mark.parametrize(
    "change, said",
    [
        ({"motor": "a"}, "'a' has to be one of x, y, z"),
        ({"motor": "y"}, "'y' has to be one of x, y, z, each once"),
        ({"pins": [18, 24]}, "B on the pin next to A, [18, 19]"),
        ({"pins": [16, 17]}, "pin 16 is claimed by output flood"),
        ({"pulses": 0}, "pulses: 0"),
        ({"index": "nowhere"}, "there is no input 'nowhere'"),
    ],
)
def test_what_cannot_be_is_refused(change, said):
    wrong = board()
    wrong["encoders"][0].update(change)
    with pytest.raises(BoardError) as refused:
        check(wrong)
    assert said in str(refused.value)


def test_coils_have_no_encoders_here():
    wrong = boards.load("plotter_2014")
    wrong["encoders"] = [{"motor": "x", "pins": [20, 21], "pulses": 500, "steps": 400}]
    with pytest.raises(BoardError, match="step_dir"):
        check(wrong)

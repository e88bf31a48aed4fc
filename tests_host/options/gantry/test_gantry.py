"""A gantry with two motors and two encoders: abreast after every move, and never far apart in one."""

import random
import re

import pytest
from gantry import LIMIT, WAIT, Router, board

from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.options.gantry.errors import ALARM_GANTRY, SQUARED
from passo.steps.wiring import word_pins


class Watched(Router):
    """Keeps the largest lag of the plant, over every edge."""

    def __init__(self, **changes):
        super().__init__(board(**changes))
        self.most = 0
        edges = self.machine.port._player._edges

        def watch(tick, levels, changed):
            edges(tick, levels, changed)
            self.most = max(self.most, abs(self.plant.skew_steps()))

        self.machine.port._player._edges = watch


def test_two_motors_go_the_same_way_on_pins_of_their_own():
    router = Watched(encoders=())
    for line in ("G1X10F2000", "G1X-3Y2F300", "G0X5Z1", "G2X2Y2I1J1F500"):
        router.go(line)
    assert router.most == 0, "one word steps both"
    assert router.plant.skew_steps() == 0 and router.off() == [0, 0, 0] and not router.plant.errors
    assert word_pins(check(board())) == [2, 3, 4, 5, 6, 7, 8, 9, 10]


@pytest.mark.parametrize("motor", ("x", "x2"))
@pytest.mark.parametrize("lost", (1, WAIT - 1, WAIT, LIMIT - 2))
def test_what_one_side_loses_it_catches_up_with(motor, lost):
    router = Watched()
    router.go("G1X2F1000")
    router.plant.stall_motor(motor, lost)
    router.go("G1X10F1000")
    assert router.plant.skew_steps() == 0 and router.off() == [0, 0, 0] and not router.plant.errors
    assert router.noted(SQUARED) == [f"{motor} +{lost}"], "which side, and how far"
    assert router.controller.position()[0] == 12 * 320 and router.controller.state == "idle"


def test_from_wait_steps_on_the_move_itself_waits():
    """The rule of 2004. Less than that is seen to at the end of the move."""
    for lost, waits in ((WAIT - 1, False), (WAIT, True)):
        router = Watched()
        router.ask("G1X40F1000")
        router.machine.run_ms(500)
        router.plant.slip_motor("x2", -lost)
        router.machine.run_ms(800)
        assert router.controller.state == "run"
        assert (router.plant.skew_steps() == 0) == waits
        router.go("G1X-1F1000")
        assert router.plant.skew_steps() == 0 and router.off() == [0, 0, 0]
        assert router.controller.position()[0] == 39 * 320


def test_random_losses_on_both_sides():
    chance = random.Random(8)
    router = Watched(correct=True)
    taken = 0
    for turn in range(15):
        motor, steps, stalls = chance.choice(("x", "x2")), chance.randint(1, LIMIT - 8), chance.random() < 0.5
        lag = (1 if motor == "x2" else -1) * (steps if not stalls else steps if turn % 2 else -steps)
        if abs(taken + lag) > LIMIT:
            stalls, steps, lag = False, steps if stalls and lag * (1 if motor == "x2" else -1) < 0 else -steps, -lag
        taken += lag
        (router.plant.stall_motor if stalls else router.plant.slip_motor)(motor, steps)
        back = "-" if turn % 2 else ""
        router.go(f"G1X{back}8Y{back}2F{chance.choice((300, 2500))}")
        assert router.plant.skew_steps() == 0 and router.off() == [0, 0, 0] and router.controller.state == "idle"
    assert not router.plant.errors


@pytest.mark.parametrize("feed", (500, 4000))
@pytest.mark.parametrize("motor", ("x", "x2"))
def test_a_lag_beyond_the_limit_is_an_alarm_with_both_counts(motor, feed):
    """Never further apart than the limit and what is played until the next check."""
    router = Watched()
    router.go("G1X5F1000")
    router.plant.stall_motor(motor, 10_000)
    said = router.go(f"G1X30F{feed}")
    if feed < 1000:
        assert said.count("ALARM:31") == 1 or router.noted(SQUARED)
    x, x2, lag = map(int, re.search(r"ALARM:31\r\n\[MSG:Gantry: x (\d+) x2 (\d+) counts lag ([-+]\d+) steps\]", said).groups())
    encoders = router.plant.encoders
    assert (x, x2) == (encoders["x"].count, encoders["x2"].count) and lag == (x2 - x) // 5
    a_check = 3 * feed * 320 // 60_000 + 2
    assert router.most <= LIMIT + a_check, (router.most, a_check)
    assert router.controller.machine.alarm == ALARM_GANTRY


@pytest.mark.parametrize("motor, counts", [("x2", 5), ("x2", -10), ("x", 15), ("x", -5)])
def test_a_side_that_loses_counts_slowly_is_racked_to_the_limit_at_most(motor, counts):
    """Each lag is small and taken away; the corrections in one direction since homing add up."""
    router = Router(board(), unlock=False)
    router.go("$H")
    for _ in range(2):
        router.go("G90")
        router.go("G1X20F3000")
        router.go("G91")
        for turn in range(3 * LIMIT):
            router.plant.encoders[motor].lost += counts
            said = router.go(f"G1X{'-' if turn % 2 else ''}1F2000")
            assert abs(router.plant.skew_steps()) <= LIMIT
            if "ALARM:31" in said:
                break
        lag, taken = map(int, re.search(r"counts lag ([-+]\d+) steps, ([-+]\d+) taken away since homing", said).groups())
        assert abs(lag + taken) > LIMIT >= abs(taken)
        router.plant.encoders[motor].lost = 0
        router.machine.send(b"\x18")
        router.machine.run_ms(200)
        router.go("$H")
        assert router.controller.machine.homed and router.plant.skew_steps() == 0


def test_a_hold_of_the_operator_stays_one():
    router = Watched()
    router.ask("G1X40F1000")
    router.machine.run_ms(500)
    router.plant.slip_motor("x2", -WAIT)
    router.machine.send(b"!")
    router.machine.run_ms(3000)
    assert router.controller.state == "hold" and router.plant.skew_steps() == 0
    router.machine.send(b"~")
    router.go("G1X1F1000")
    assert router.controller.position()[0] == 41 * 320 and router.off() == [0, 0, 0]


@pytest.mark.parametrize(
    "change, said",
    [
        ({"axis": "a"}, "gantry.axis: there is no axis 'a'"),
        ({"pins": [6, 9]}, "pin 6 is claimed by"),
        ({"sensor": "limit_q"}, "gantry.sensor: there is no input 'limit_q'"),
        ({"offset_steps": 300}, "no more than rack_steps"),
    ],
)
def test_what_cannot_be_is_refused(change, said):
    with pytest.raises(BoardError) as refused:
        check(board(**change))
    assert said in str(refused.value)

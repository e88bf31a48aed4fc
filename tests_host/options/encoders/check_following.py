"""Following errors: the kernel against fractions, and the limits of its estimate."""

from array import array

from passo.records import COUNT_MASK
from passo.options.encoders.steps_viper import (
    FOLLOW_AXIS, FOLLOW_DEN, FOLLOW_ERROR, FOLLOW_FIELDS, FOLLOW_LIMIT, FOLLOW_MOST, FOLLOW_NEGATIVE, FOLLOW_NUM, FOLLOW_OFF,
    FOLLOW_SHIFT, FOLLOW_TOTAL, follow_steps,
)  # fmt: skip

RATIOS = ((5, 1), (10, 1), (5, 8), (3, 7), (2000, 1))  # counts a step: of 2004, microsteps, and others
CASES = {
    "check_the_error_is_what_is_missing": (
        ("ratio", 0, len(RATIOS) - 1), ("negative", 0, 1), ("start", 0, COUNT_MASK),
        ("moves", "list", 30, ("steps", -700, 700), ("lost", -9, 9)),
    ),
    "check_what_is_stepped_meanwhile_is_allowed_for": (("steps", -90, 90), ("part", 0, 100), ("lost", -30, 30)),
}  # fmt: skip


def table_of(ratio, negative=0, limit=8):
    table = array("i", [0] * FOLLOW_FIELDS)
    table[FOLLOW_AXIS] = 1
    table[FOLLOW_NUM], table[FOLLOW_DEN] = RATIOS[ratio]
    table[FOLLOW_NEGATIVE] = negative
    table[FOLLOW_LIMIT] = limit * RATIOS[ratio][0]
    return table


def check_the_error_is_what_is_missing(ratio, negative, start, moves):
    """For any motion of the motor and any start of the counter: a fraction of a count is no error."""
    num, den = RATIOS[ratio]
    table = table_of(ratio, negative)
    sign = -1 if negative else 1
    counts = array("i", [start])
    place = array("i", [0, 0])
    follow_steps(table, 1, counts, place, place)
    begun = table[FOLLOW_ERROR]
    table[FOLLOW_SHIFT] = -begun
    turned = stepped = most = 0
    for steps, lost in moves:
        stepped += steps
        turned += steps - lost
        counts[0] = (start + sign * (turned * num // den)) & COUNT_MASK
        place[1] = stepped
        beyond = follow_steps(table, 1, counts, place, place)
        missing = stepped - turned
        error = table[FOLLOW_ERROR]
        assert -missing * num - den < error <= -missing * num
        assert beyond == (1 if abs(error) > 8 * num else 0)
        most = max(most, abs(error))
    assert table[FOLLOW_MOST] >= most
    assert table[FOLLOW_TOTAL] - sign * (start if start < 1 << 28 else start - (1 << 29)) == turned * num // den


def check_what_is_stepped_meanwhile_is_allowed_for(steps, part, lost):
    """The counts are of some moment between two looks at the player: nothing within these is an error, all beyond is."""
    table = table_of(0)
    turned = steps * part // 100 + lost
    counts = array("i", [turned * 5 & COUNT_MASK])
    beyond = follow_steps(table, 1, counts, array("i", [0, 0]), array("i", [0, steps]))
    low, high = min(0, steps), max(0, steps)
    assert beyond == (1 if turned > high + 8 or turned < low - 8 else 0)


def check_a_motor_left_out_is_not_asked():
    """While the other motor of a gantry steps alone; and what the main loop accounts for is accounted for once."""
    table = table_of(0)
    table[FOLLOW_OFF] = 1
    counts = array("i", [0])
    assert follow_steps(table, 1, counts, array("i", [0, 40]), array("i", [0, 41])) == 0
    assert table[FOLLOW_ERROR] == 0
    table[FOLLOW_OFF] = 0
    assert follow_steps(table, 1, counts, array("i", [0, 60]), array("i", [0, 60])) == 1
    table[FOLLOW_SHIFT] = 100
    for _ in range(2):
        assert follow_steps(table, 1, counts, array("i", [0, 60]), array("i", [0, 60])) == 0
        assert table[FOLLOW_ERROR] == 0

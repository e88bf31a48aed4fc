"""Coil drives against the tables of the machines they come from; motors that share a port never disturb each other."""

import math
from array import array

from passo.options.coil_drives.drive import CoilDrive
from passo.options.drive_pbl3770a import drive as pbl3770a
from passo.options.drive_unipolar import drive as unipolar

TABLES = [(unipolar.MODES[mode], 4) for mode in ("wave", "full", "half")]
TABLES += [(pbl3770a.MODES[mode], 6) for mode in ("full", "half", "quarter", "eighth")]
CASES = {
    "check_two_motors": (
        ("which", 0, len(TABLES) - 1), ("reversed_mask", 0, 3), ("steps", "list", 60, ("step", 0, 3), ("dirs", 0, 3)),
    ),
}


def spell(levels):
    """A unipolar pattern as the documents print it, S1 first."""
    return "".join(["1" if levels >> bit & 1 else "0" for bit in range(4)])


def check_unipolar_tables():
    assert [spell(levels) for levels in unipolar.MODES["wave"]] == "1000 0100 0010 0001".split()
    assert [spell(levels) for levels in unipolar.MODES["full"]] == "1100 0110 0011 1001".split()
    assert [spell(levels) for levels in unipolar.MODES["half"]] == "1000 1100 0100 0110 0010 0011 0001 1001".split()


def windings(levels):
    """(signed percent of winding A, of B) as the chips' datasheet has it: I0, I1 = LL 100, HL 60, LH 20, HH 0."""
    result = []
    for chip in (levels & 7, levels >> 3):
        percent = {0b00: 100, 0b01: 60, 0b10: 20, 0b11: 0}[chip >> 1]
        result.append(percent if chip & 1 else -percent)
    return tuple(result)


def signs(levels):
    return tuple([(percent > 0) - (percent < 0) for percent in windings(levels)])


def check_pbl3770a_half_step():
    coil_1 = (1, 1, 0, -1, -1, -1, 0, 1)
    coil_2 = (0, 1, 1, 1, 0, -1, -1, -1)
    assert [signs(levels) for levels in pbl3770a.MODES["half"]] == list(zip(coil_1, coil_2))
    for levels in pbl3770a.MODES["half"]:
        currents = sorted([abs(percent) for percent in windings(levels)])
        assert currents in ([60, 60], [0, 100])


def check_pbl3770a_full_step():
    """Both chips at 60 %, one PH toggled a step, alternately."""
    toggled = []
    for phase in range(4):
        levels = pbl3770a.MODES["full"][phase]
        assert [abs(percent) for percent in windings(levels)] == [60, 60]
        toggled.append(levels ^ pbl3770a.MODES["full"][(phase + 1) % 4])
    assert toggled in ([0b000001, 0b001000] * 2, [0b001000, 0b000001] * 2)


def check_pbl3770a_hold_current():
    for mode in ("half", "full"):
        for levels, hold in zip(pbl3770a.MODES[mode], pbl3770a.HOLD[mode]):
            assert signs(levels) == signs(hold)
            assert set([abs(percent) for percent in windings(hold)]) <= set([0, 20])
    assert windings(pbl3770a.OFF) == (0, 0)


def check_pbl3770a_microsteps():
    """Each microstep turns the sum of the currents on: by 11.25 or 22.5 degrees, up to 4.1 more or less; standing windings have no
    more current, and hold the same direction."""
    for mode, steps in (("quarter", 16), ("eighth", 32)):
        table, hold = pbl3770a.MODES[mode], pbl3770a.HOLD[mode]
        assert len(table) == len(hold) == len(set(table)) == steps
        for phase in range(steps):
            a, b = windings(table[phase])
            off = math.degrees(math.atan2(b, a)) - phase * 360 / steps
            assert abs((off + 180) % 360 - 180) < 4.2, (mode, phase)
            assert 63 <= math.sqrt(a * a + b * b) <= 117
            resting_a, resting_b = windings(hold[phase])
            assert abs(resting_a) <= abs(a) and abs(resting_b) <= abs(b)
            assert abs(math.atan2(resting_b, resting_a) - math.atan2(b, a)) < 1e-6
    assert [pbl3770a.MODES["eighth"][4 * phase] for phase in range(8)] == list(pbl3770a.MODES["half"])


def check_a_step_and_a_reversal_change_one_phase_only():
    """From any phase, one step on or back changes one coil (wave drive: hands over between neighbours)."""
    for table in (unipolar.MODES["full"], unipolar.MODES["half"]):
        for phase in range(len(table)):
            for delta in (1, -1):
                changed = table[phase] ^ table[(phase + delta) % len(table)]
                coils = [changed >> bit & 1 for bit in range(4)]
                if table is unipolar.MODES["half"]:
                    assert sum(coils) == 1
                else:
                    assert (coils[0] & coils[2]) + (coils[1] & coils[3]) == 1 and sum(coils) == 2
    for table in (pbl3770a.MODES["full"], pbl3770a.MODES["half"]):
        for phase in range(len(table)):
            for delta in (1, -1):
                before = signs(table[phase])
                after = signs(table[(phase + delta) % len(table)])
                assert (before[0] != after[0]) + (before[1] != after[1]) == 1


def check_two_motors(which, reversed_mask, steps):
    """Any walk: each motor's pattern is its own place in the table, whatever the other does; tool and time stay."""
    table, width = TABLES[which]
    drive = CoilDrive(2, table, width, reversed_mask=reversed_mask)
    bits = 2 * width + 1
    tool = 1 << 2 * width
    places = [0, 0]
    before = drive.levels()
    for step, dirs in steps:
        words = array("I", [77 << bits | tool | dirs << 2 | step])
        drive.apply(words, 0, 1)
        assert words[0] >> bits == 77 and words[0] & tool
        for axis in range(2):
            moved = (1 if dirs >> axis & 1 else -1) if step >> axis & 1 else 0
            assert drive.step_between(axis, before, words[0]) == moved
            places[axis] += moved
            sign = -1 if reversed_mask >> axis & 1 else 1
            assert words[0] >> axis * width & (1 << width) - 1 == table[sign * places[axis] % len(table)]
        before = words[0]
        assert drive.levels() == before & (tool - 1)
    again = CoilDrive(2, table, width, reversed_mask=reversed_mask)
    again.seek(places)
    assert again.levels() == drive.levels()

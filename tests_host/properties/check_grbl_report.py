"""Figures of a status report, written into one buffer by machine code, are those of the plain rules, to the last digit."""

from array import array

from draws import Random
from passo.protocols.grbl import report as grbl_report
from passo.protocols.gcode.words import rounded
from passo.protocols.grbl.text_viper import FARTHEST_MM, INCHES, MILLIMETRES, places, tell
from passo.records import REPORT_AXIS, REPORT_FIELDS, REPORT_UNIT

CASES = {"check_places": (("seed", "seed"),), "check_numbers": (("seed", "seed"),)}
RUNS = {"check_places": 300, "check_numbers": 100}
NM_PER_M = 1_000_000_000
MOST = (1 << 28) - 1  # steps


def told(label, figures, count):
    out = bytearray(120)
    end = tell(out, 3, label + b",".join([bytes((number + 1,)) for number in range(count)]) + b"\0", figures)
    assert out[:3] == bytes(3) and not any(out[end:])
    return bytes(out[3:end]).decode()


def draw_axis(random):
    """(steps, steps a metre, offset in nm), often where it is rounded or its sign changes; within 100 km."""
    per_m = random.choice((320_000, 400_000, 83_333, 48_000, 3, 1000, 100_000_000, random.between(1, 2_000_000)))
    most = min(MOST, 90_000 * per_m)
    steps = random.choice((0, 1, -1, most, -most, random.between(-most, most), random.between(-999, 999)))
    nm = rounded(steps * NM_PER_M, per_m)
    near = nm + random.choice((0, 500, -500, 499, 1270, -1270, 1269, 999_999, random.between(-3000, 3000)))
    offset = random.choice((0, 0, near, random.between(-9_000_000_000_000, 9_000_000_000_000), random.between(-9999, 9999)))
    return steps, per_m, offset


def check_places(seed):
    random = Random(seed)
    axes = random.between(1, 3)
    inches = random.between(0, 1)
    figures = array("i", [0] * (REPORT_AXIS + REPORT_FIELDS * axes))
    figures[REPORT_UNIT:REPORT_AXIS] = INCHES if inches else MILLIMETRES
    wanted, places_in_steps = [], array("i", [0] * axes)
    for axis in range(axes):
        steps, per_m, offset = draw_axis(random)
        wanted.append(rounded(steps * NM_PER_M, per_m) - offset)
        places_in_steps[axis] = steps
        place = REPORT_AXIS + REPORT_FIELDS * axis
        figures[place : place + 3] = array("i", (per_m, offset // 1_000_000 + FARTHEST_MM, offset % 1_000_000))
    places(figures, places_in_steps, axes)
    assert told(b"|WPos:", figures, axes) == "|WPos:" + grbl_report.place(wanted, inches)


def check_numbers(seed):
    random = Random(seed)
    numbers = [random.choice((0, 9, 10, 99, 100, 999_999_999, 0x3FFFFFFF, random.between(0, 9999))) for _ in range(3)]
    figures = array("i", [0] * REPORT_AXIS)
    for place in range(3):
        figures[3 * place] = numbers[place]
    count = random.between(0, 3)
    assert told(b"|Ov:", figures, count) == "|Ov:" + ",".join([str(number) for number in numbers[:count]])


def check_speeds():
    """In parts as with large integers: mm/min, and tenths of an inch a minute."""
    for nm_s in (0, 1, 8333, 8334, 541_266_000, 715_827_882, 1 << 30, 16_666_666_650, 25_400_000, 423_333, 42_333, 21_167):
        assert grbl_report.rate(nm_s, 0) == str(rounded(nm_s * 60, 1_000_000))
        assert grbl_report.rate(nm_s, 1) == grbl_report.decimal(rounded(nm_s * 60, 2_540_000), 1)

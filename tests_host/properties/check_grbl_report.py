"""Figures of a status report, written into one buffer by machine code, are those of the plain rules, to the last digit."""

from array import array

from draws import Random
from passo.protocols.grbl import report as grbl_report
from passo.protocols.gcode.words import round_half_away
from passo.protocols.grbl.text_viper import FARTHEST_MM, INCHES, MILLIMETRES, set_lengths, write_form, write_report, set_speed
from passo.protocols.grbl.report_records import (
    REPORT_AXIS, REPORT_FIELDS, REPORT_LINE, REPORT_LONGEST, REPORT_ROOM, REPORT_SPEED, REPORT_UNIT,
)  # fmt: skip
from passo.records import (
    SEEN_FIELDS, SEEN_LINE, SEEN_MM_S, SEEN_NM_S, SEEN_ROOM, SETTING_INCHES, SETTING_MAX_RPM, SETTING_REPORT,
)  # fmt: skip

CASES = {name: (("seed", "seed"),) for name in ("check_places", "check_numbers", "check_speed")}
RUNS = {"check_places": 300, "check_numbers": 100, "check_speed": 300}
NM_PER_M = 1_000_000_000
MOST = (1 << 28) - 1  # steps


def told(label, figures, count):
    out = bytearray(REPORT_LONGEST)
    end = write_form(out, 3, label + b",".join([bytes((number + 1,)) for number in range(count)]) + b"\0", figures)
    assert out[:3] == bytes(3) and not any(out[end:])
    return bytes(out[3:end]).decode()


def draw_axis(random):
    """(steps, steps a metre, offset in nm), often where it is rounded or its sign changes; within 100 km."""
    per_m = random.choice((320_000, 400_000, 83_333, 48_000, 3, 1000, 100_000_000, random.between(1, 2_000_000)))
    most = min(MOST, 90_000 * per_m)
    steps = random.choice((0, 1, -1, most, -most, random.between(-most, most), random.between(-999, 999)))
    nm = round_half_away(steps * NM_PER_M, per_m)
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
        wanted.append(round_half_away(steps * NM_PER_M, per_m) - offset)
        places_in_steps[axis] = steps
        place = REPORT_AXIS + REPORT_FIELDS * axis
        figures[place : place + 3] = array("i", (per_m, offset // 1_000_000 + FARTHEST_MM, offset % 1_000_000))
    set_lengths(figures, places_in_steps, axes)
    assert told(b"|WPos:", figures, axes) == "|WPos:" + grbl_report.position_text(wanted, inches)


def check_numbers(seed):
    random = Random(seed)
    numbers = [random.choice((0, 9, 10, 99, 100, 999_999_999, 0x3FFFFFFF, random.between(0, 9999))) for _ in range(3)]
    figures = array("i", [0] * REPORT_AXIS)
    for place in range(3):
        figures[3 * place] = numbers[place]
    count = random.between(0, 3)
    assert told(b"|Ov:", figures, count) == "|Ov:" + ",".join([str(number) for number in numbers[:count]])


def check_speed(seed):
    """Rounded, too: whole mm/min, or tenths of an inch a minute."""
    random = Random(seed)
    inches = random.between(0, 1)
    unit = 127_000 if inches else 50_000  # of three times nm/s
    near = random.between(0, random.choice((20, 20_000, 500_000))) * unit + unit // 2
    nm_s = min(27_000_999_999, random.choice((0, 27_000_999_999, (near + random.between(-3, 3)) // 3, random.between(0, 27_000_999_999))))
    fields = array("i", [0] * REPORT_AXIS)
    fields[REPORT_UNIT:REPORT_AXIS] = INCHES if inches else MILLIMETRES
    fields[REPORT_SPEED + 2] = inches  # decimals
    set_speed(fields, nm_s // 1_000_000, nm_s % 1_000_000)
    out = bytearray(REPORT_LONGEST)
    form = bytes((REPORT_SPEED // 3 + 1, 0))
    assert bytes(out[: write_form(out, 0, form, fields)]).decode() == grbl_report.rate_text(nm_s, inches), nm_s


def check_report():
    """Each number where its form wants it."""
    fields = array("i", [0] * (REPORT_AXIS + 2 * REPORT_FIELDS))
    fields[REPORT_UNIT:REPORT_AXIS] = MILLIMETRES
    fields[REPORT_ROOM] = 77
    for axis in range(2):
        place = REPORT_AXIS + REPORT_FIELDS * axis
        fields[place : place + 3] = array("i", (1000, FARTHEST_MM, 0))
    seen = array("i", [0] * SEEN_FIELDS)
    seen[SEEN_ROOM], seen[SEEN_LINE], seen[SEEN_MM_S], seen[SEEN_NM_S] = 31, 12, 16, 666_667
    form = b"<\1;\2|" + bytes([number // 3 + 1 for number in (12, REPORT_ROOM, REPORT_LINE, REPORT_SPEED)]) + b">\0"
    out = bytearray(REPORT_LONGEST)
    end = write_report(out, form, fields, seen, array("i", (-7, 9)), 2)
    assert bytes(out[:end]) == b"<-7.000;9.000|3177121000>", bytes(out[:end])


def check_speeds():
    """As with large integers: mm/min, and tenths of an inch a minute."""
    for nm_s in (0, 1, 8333, 8334, 541_266_000, 715_827_882, 1 << 30, 16_666_666_650, 25_400_000, 423_333, 42_333, 21_167):
        assert grbl_report.rate_text(nm_s, 0) == str(round_half_away(nm_s * 60, 1_000_000))
        assert grbl_report.rate_text(nm_s, 1) == grbl_report.decimal_text(round_half_away(nm_s * 60, 2_540_000), 1)


class _Longest:
    """Gcode, its offsets, settings and machine in one, every value the longest there is."""

    axes = 4
    turns = False
    mask = 3
    inches = 0
    system = 0
    version = 0
    steps_per_m = (3, 3, 3, 3)

    def __init__(self):
        self.offsets = self

    def offset_of(self, system, axis):
        return -99_999_999_999_999

    def value(self, key):
        return {SETTING_REPORT: self.mask, SETTING_INCHES: self.inches, SETTING_MAX_RPM: 1_000_000_000}[key]


def say(status, report):
    """The longest of the reports that tell the overrides, and of those that tell the offsets."""
    found = {}
    for _ in range(40):
        text = bytes(status.report_bytes(report, 999_999_999)).decode()
        assert text[0] == "<" and text[-3:] == ">\r\n" and text.count("|") >= 2
        kind = "Ov" if "|Ov:" in text else "WCO" if "|WCO:" in text else ""
        found[kind] = max(found.get(kind, ""), text)
    return found


def longest_report():
    counts = ",".join(["-999999999"] * 4)
    seen = array("i", [0] * SEEN_FIELDS)
    seen[SEEN_ROOM] = seen[SEEN_LINE] = 999_999_999
    seen[SEEN_MM_S] = 27_000
    return {
        "position": array("i", [-MOST] * 4), "seen": seen,
        "power": 1_000_000, "state": "door", "substate": 3, "pins": "XYZAPDHRSNxyzan", "overrides": (200, 100, 200), "spindle": 4,
        "coolant": 3, "job": "100," + "n" * 32, "counts": counts, "rpm": 999_999_999, "glitches": 999_999_999,
    }  # fmt: skip


def check_every_field_at_its_longest():
    one = _Longest()
    found = say(grbl_report.Status(one, one, one), longest_report())
    wanted = "|Ov:200,100,200|A:CFM|SD:100,", "|En:-999999999,", "|RPM:999999999|Gl:999999999>"
    for field in wanted + ("|Pn:XYZAPDHRSNxyzan|", "|Ln:999999999|"):
        assert field in found["Ov"], (field, found["Ov"])
    assert "|WCO:-100000000.000," in found["WCO"], found["WCO"]
    assert len(found["Ov"]) + len("|T:999999999") <= REPORT_LONGEST, len(found["Ov"])


def check_every_mask_and_state_at_its_longest():
    """In each the fields behind the place are whole, and nothing is left out."""
    for state in grbl_report._STATES:
        for mask in range(4):
            for inches in (0, 1):
                one = _Longest()
                one.mask, one.inches = mask, inches
                report = longest_report()
                report["state"] = state
                report["slows"] = True
                for text in say(grbl_report.Status(one, one, one), report).values():
                    fields = dict([field.split(":") for field in text[1:-3].split("|")[1:]])
                    assert ("MPos" in fields, "WPos" in fields, "Bf" in fields) == (bool(mask & 1), not mask & 1, bool(mask & 2)), text
                    assert len(text) <= REPORT_LONGEST and fields["Ln"] == "999999999" and len(fields["FS"].split(",")) == 2
                    assert "WCO" in fields or "Ov" not in fields or fields["Gl"] == "999999999", text


def check_a_field_too_long_is_left_out():
    """And those behind it stand, as does the end."""
    one = _Longest()
    report = longest_report()
    for length in range(0, 2 * REPORT_LONGEST, 7):
        report["job"] = "100," + "n" * length
        text = say(grbl_report.Status(one, one, one), report)["Ov"]
        assert len(text) <= REPORT_LONGEST + 3
    assert "|SD:" not in text and "|En:" in text and "|Gl:999999999>" in text

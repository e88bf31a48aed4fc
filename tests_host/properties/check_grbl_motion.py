"""Motion asked for over the grbl link: holds, arcs, jogs, pauses, check mode, resets."""

from boards.router_3axis import BOARD
from passo import errors
from passo.records import ARCS
from router import BANNER, UNHOMED, Machine, answers, home

CASES = {}
RUNS = {}
NOT_QUICK = ("check_more_arcs_than_are_queued_at_once",)


def check_hold_and_resume():
    machine = Machine().ready()
    machine.world.path = []
    machine.do("G1 X4 Y2 F900")
    machine.cycles(12)
    machine.put(b"!")
    machine.cycles(1)
    assert machine.status()["state"] in ("Hold:1", "Hold:0")
    machine.cycles(60)
    assert machine.status()["state"] == "Hold:0"
    place = machine.controller.position()
    assert 0 < place[0] < 1280
    machine.cycles(50)
    assert machine.controller.position() == place
    assert machine.ask("G1 X0") == ["ok"]
    machine.put(b"~")
    machine.settle()
    assert machine.status()["state"] == "Idle" and machine.controller.position() == [0, 640, 0]
    path = machine.world.path
    other = Machine().ready()
    other.world.path = []
    other.do("G1 X4 Y2 F900", "G1 X0")
    other.settle()
    assert len(path) == len(other.world.path) == 2560
    for one, two in zip(path, other.world.path):
        assert one[1:4] == two[1:4]


def check_hold_at_rest():
    machine = Machine().ready()
    machine.put(b"!")
    machine.cycles(3)
    assert machine.status()["state"] == "Hold:0"
    assert machine.ask("G0 X1") == ["ok"]
    machine.cycles(30)
    assert machine.controller.position() == [0, 0, 0]
    machine.put(b"~")
    machine.settle()
    assert machine.controller.position() == [320, 0, 0]


def check_arcs_are_walked():
    """Circles in every plane, clockwise and not, more than a turn and as a helix: on their circle and to their end."""
    for line, plane, centre, radius, end in (
        ("G2 X0 Y0 I.5 F900", (0, 1), (160, 0), 160, (0, 0, 0)),
        ("G3 X.5 Y.5 J.5 F900", (0, 1), (0, 160), 160, (160, 160, 0)),
        ("G3 X0 Y0 J.5 Z1 P3 F900", (0, 1), (0, 160), 160, (0, 0, 400)),
        ("G2 X3 Y1 R-2 F3000", (0, 1), None, 640, (960, 320, 0)),
    ):
        machine = Machine().ready()
        machine.world.path = []
        machine.do(line)
        machine.settle()
        assert tuple(machine.controller.position()) == end
        if centre is None:
            continue
        for _, x, y, z, _ in machine.world.path:
            place = (x - 3000, y - 2500, z + 1800)
            across, along = place[plane[0]] - centre[0], place[plane[1]] - centre[1]
            assert (radius - 1) ** 2 <= across * across + along * along <= (radius + 1) ** 2, (line, place)


def check_tiny_arcs_are_no_circles():
    """An arc shorter than a step moves 0 steps or 1; its third axis moves all the same."""
    for line, end, words in (
        ("G3X9.9999Y0.001I-10J0F1000", (3200, 0, 0), 0),
        ("G3X9.9999Y0.001R10F1000", (3200, 0, 0), 0),
        ("G2X9.9999Y-0.001Z-1I-10J0F1000", (3200, 0, -400), 400),
        ("G3X9.9999Y0.001Z1R10F1000", (3200, 0, 400), 400),
        ("G18G3X9.999Z0.0001R5F1000", (3200, 0, 0), 0),
        ("G18G2X9.9999Z0.001I-10K0Y0.5F1000", (3200, 160, 0), 160),
        ("G3X10.0031Y0I0.0015J0F1000", (3201, 0, 0), 1),
        ("G93G3X9.9999Y0.001Z1I-10J0F60", (3200, 0, 400), 400),
    ):
        machine = Machine().ready()
        machine.do("G21G90G17", "G0X10Y0")
        machine.settle()
        machine.world.path = []
        machine.do(line, "G94G1F600")
        machine.settle()
        assert tuple(machine.controller.position()) == end and len(machine.world.path) == words, line


def check_arcs_are_as_fast_as_their_directions_allow():
    """About 45° both axes share the speed and the ramp; an arc along an axis, and a whole circle, are as slow as that axis."""
    for line, seconds in (
        ("G2X5.6Y5.6R60F6000", 0.2148),  # the true limit at each place: 0.214
        ("G2X40Y40R200F9000", 0.6523),
        ("G2X8Y0R60F6000", 0.2506),
        ("G2X0Y0I30F9000", 2.0832),
    ):
        machine = Machine().ready()
        machine.do("$110=6000", "$111=6000", "$120=500", "$121=500", "G21G90G17")
        machine.world.path = []
        machine.do(line)
        machine.settle()
        took = (machine.world.path[-1][0] - machine.world.path[0][0]) / 12_500_000
        assert abs(took - seconds) < 0.0005, (line, took)


def check_more_arcs_than_are_queued_at_once():
    machine = Machine().ready()
    planner = machine.app.planner
    machine.do("G91F900")
    full = 0
    for number in range(3 * ARCS):
        machine.do("G3X-.5Y-.5I-.5" if number & 1 else "G3X.5Y.5J.5")
        assert planner.indices[0] - planner.indices[3] <= ARCS, list(planner.indices)
        full += not planner.room()
    assert full > ARCS, full
    machine.settle()
    assert tuple(machine.controller.position()) == (0, 0, 0)


def check_arcs_far_too_slow_are_refused():
    """Also where the arc goes as chords, and at the speed at which only their diagonal steps would be too far apart."""
    for feed, said in ((".004", "error:34"), (".0055", "error:34"), (".02", "ok")):
        machine = Machine().ready()
        assert machine.ask("G18 G2 X3 Z-3 R3 F" + feed) == [said], feed
        machine.cycles(20)
    machine = Machine().ready()
    machine.do("$112=0.001")
    assert machine.ask("G18 G2 X3 Z-3 R3 F600") == ["error:34"]


def check_arcs_stay_inside():
    machine = home(Machine())
    machine.do("G0 X10 Y10")
    machine.settle()
    assert "ALARM:2" in machine.ask("G3 X10 Y10 J-10.1 F1000")
    machine.put(b"\x18")
    machine.cycles(3)
    machine.do("$X", "G3 X10 Y10 J-5 F3000", "G2 X10 Y20 R10 F3000")
    machine.settle()
    assert machine.controller.position() == [3200, 6400, 0]
    machine.do("G3 X10 Y20.0001 I-30", "G2 X10 Y20 I-30", "G2 X10 Y19.999 I-30 P1")  # whose circles would not
    assert "ALARM:2" in machine.ask("G2 X10 Y20 I-30")
    machine.put(b"\x18")
    machine.cycles(3)
    machine.do("$X")
    assert "ALARM:2" in machine.ask("G3 X10 Y19.998 I-30 F1000")


def check_a_line_of_several_motions_is_refused_whole():
    """Canned cycles, and G28 by way of a place: no part of them moves if another cannot."""
    machine = home(Machine())
    for setting, line, said in (
        ("$11=.01", "G81 X9 Y9 Z-81 R-2 F300", "error:15"), ("$11=.01", "G81 X1 Y2 Z-23 R-2 F.003", "error:33"),
        ("$111=.001", "G81 X1 Y2 Z-23 R-2 F300", "error:33"),  # an axis that is too slow for it
    ):  # fmt: skip
        machine.do("G0 X1", "G4 P0", setting)
        machine.put("G0 X2\n")
        assert said in machine.ask(line) + machine.cycles(3), line
        machine.settle()
        assert machine.controller.position()[1:] == [0, 0], line
        machine.put(b"\x18")
        machine.cycles(3)
        machine.do("$X")


def check_reset():
    machine = Machine().ready()
    machine.do("G1 X20 F3000", "G55")
    machine.cycles(20)
    machine.put(b"G0 X1\nG0\x18")
    assert machine.cycles(5) == ["ALARM:3", BANNER, UNHOMED]
    place = machine.controller.position()
    assert machine.cycles(50) == [] and machine.controller.position() == place and not machine.controller.machine.homed
    assert machine.world.place[0] - 3000 == place[0]
    machine.do("$X")
    assert machine.ask("$G")[0].startswith("[GC:G0 G54")
    machine.do("G91 G0 X1")
    machine.settle()
    assert machine.controller.position()[0] == place[0] + 320
    machine.do("G1 X20 F3000")
    machine.cycles(10)
    machine.put(b"!")
    machine.cycles(60)
    machine.put(b"\x18")
    assert machine.cycles(5) == [BANNER]
    assert machine.status()["state"] == "Idle"


def check_jogs():
    machine = Machine().ready()
    machine.put(b"$J=X10F6000\n$J=G91X5F6000\n$J=G53X0Y0F600\n")
    assert machine.cycles(2) == ["ok"] * 3
    assert machine.status()["state"] == "Jog"
    assert machine.ask("G0 X0") == ["error:9"]
    machine.put(b"\x85")
    machine.cycles(60)
    assert machine.status()["state"] == "Idle"
    place = machine.controller.position()
    assert 0 < place[0] < 4800 and machine.world.place[0] - 3000 == place[0]
    assert machine.ask("$J=G91X1F600") == ["ok"]
    machine.settle()
    assert machine.controller.position()[0] == place[0] + 320
    machine.do("$J=G20 X1 F30")
    machine.cycles(5)
    machine.put(b"!")
    machine.cycles(60)
    assert machine.status()["state"] == "Idle"
    machine.put(b"G1 X20 F600\n$J=X1F100\n")
    assert machine.cycles(4) == ["ok", "error:8"]
    assert machine.ask("$G")[0].startswith("[GC:G1 G54 G17 G21 G90")


def check_operator_pauses():
    machine = Machine().ready()
    pause = "[MSG:Pause: ~ to continue]"
    for line, told in (("M0", pause), ("M1", pause), ("M6 T2", "[MSG:Tool change: T2, ~ to continue]"), ("M6", None)):
        machine.put("G0 X1\n%s\nG0 X0\n" % line)
        said = machine.cycles(60)
        assert said == ["ok", told or "[MSG:Tool change: T2, ~ to continue]"], said
        assert machine.status()["state"] == "Hold:0" and machine.controller.position() == [320, 0, 0]
        machine.put(b"~")
        assert machine.cycles(60) == ["ok", "ok"]
        assert machine.controller.position() == [0, 0, 0]


def check_actual_speed():
    """FS reports the speed that is, not the one that was programmed."""
    machine = Machine().ready()
    machine.do("G1 X20 F3000")
    shown = []
    while machine.controller.state == "run":
        shown.append(int(machine.status()["FS"].split(",")[0]))
    assert shown[-1] < 300 and max(shown) == 3000
    peak = shown.index(3000)
    assert 0 < peak and shown[1 : peak + 1] == sorted(shown[1 : peak + 1]) and len([s for s in shown if s < 2900]) > 10
    assert machine.status()["FS"] == "0,0"
    machine.do("G0 X100")
    machine.cycles(30)
    machine.put(b"\x96")
    machine.cycles(60)
    assert 2400 <= int(machine.status()["FS"].split(",")[0]) <= 2500


def check_dwell_waits():
    machine = Machine().ready()
    machine.do("G1 X1 F600")
    begun = machine.port.now
    machine.do("G4 P0.5")
    assert 0.6 <= (machine.port.now - begun) / 12_500_000 <= 0.7


def check_check_mode():
    machine = home(Machine())
    steps = machine.world.steps
    assert machine.ask("$C") == ["[MSG:Enabled]", "ok"]
    assert machine.status()["state"] == "Check"
    for line in ("G1 X10 F100", "M3 S100", "G4 P10", "M8", "G38.2 Z-5", "M0"):
        assert answers(machine.ask(line)) == ["ok"], line
    assert machine.ask("G1 E1") == ["error:20"]
    assert machine.ask("$C")[:3] == ["[MSG:Disabled]", "ok", BANNER]
    machine.cycles(3)
    assert machine.world.steps == steps and machine.world.tool == 0
    machine.do("G91 G0 X1")
    machine.settle()
    assert machine.controller.position() == [320, 0, 0]
    machine.do("G90 G1 X20 F600")
    assert machine.ask("$C") == ["error:8"]


def check_sleep():
    machine = Machine().ready()
    machine.do("M3 S100")
    assert machine.ask("$SLP") == ["[MSG:Sleeping]", "ok"]
    assert machine.status()["state"] == "Sleep" and machine.ask("G0 X1") == ["error:9"]
    assert machine.world.tool == 0 and machine.world.outputs["enable"] == 1
    machine.put(b"~!")
    machine.cycles(3)
    assert machine.status()["state"] == "Sleep"
    machine.put(b"\x18")
    assert machine.cycles(3) == [BANNER, UNHOMED]


def check_feeds_of_every_size():
    """However large a feed is, it is taken or refused, and the move ends where it should."""
    machine = Machine().ready()
    place = 0
    feeds = {base**power + more for base, most in ((2, 31), (10, 9)) for power in range(7, most) for more in (-1, 0, 1)}
    for feed in sorted(feeds | {128_849, 128_850, 200_000}):
        if feed < 100:
            continue
        place = 1 - place
        for line in ("G1 X%d F%d" % (place, feed), "G1X%dF%d" % (1 - place, feed)):
            said = machine.ask(line)
            assert said in (["ok"], ["error:2"]), (line, said)
        machine.settle()
        assert machine.status()["state"] == "Idle", feed
        if said == ["ok"]:
            assert machine.controller.position()[0] == 320 * (1 - place), feed


def check_a_machine_faster_than_a_metre_a_second():
    """Feeds of every size end, in lines alone and in batches."""
    for feed in (24_000, 32_213, 40_000, 63_999, 64_000, 64_001, 200_000, 9_000_000):
        machine = Machine(axes=[dict(axis, max_mm_min=60_000, accel_mm_s2=5_000) for axis in BOARD["axes"]])
        for line in ("$X", "G21G91", "G1F%d" % feed):
            assert machine.ask(line)[-1] == "ok", line
        machine.do("X1", "X1Y1", "G1X1F%d" % feed, "X-1", "Y1", "G0X2", "G1Y1")
        machine.settle()
        assert list(machine.controller.position())[:2] == [4 * 320, 3 * 320]


def check_a_line_that_is_too_long():
    """Wherever it is found out, beyond the travel is error 15: by the travel, by the block's longest, by the parser's."""
    machine = Machine().ready()
    for line in ("G0X9000", "G1X9000F600", "G0X99999999", "G2X9000I4500F600", "$J=X9000F600", "$J=X99999999F600", "$J=G91X9000F600"):
        assert machine.ask(line)[-1] == "error:15", line
    assert machine.ask("G1X5F.0001")[-1] == "error:33"
    assert machine.controller.position() == [0, 0, 0]

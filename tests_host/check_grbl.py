"""The grbl link on the whole firmware: every `$`, every real-time byte, every alarm, both flow controls, and noise."""

import gc

from boards.router_3axis import BOARD
from passo.control.journal import MemorySlots
from passo.motion.planner import ARCS
from passo.protocols import errors
from passo.protocols.grbl import plain_text, real_time
from passo.protocols.grbl_report import decimal
from check_gcode import ALPHABET, GOOD
from draws import Random
from router import PULL_OFF, Machine, World, answers

CASES = {
    "check_noise_is_answered_line_by_line": (("seed", "seed"),),
    "check_mutated_programmes": (("seed", "seed"),),
    "check_decimals": (("value", -(1 << 40), 1 << 40), ("places", 0, 4)),
}
RUNS = {"check_noise_is_answered_line_by_line": 40, "check_mutated_programmes": 25}
UNHOMED = "[MSG:'$H'|'$X' to unlock]"
BANNER = "Grbl 1.1h ['$' for help]"


def check_greeting_and_lock():
    machine = Machine()
    assert machine.line.outgoing == b"\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n"
    machine.said()
    assert machine.status()["state"] == "Alarm"
    assert machine.ask("G0 X1") == ["error:9"]
    assert machine.ask("$J=X1F100") == ["error:8"]
    assert machine.ask("") == ["ok"] and machine.ask("(comment)") == ["ok"] and machine.ask("%") == ["ok"]
    assert machine.ask("$X") == ["[MSG:Caution: Unlocked]", "ok"]
    assert machine.ask("$X") == ["ok"]
    assert machine.status()["state"] == "Idle"
    assert machine.world.steps == 0


def check_both_ends_of_lines():
    machine = Machine().ready()
    machine.put(b"G4P0\nG4P0\rG4P0\r\n\r\n\n")
    assert machine.turns(5) == ["ok"] * 5
    machine.put(b"G4P0\r")
    machine.turns(3)
    machine.put(b"\nG4P0\n")
    assert machine.turns(3) == ["ok"]
    for data in (b"G4P0\r", b"\n", b"\n", b"\r", b"\n\n"):
        machine.put(data)
        machine.turns(1)
    machine.put(b"\n")
    machine.turns(3)
    machine.said()
    machine.put(b"\r")
    said = machine.turns(2)
    for _ in range(2):
        machine.put(b"\n")
        said += machine.turns(2)
    assert said == ["ok"] * 2


def check_a_few_lines_a_turn():
    """Where lines take time, a burst of them is shared out over turns, and what is asked meanwhile is answered first."""
    machine = Machine().ready()
    machine.app.links[0].protocol.most = 3
    machine.put("G91 G0\n" + "".join(["X%d\n" % (i + 1) for i in range(10)]))
    assert machine.turns() == ["ok"]  # it goes the long way
    assert machine.turns() == ["ok"] * 3
    machine.put("?")
    said = machine.turns()
    assert len(said) == 1 and said[0].startswith("<")
    assert machine.turns(3) == ["ok"] * 7
    machine.put("G91 G0 X1\n" * 2)
    assert machine.turns() == ["ok"]
    assert machine.turns() == ["ok"]
    machine.settle()
    assert machine.controller.queue.target[0] == 57 * 320


def check_settings_lines():
    machine = Machine().ready()
    for line, said in (
        ("$100=160", ["ok"]), ("$ 1 0 1 = 160.5", ["ok"]), ("$110=-1", ["error:4"]), ("$110=", ["error:2"]),
        ("$110=x", ["error:2"]), ("$110=1x", ["error:2"]), ("$110=1X2", ["error:2"]), ("$7=1", ["error:3"]),
        ("$=1", ["error:3"]), ("$K", ["error:3"]), ("$110", ["error:3"]), ("$0=2", ["error:6"]), ("$22=0", ["ok"]),
        ("$20=1", ["error:10"]), ("$H", ["error:5"]), ("$22=1", ["ok"]), ("$110=900000", ["error:12"]),
        ("$32=1", ["error:17"]), ("$N2=G0", ["error:3"]), ("$N0", ["error:3"]), ("$N0=G7", ["error:20"]),
        ("$RST=x", ["error:3"]), ("$J", ["error:3"]), ("$J=X1", ["error:22"]), ("$J=G1X1F1", ["error:16"]),
        ("$10=3", ["ok"]), ("$13=1", ["ok"]), ("$110=1.5.5", ["error:2"]),
        ("$I=" + "x" * 78, ["error:11"]),
    ):
        got = machine.ask(line)
        assert got == said, (line, got)
    shown = machine.ask("$$")
    assert "$100=160.000" in shown and "$101=160.500" in shown and "$10=3" in shown and shown[-1] == "ok"
    again = Machine(slots=machine.slots)
    assert "$101=160.500" in again.ready().ask("$$")
    assert again.controller.settings.value(13) == 1


def check_texts_and_start_lines():
    machine = Machine().ready()
    assert machine.ask("$I=shop 2") == ["ok"]
    assert machine.ask("$I")[0] == "[VER:1.1h.20190830:SHOP2]"
    assert machine.ask("$I")[1].startswith("[OPT:V")
    assert machine.ask("$N0=G54 G20") == ["ok"]
    assert machine.ask("$N") == ["$N0=G54G20", "$N1=", "ok"]
    assert machine.ask("$G")[0] == "[GC:G0 G54 G17 G20 G90 G94 M5 M9 T0 F0 S0]"
    machine.put(b"\x18")
    assert machine.turns(4) == [BANNER, ">G54G20:ok"]
    again = Machine(slots=machine.slots)
    assert again.turns(3) == [BANNER, UNHOMED]
    again.put(b"$H\n")
    again.settle()
    assert again.turns(4) == ["ok", ">G54G20:ok"]
    assert again.ask("$N0=") == ["ok"]
    again.put(b"\x18")
    assert again.turns(4) == [BANNER]


def check_restore():
    machine = Machine().ready()
    machine.do("$110=1000", "G10L2P1X5", "$N0=G21", "$13=1")
    assert machine.ask("$RST=$")[:3] == ["[MSG:Restoring defaults]", "ok", BANNER]
    machine.turns(5)
    assert "$110=5000.000" in machine.ask("$$")
    assert machine.ask("$#")[0] == "[G54:5.000,0.000,0.000]"
    machine.do("$110=1000")
    assert machine.ask("$RST=#")[1] == "ok"
    machine.turns(5)
    assert machine.ask("$#")[0] == "[G54:0.000,0.000,0.000]" and machine.ask("$N")[0] == "$N0=G21"
    assert "$110=1000.000" in machine.ask("$$")
    assert machine.ask("$RST=*")[1] == "ok"
    machine.turns(5)
    assert machine.ask("$N")[0] == "$N0="
    assert "$110=5000.000" in Machine(slots=machine.slots).ready().ask("$$")


def check_parameters_and_modes():
    machine = Machine().ready()
    assert machine.ask("$G") == ["[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]", "ok"]
    machine.do("G1 X1 F600.4", "G55 G91 G18 G93 M7", "M8", "T7 S1200 M4", "G43.1 Z2")
    machine.settle()
    assert machine.ask("$G")[0] == "[GC:G1 G55 G18 G21 G91 G93 M4 M7 M8 T7 F0 S1200]"
    machine.do("G94 F100", "G38.3 Z-1")
    machine.settle()
    assert machine.ask("$G")[0].startswith("[GC:G38.3 G55")
    machine.do("G90 G10 L2 P6 X1 Y-2.5 Z.0004", "G28.1", "G92 X0")
    said = machine.ask("$#")
    assert said[5] == "[G59:1.000,-2.500,0.000]" and said[6].startswith("[G28:1.000,0.000,") and len(said) == 12
    assert said[8] == "[G92:1.000,0.000,0.000]" and said[9] == "[TLO:2.000]" and said[10].startswith("[PRB:")
    machine.do("$13=1")
    assert machine.ask("$#")[5] == "[G59:0.0394,-0.0984,0.0000]"


def check_status_report():
    machine = Machine().ready()
    assert machine.status()["text"] == "<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>"
    assert machine.status()["text"] == "<Idle|MPos:0.000,0.000,0.000|FS:0,0|Ov:100,100,100>"
    shown = [machine.status() for _ in range(40)]
    for name, every in (("WCO", 10), ("Ov", 10)):
        at = [place for place in range(40) if name in shown[place]]
        assert len(at) in (3, 4, 5) and all([b - a in (every, every + 1) for a, b in zip(at, at[1:])]), (name, at)
    assert not [fields for fields in shown if "WCO" in fields and "Ov" in fields]
    machine.do("G10 L2 P1 X1.5", "G4 P0")
    fields = machine.status()
    assert fields["WCO"] == "1.500,0.000,0.000"
    machine.do("$10=2")
    fields = machine.status()
    assert fields["WPos"] == "-1.500,0.000,0.000" and fields["Bf"] == "96,128" and "MPos" not in fields
    machine.do("$13=1", "N7 G1 X30 F600 S500 M3")
    machine.turns(20)
    fields = machine.status()
    assert fields["state"] == "Run" and fields["Ln"] == "7" and abs(float(fields["WPos"].split(",")[0])) < 0.06
    assert fields["FS"].endswith(",500") and 20 <= float(fields["FS"].split(",")[0]) <= 24
    machine.world.switches["probe"] = 0
    machine.world.switches["limit_y"] = 1
    assert machine.status()["Pn"] == "YP"


def check_bytes_are_counted():
    machine = Machine().ready()
    machine.do("$10=3")
    machine.put(b"G4P5\n")
    machine.turns(3)
    machine.put(b"G0X1\nG0Y")
    machine.turns(2)
    assert machine.status()["Bf"].split(",")[1] == str(128 - 8)


def check_every_real_time_byte():
    kinds = {}
    for byte in range(256):
        command = real_time(byte)
        if command is not None:
            kinds[byte] = command.kind
    wanted = [0x18, 0x21, 0x3F, 0x7E, 0x84, 0x85, 0x9E, 0xA0, 0xA1]
    wanted += list(range(0x90, 0x98)) + list(range(0x99, 0x9E))
    assert sorted(kinds) == sorted(wanted)


def check_overrides():
    machine = Machine().ready()
    machine.status()
    for data, shown in (
        (b"\x91", "110,100,100"), (b"\x93\x93", "112,100,100"), (b"\x92\x94", "101,100,100"), (b"\x90", "100,100,100"),
        (b"\x91" * 30, "200,100,100"), (b"\x92" * 30, "10,100,100"), (b"\x90\x96", "100,50,100"),
        (b"\x97", "100,25,100"), (b"\x95\x9a", "100,100,110"), (b"\x9c\x9b\x9d", "100,100,100"), (b"\x99", "100,100,100"),
    ):
        machine.put(data)
        machine.turns(2)
        assert ",".join([str(part) for part in machine.controller.tools.overrides]) == shown
    machine.put(b"\x91\x96\x9a")
    machine.do("M30")
    assert machine.controller.tools.overrides == [100, 100, 100]


def check_real_time_bytes_inside_lines():
    """They are taken out wherever they stand; what else is above 0x7F is dropped."""
    machine = Machine().ready()
    machine.put(b"G1?X\x91\xff\x801F6?00\n")
    said = machine.turns(3)
    assert answers(said) == ["ok"] and len([line for line in said if line.startswith("<")]) == 1
    machine.settle()
    assert machine.controller.position() == [320, 0, 0] and machine.controller.tools.overrides[0] == 110


SQUARE = ["G1 X%d.%d Y%d F4000" % (5 + i % 7, i % 10, i % 5) for i in range(150)] + ["G1 X1 Y2 Z-1"]


def check_ok_counting():
    machine = Machine().ready()
    for line in SQUARE:
        assert machine.ask(line) == ["ok"]
    machine.settle()
    assert machine.controller.position() == [320, 640, -400]


def check_character_counting():
    """128 bytes under way at most, newline included: one ok a line, nothing lost, the same end."""
    machine = Machine().ready()
    waiting = [line + "\n" for line in SQUARE]
    under_way = []
    oks = 0
    while waiting or under_way:
        while waiting and sum([len(line) for line in under_way]) + len(waiting[0]) <= 128:
            under_way.append(waiting[0])
            machine.put(waiting.pop(0))
        for line in machine.turns():
            assert line == "ok", line
            oks += 1
            under_way.pop(0)
    assert oks == len(SQUARE)
    machine.settle()
    assert machine.controller.position() == [320, 640, -400]


def check_a_flood_is_refused_line_by_line():
    """A sender that counts nothing: what found no room is refused, and every line has its answer."""
    machine = Machine().ready()
    machine.do("G4P0")
    machine.put(b"G4P1\n" + b"G91G0X1\n" * 300)
    said = []
    while len(said) < 301:
        said += machine.turns()
    kept = said.count("ok") - 1
    assert 100 < kept < 200 and said.count("error:11") == 300 - kept
    machine.settle()
    assert machine.controller.position() == [320 * kept, 0, 0]


def check_lines_too_long():
    machine = Machine().ready()
    assert machine.ask("G0X1" + "0" * 76) == ["error:2"]
    assert machine.ask("G0X1." + "0" * 76) == ["error:11"]
    assert machine.ask("G0 X1 " + " " * 60 + "(a comment)" + " " * 60) == ["ok"]
    assert machine.ask("G0X2" + " " * 300) == ["error:11"]
    machine.settle()
    assert machine.controller.position() == [320, 0, 0]


def check_hold_and_resume():
    machine = Machine().ready()
    machine.world.path = []
    machine.do("G1 X4 Y2 F900")
    machine.turns(12)
    machine.put(b"!")
    machine.turns(1)
    assert machine.status()["state"] in ("Hold:1", "Hold:0")
    machine.turns(60)
    assert machine.status()["state"] == "Hold:0"
    place = machine.controller.position()
    assert 0 < place[0] < 1280
    machine.turns(50)
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


def check_more_arcs_than_are_queued_at_once():
    machine = Machine().ready()
    planner = machine.app.planner
    machine.do("G91F900")
    full = 0
    for number in range(3 * ARCS):
        machine.do("G3X-.5Y-.5I-.5" if number & 1 else "G3X.5Y.5J.5")
        assert planner.counts[0] - planner.counts[3] <= ARCS
        full += not planner.room()
    assert full > ARCS
    machine.settle()
    assert tuple(machine.controller.position()) == (0, 0, 0)


def check_what_a_board_has_no_memory_for():
    """Arcs and S-curves where they do not fit: said, and nothing else is lost."""
    machine = Machine().ready()
    controller = machine.controller
    controller.arcs_want = 1 << 40
    if not hasattr(gc, "mem_free"):
        gc.mem_free = lambda: 0  # CPython knows no such thing
    assert machine.ask("G1F600X1") == ["ok"] and machine.ask("G2X3I1") == ["error:%d" % errors.NO_MEMORY]
    assert machine.ask("X2") == ["ok"]
    machine.settle()
    assert tuple(machine.controller.position()) == (640, 0, 0)
    controller.program.curves_want = 1 << 40
    assert machine.ask("$141=5000") == ["ok", "[MSG:No S-curves on this board]"]
    assert not machine.app.planner.ramp.smooth
    controller.program.curves_want = 0
    machine.ask("$141=6000")
    machine.turns(3)
    assert machine.app.planner.ramp.smooth


def check_arcs_far_too_slow_are_refused():
    """Also where the arc goes as chords, and at the speed at which only their diagonal steps would be too far apart."""
    for feed, said in ((".004", "error:34"), (".0055", "error:34"), (".02", "ok")):
        machine = Machine().ready()
        assert machine.ask("G18 G2 X3 Z-3 R3 F" + feed) == [said], feed
        machine.turns(20)
    machine = Machine().ready()
    machine.do("$112=0.001")
    assert machine.ask("G18 G2 X3 Z-3 R3 F600") == ["error:34"]


def check_what_is_refused_leaves_the_tool():
    """Where a change of the tool takes time, none is queued for motion that is refused, whatever refuses it."""
    machine = Machine(spindle=LASER, tool={"pin": 8, "active": 1, "on_ms": 50, "off_ms": 30}).ready()
    machine.do("G0 X5 Y5", "M3 S500")
    machine.settle()
    place = machine.controller.position()
    for line in ("G18 G2 X8 Z-3 R3 F.004", "G17 G2 X5.003 I-.5 J-.25 F.0001", "G3 X5 Y5 Z-90 I.1 F.001", "G1 X5.01 F.0001"):
        machine.turns(3)
        assert machine.ask(line)[0] in ("error:33", "error:34"), line
        assert machine.controller.queue.still() and not machine.controller.queue.tool, line
        machine.turns(100)
        assert machine.world.tool_changes == [] and machine.controller.position() == place, line
    for line in ("G17 G3 X5 Y5 I2 F900", "G18 G2 X8 Z-3 R3", "G17 G2 X5.003 I-.5 J-.25", "G1 X9"):
        steps = machine.world.steps
        machine.do(line, "G0 X5 Y5 Z0")
        machine.settle()
        (on, _), (off, _) = machine.world.tool_changes
        assert machine.world.steps > steps and off > on + 50 * 12_500, line
        del machine.world.tool_changes[:]


def check_arcs_stay_inside():
    machine = home(Machine())
    machine.do("G0 X10 Y10")
    machine.settle()
    assert "ALARM:2" in machine.ask("G3 X10 Y10 J-10.1 F1000")
    machine.put(b"\x18")
    machine.turns(3)
    machine.do("$X", "G3 X10 Y10 J-5 F3000", "G2 X10 Y20 R10 F3000")
    machine.settle()
    assert machine.controller.position() == [3200, 6400, 0]


def check_hold_at_rest():
    machine = Machine().ready()
    machine.put(b"!")
    machine.turns(3)
    assert machine.status()["state"] == "Hold:0"
    assert machine.ask("G0 X1") == ["ok"]
    machine.turns(30)
    assert machine.controller.position() == [0, 0, 0]
    machine.put(b"~")
    machine.settle()
    assert machine.controller.position() == [320, 0, 0]


def check_reset():
    machine = Machine().ready()
    machine.do("G1 X20 F3000", "G55")
    machine.turns(20)
    machine.put(b"G0 X1\nG0\x18")
    assert machine.turns(5) == ["ALARM:3", BANNER, UNHOMED]
    place = machine.controller.position()
    assert machine.turns(50) == [] and machine.controller.position() == place and not machine.controller.homed
    assert machine.world.place[0] - 3000 == place[0]
    machine.do("$X")
    assert machine.ask("$G")[0].startswith("[GC:G0 G54")
    machine.do("G91 G0 X1")
    machine.settle()
    assert machine.controller.position()[0] == place[0] + 320
    machine.do("G1 X20 F3000")
    machine.turns(10)
    machine.put(b"!")
    machine.turns(60)
    machine.put(b"\x18")
    assert machine.turns(5) == [BANNER]
    assert machine.status()["state"] == "Idle"


def check_jogs():
    machine = Machine().ready()
    machine.put(b"$J=X10F6000\n$J=G91X5F6000\n$J=G53X0Y0F600\n")
    assert machine.turns(2) == ["ok"] * 3
    assert machine.status()["state"] == "Jog"
    assert machine.ask("G0 X0") == ["error:9"]
    machine.put(b"\x85")
    machine.turns(60)
    assert machine.status()["state"] == "Idle"
    place = machine.controller.position()
    assert 0 < place[0] < 4800 and machine.world.place[0] - 3000 == place[0]
    assert machine.ask("$J=G91X1F600") == ["ok"]
    machine.settle()
    assert machine.controller.position()[0] == place[0] + 320
    machine.do("$J=G20 X1 F30")
    machine.turns(5)
    machine.put(b"!")
    machine.turns(60)
    assert machine.status()["state"] == "Idle"
    machine.put(b"G1 X20 F600\n$J=X1F100\n")
    assert machine.turns(4) == ["ok", "error:8"]
    assert machine.ask("$G")[0].startswith("[GC:G1 G54 G17 G21 G90")


def home(machine):
    machine.said()
    assert machine.ask("$H") == ["ok"]
    return machine


def check_homing():
    machine = home(Machine())
    assert machine.controller.position() == [0, 0, 0] and machine.controller.homed
    assert [machine.world.place[axis] for axis in (0, 1)] == [PULL_OFF] * 2 and machine.world.place[2] == -PULL_OFF
    assert machine.status()["MPos"] == "0.000,0.000,0.000" and machine.status()["state"] == "Idle"
    machine.do("G0 X300 Y200 Z-80", "G0 X0 Y0 Z0")
    machine.settle()
    machine.put(b"$H\n")
    machine.turns(5)
    assert machine.status()["state"] == "Home"
    machine.put(b"\x18")
    assert machine.turns(4) == ["ALARM:6", BANNER, UNHOMED]
    machine.put(b"$H\n")
    machine.turns(5)
    machine.put(b"\x84")
    said = machine.turns(4)
    assert said == ["[MSG:Check Door]", "ALARM:7", "error:9"]


def check_homing_alarms():
    for switch, level, alarm in (("limit_z", 0, "ALARM:9"), ("limit_z", 1, "ALARM:8"), ("limit_x", 0, "ALARM:9")):
        machine = Machine()
        machine.world.switches[switch] = level
        machine.said()
        assert machine.ask("$H", 400_000) == [alarm, "error:9"]
        assert machine.status()["state"] == "Alarm" and machine.world.tool == 0


def check_soft_limits():
    machine = home(Machine())
    steps = machine.world.steps
    for line in ("G0 X-0.01", "G0 X300.01", "G1 Y201 F100", "G0 Z1", "M3 S100 G1 Z-81 F100"):
        assert machine.ask(line) == ["ALARM:2", "[MSG:Reset to continue]", "error:15"], line
        assert machine.ask("$X") == ["error:9"] and machine.ask("G0 X1") == ["error:9"]
        machine.put(b"\x18")
        assert machine.turns(3) == [BANNER, UNHOMED]
        machine.do("$X")
        assert machine.controller.homed and machine.world.tool == 0
    assert machine.ask("$J=X-1F100") == ["error:15"]
    assert machine.world.steps == steps
    machine.do("$20=0", "G0 X-0.5")
    machine.settle()
    assert machine.controller.position() == [-160, 0, 0]


def check_a_line_of_several_motions_is_refused_whole():
    """Canned cycles, and G28 by way of a place: no part of them moves if another cannot."""
    machine = home(Machine())
    for setting, line, said in (
        ("$11=.01", "G81 X9 Y9 Z-81 R-2 F300", "error:15"), ("$11=.01", "G81 X1 Y2 Z-23 R-2 F.003", "error:33"),
        ("$111=.001", "G81 X1 Y2 Z-23 R-2 F300", "error:33"),  # an axis that is too slow for it
    ):  # fmt: skip
        machine.do("G0 X1", "G4 P0", setting)
        machine.put("G0 X2\n")
        assert said in machine.ask(line) + machine.turns(3), line
        machine.settle()
        assert machine.controller.position()[1:] == [0, 0], line
        machine.put(b"\x18")
        machine.turns(3)
        machine.do("$X")


def check_soft_limit_while_moving():
    """The machine comes to a stand on its path, and knows where it is."""
    machine = home(Machine())
    machine.do("G1 X20 F3000")
    machine.turns(20)
    assert machine.ask("G1 X999")[:2] == ["ALARM:2", "[MSG:Reset to continue]"]
    machine.turns(60)
    place = machine.controller.position()
    assert 0 < place[0] < 6400 and machine.world.place[0] - PULL_OFF == place[0]
    machine.put(b"\x18")
    machine.turns(3)
    machine.do("$X", "G0 X0")
    machine.settle()
    assert machine.world.place[0] == PULL_OFF


def check_hard_limits():
    machine = home(Machine())
    machine.do("$21=1", "G1 X50 F3000")
    machine.turns(20)
    machine.world.switches["limit_y"] = 1
    said = machine.turns(5)
    assert said[:2] == ["ALARM:1", "[MSG:Reset to continue]"]
    place = machine.world.place[:]
    machine.turns(20)
    assert machine.world.place == place and machine.controller.inputs.hit == "Y" and not machine.controller.homed
    assert machine.ask("$H") == ["error:9"]
    machine.put(b"\x18")
    machine.turns(3)
    machine.do("$X")


def check_probing():
    machine = Machine().ready()
    machine.world.floor = -1800 - 1234
    said = machine.ask("G38.2 Z-10 F200")
    assert said[-1] == "ok" and said[0].startswith("[PRB:0.000,0.000,-3.08") and said[0].endswith(":1]")
    assert abs(machine.controller.position()[2] + 1234) < 60
    assert machine.ask("$#")[-2] == said[0]
    machine.do("G38.5 Z0 F50")
    assert machine.controller.position()[2] > -1234
    said = machine.ask("G38.2 Z1 F200")
    assert said == ["[PRB:0.000,0.000,1.000:0]", "ok", "ALARM:5"] or "ALARM:5" in said + machine.turns(3)
    machine.do("$X", "G0 Z-5")
    machine.settle()
    said = machine.ask("G38.2 Z-10 F200") + machine.turns(3)
    assert "ALARM:4" in said
    machine.do("$X")
    machine.do("G38.4 Z0 F200", "G38.3 Z1 F200")
    assert machine.status()["state"] == "Idle"


def check_door():
    machine = Machine().ready()
    machine.do("M3 S500 M8", "G1 X20 F3000")
    machine.turns(20)
    assert machine.world.tool == 1 and machine.world.outputs["flood"] == 1
    machine.world.switches["door"] = 0
    machine.turns(60)
    assert machine.status()["state"] == "Door:1" and machine.status()["Pn"] == "D" and machine.world.tool == 0
    machine.put(b"~")
    machine.turns(5)
    assert machine.status()["state"] == "Door:1"
    machine.world.switches["door"] = 1
    machine.turns(5)
    assert machine.status()["state"] == "Door:0"
    machine.put(b"~")
    machine.settle()
    assert machine.controller.position() == [6400, 0, 0] and machine.world.tool == 1
    machine.put(b"\x84")
    machine.turns(3)
    assert machine.status()["state"] == "Door:0"
    machine.put(b"~")
    machine.turns(3)
    assert machine.status()["state"] == "Idle"


def check_door_at_rest():
    """Said each time it opens; neither unlocked nor homed while it is; after a reset the machine waits for it."""
    machine = Machine()
    machine.said()
    machine.world.switches["door"] = 0
    assert machine.turns(10) == ["[MSG:Check Door]"]
    assert machine.ask("$X") == ["error:13"] and machine.ask("$H") == ["error:13"]
    machine.world.switches["door"] = 1
    machine.turns(10)
    assert machine.ask("$X") == ["[MSG:Caution: Unlocked]", "ok"]
    machine.world.switches["door"] = 0
    assert machine.turns(10) == ["[MSG:Check Door]"]
    machine.put(b"\x18")
    assert machine.turns(10) == [BANNER, "[MSG:Check Door]"]
    assert machine.status()["state"] == "Door:1"
    assert machine.ask("G0 X1") == ["ok"]
    machine.world.switches["door"] = 1
    machine.turns(10)
    assert machine.world.steps == 0
    machine.put(b"~")
    machine.settle()
    assert machine.controller.position() == [320, 0, 0] and machine.status()["state"] == "Idle"


def check_limits_at_the_start():
    """An active limit is said and locks, where limits are watched."""
    machine = Machine().ready()
    machine.world.switches["limit_x"] = 1
    machine.put(b"\x18")
    assert machine.turns(3) == [BANNER]
    machine.do("$21=1")
    machine.put(b"\x18")
    assert machine.turns(3) == [BANNER, UNHOMED, "[MSG:Check Limits]"]
    assert machine.ask("G0 X1") == ["error:9"]
    again = Machine(World(start=(-1, 100, -100)), machine.slots)
    assert again.turns(2)[-1] == "[MSG:Check Limits]"


BUTTONS = [{"name": name, "pin": 20 + pin, "active": 0} for pin, name in enumerate(("hold", "resume", "reset"))]


def check_buttons():
    """Inputs named hold, resume and reset do what the bytes do, and show in Pn; noise shorter than $26 does nothing."""
    machine = Machine(inputs=BUTTONS + BOARD["inputs"])
    for name in ("hold", "resume", "reset"):
        machine.world.switches[name] = 1
    machine.turns(3)
    machine.ready()

    def press(name):
        machine.world.switches[name] = 0
        said = machine.turns(10)
        pins = machine.status()["Pn"]
        machine.world.switches[name] = 1
        return [pins] + said + machine.turns(10)

    machine.do("G1 X20 F3000")
    machine.turns(10)
    assert press("hold") == ["H"]
    machine.turns(60)
    assert machine.status()["state"] == "Hold:0" and 0 < machine.controller.position()[0] < 6400
    assert press("resume") == ["S"]
    machine.turns(5)
    assert machine.status()["state"] == "Run"
    machine.settle()
    assert machine.controller.position()[0] == 6400
    assert press("reset") == ["R", BANNER]
    machine.do("$26=200", "G1 X0 F600")
    machine.world.switches["hold"] = 0
    machine.turns(1)
    machine.world.switches["hold"] = 1
    machine.turns(10)
    assert machine.status()["state"] == "Run"


def check_damaged_settings_are_told():
    slots = MemorySlots()
    slots.data = [b"passo 1 7 00000000\n110=500", b"\xff" * 40]
    machine = Machine(slots=slots)
    assert machine.turns(1) == ["error:7", BANNER, UNHOMED]
    machine.ready().do("$110=600")
    machine.put(b"\x18")
    assert machine.turns(3) == [BANNER]
    assert Machine(slots=slots).turns(1) == [BANNER, UNHOMED]


def check_settings_that_cannot_be_kept():
    machine = Machine().ready()

    def full(slot, data):
        raise OSError(28)

    machine.slots.write = full
    assert machine.ask("$110=600") == ["error:7"]


def check_texts_too_long():
    """No line of 80 characters holds one; what else asks for it is refused."""
    machine = Machine(links=BOARD["links"][:1]).ready()
    system = machine.app.links[0].protocol._system
    assert system.execute("$I=" + "A" * 81) == errors.START_LINE_TOO_LONG
    assert system.execute("$N0=" + "G4P0(" + "A" * 80 + ")") == errors.START_LINE_TOO_LONG
    assert machine.ask("$N0")[-1] == "error:3" and machine.ask("$N")[0] == "$N0="


def check_inverted_inputs_and_pulses():
    """$5 and $6 turn limits and probe round, $2 the pulses and $0 their length, with the next start."""
    machine = Machine(slots=MemorySlots()).ready()
    machine.do("$5=1", "$6=1")
    assert machine.status()["Pn"] == "XYZP"
    machine.world.switches.update({"limit_x": 0, "limit_y": 1, "limit_z": 1, "probe": 0})
    assert machine.status()["Pn"] == "X"
    assert machine.world.rest == 0 and machine.app.player.min_word_ticks == 76
    machine.do("$5=0", "$6=0", "$2=5", "$0=10")
    again = Machine(slots=machine.slots).ready()
    assert again.world.rest == 0b101 and again.app.player.min_word_ticks == 250
    again.do("G0 X1 Y1 Z1")
    again.settle()
    assert again.controller.position() == [320, 320, 400]
    assert [at - by for at, by in zip(again.world.place, (3000, 2500, -1800))] == [320, 320, 400]


def check_operator_pauses():
    machine = Machine().ready()
    for line in ("M0", "M1", "M6 T2"):
        machine.put("G0 X1\n%s\nG0 X0\n" % line)
        said = machine.turns(60)
        assert said == ["ok"], said
        assert machine.status()["state"] == "Hold:0" and machine.controller.position() == [320, 0, 0]
        machine.put(b"~")
        assert machine.turns(60) == ["ok", "ok"]
        assert machine.controller.position() == [0, 0, 0]


def check_spindle_and_coolant():
    machine = Machine().ready()
    machine.do("M3 S12000")
    machine.settle()
    assert machine.world.tool == 1 and machine.world.outputs["reverse"] == 0
    fields = machine.status()
    fields = machine.status()
    assert fields["A"] == "S" and fields["FS"] == "0,12000"
    machine.put(b"\x9a")
    assert machine.status()["FS"] == "0,13200"
    machine.do("M4 M7", "G4 P0")
    assert machine.world.outputs["reverse"] == 1 and machine.world.outputs["mist"] == 1
    machine.put(b"\xa0")
    machine.turns(2)
    assert machine.world.outputs["flood"] == 1
    machine.put(b"!")
    machine.turns(5)
    machine.put(b"\x9e")
    machine.turns(2)
    assert machine.world.tool == 0
    machine.put(b"\x9e")
    machine.turns(2)
    assert machine.world.tool == 1
    machine.put(b"~")
    machine.turns(3)
    assert machine.ask("M2") == ["[MSG:Pgm End]", "ok"]
    assert machine.world.tool == 0 and machine.world.outputs["mist"] == 0 and machine.world.outputs["flood"] == 0
    machine.do("M3 S100 M8")
    machine.put(b"\x18")
    machine.turns(3)
    assert machine.world.tool == 0 and machine.world.outputs["flood"] == 0


LASER = {"max_rpm": 1000, "min_rpm": 0, "pwm": True, "pin": 18, "laser": True}


def check_laser():
    """The beam is on exactly while cutting, off in rapids, at a stand and in a hold."""
    machine = Machine(spindle=LASER).ready()
    machine.world.path = []
    machine.do("M4 S500", "G0 X2", "G1 X4 F600", "G0 X6", "G1 X8", "X10 S0", "X12 S900")
    machine.settle()
    for _, x, _, _, tool in machine.world.path:
        at = x - 3000
        wanted = 641 <= at <= 1280 or 1921 <= at <= 2560 or 3201 <= at <= 3840
        assert tool == (1 if wanted else 0), at
    machine.do("G1 X30")
    machine.turns(20)
    assert machine.world.tool == 1
    machine.put(b"!")
    machine.turns(60)
    assert machine.world.tool == 0
    machine.put(b"~")
    machine.turns(10)
    assert machine.world.tool == 1
    machine.settle()
    machine.do("M5")
    machine.turns(5)
    assert machine.world.tool == 0


def check_power_follows_the_speed():
    """M4: power / S is speed / F, in both ramps and in cruise; M3: the same power throughout."""
    machine = Machine(spindle=LASER).ready()
    machine.world.burnt = []
    machine.do("M4 S800", "G1 X16 F3000")
    machine.settle()
    burnt = machine.world.burnt
    assert max([power for _, _, _, power in burnt]) == 800 and machine.world.power_level == 0 and not machine.world.tool
    for at in range(100, 5000, 50):
        mm_s = 20 / 320 * 12_500_000 / (burnt[at + 10][0] - burnt[at - 10][0])
        wanted = 800 * mm_s / 50
        assert abs(burnt[at][3] - wanted) <= 25, (at, burnt[at][3], wanted)
    assert [power for _, _, _, power in burnt[:3]] < [40] * 3 and burnt[-1][3] < 40
    del burnt[:]
    machine.do("M3 S500", "G1 X0 F3000", "X2 S1", "X4 S1000 F6000")
    machine.settle()
    assert set([power for _, x, _, power in burnt[:5120]]) == set([500])
    assert set([power for _, x, _, power in burnt[5120:5760]]) == set([1])
    assert set([power for _, x, _, power in burnt[5760:]]) == set([1000])
    assert machine.world.tool == 1 and machine.world.power_level == 1000  # as grbl: M3 burns on
    machine.do("M5")
    machine.turns(3)
    assert machine.world.tool == 0 and machine.world.power_level == 0


def check_power_where_an_axis_is_slower_than_the_feed():
    machine = Machine(spindle=LASER).ready()
    machine.world.burnt = []
    machine.do("M4 S1000", "G1 X40 F10000")  # $110 is 5000
    machine.settle()
    assert 495 <= max([power for _, _, _, power in machine.world.burnt]) <= 501


def check_power_override_acts_at_once():
    machine = Machine(spindle=LASER).ready()
    machine.do("M3 S500", "G1 X40 F3000")
    machine.turns(30)
    assert machine.world.power_level == 500 and machine.status()["FS"] == "3000,500"
    machine.put(b"\x9a\x9a")
    machine.turns(1)
    assert machine.world.power_level == 600 and machine.status()["FS"] == "3000,600"
    machine.put(b"\x9b" * 12)
    machine.turns(4)
    assert machine.world.power_level == 50
    machine.put(b"\x99!")
    machine.turns(60)
    assert machine.world.power_level == 0 and machine.world.tool == 0 and machine.status()["FS"] == "0,0"
    machine.put(b"~")
    machine.turns(30)
    assert machine.world.power_level == 500 and machine.world.tool == 1
    machine.put(b"\x18")
    machine.turns(2)
    assert machine.world.power_level == 0 and machine.world.tool == 0


def check_spindle_power():
    """A spindle by PWM: the weakest signal up to $31, the rest above it; off is nothing."""
    machine = Machine(spindle={"max_rpm": 24000, "min_rpm": 6000, "pwm": True, "pin": 18}).ready()
    for line, level in (("M3 S24000", 1000), ("S6000", 1), ("S15000", 500), ("S100", 1), ("S0", 0), ("S30000", 1000)):
        machine.do(line)
        machine.turns(3)
        assert machine.world.power_level == level, line
        assert machine.status()["FS"] == "0," + str(min(int(line.split("S")[1]), 24000)), line
    machine.do("$31=0", "S12000")
    machine.turns(3)
    assert machine.world.power_level == 500
    machine.do("G1 X1 F1000")
    machine.settle()
    assert machine.world.power_level == 500
    machine.do("M5")
    assert machine.world.power_level == 0 and machine.world.tool == 0


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
    machine.turns(30)
    machine.put(b"\x96")
    machine.turns(60)
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
    assert machine.ask("G1 Q1") == ["error:20"]
    assert machine.ask("$C")[:3] == ["[MSG:Disabled]", "ok", BANNER]
    machine.turns(3)
    assert machine.world.steps == steps and machine.world.tool == 0
    machine.do("G91 G0 X1")
    machine.settle()
    assert machine.controller.position() == [320, 0, 0]
    machine.do("G90 G1 X20 F600")
    assert machine.ask("$C") == ["error:8"]


def check_pins_follow_the_settings():
    """Direction and enable turned round with the next start, the drivers' release at once."""
    machine = Machine().ready()
    machine.do("$3=1", "$4=1", "$1=30")
    again = Machine(slots=machine.slots).ready()
    again.do("G0 X1 Y1")
    assert again.world.outputs["enable"] == 1
    again.settle()
    assert [again.world.place[0] - 3000, again.world.place[1] - 2500] == [-320, 320]
    assert again.controller.position() == [320, 320, 0]
    again.turns(200)
    assert again.world.outputs["enable"] == 0


def check_sleep():
    machine = Machine().ready()
    machine.do("M3 S100")
    assert machine.ask("$SLP") == ["[MSG:Sleeping]", "ok"]
    assert machine.status()["state"] == "Sleep" and machine.ask("G0 X1") == ["error:9"]
    assert machine.world.tool == 0 and machine.world.outputs["enable"] == 1
    machine.put(b"~!")
    machine.turns(3)
    assert machine.status()["state"] == "Sleep"
    machine.put(b"\x18")
    assert machine.turns(3) == [BANNER, UNHOMED]


def check_busy_refusals():
    machine = Machine().ready()
    machine.do("G1 X20 F600")
    for line in ("$H", "$SLP", "$#", "$I", "$N", "$110=100", "$RST=$", "$C", "$$"):
        assert machine.ask(line) == ["error:8"], line
    assert answers(machine.ask("$G")) == ["ok"]


def check_nothing_is_written_while_moving():
    machine = Machine().ready()
    writes = []
    kept = machine.slots.write

    def write(slot, data):
        writes.append(machine.controller.queue.still())
        kept(slot, data)

    machine.slots.write = write
    machine.do("G1 X5 F600", "G10 L2 P1 X1", "G28.1")
    assert writes == []
    machine.settle()
    machine.turns(2)
    assert writes == [True]
    assert Machine(slots=machine.slots).controller.settings.get("G54") == "1000000,0,0"


def check_two_links_share_the_machine():
    machine = Machine().ready()
    serial = machine.port.lines["serial"]
    machine.do("G10 L2 P1 X1", "G0 X5")
    machine.settle()
    serial.outgoing = b""
    serial.incoming += b"G91 G0 X1\n$LINK=0\nG91 G0 X1\n"
    machine.turns(1)
    machine.settle()
    assert serial.outgoing == b"error:112\r\n[MSG:Command handed over]\r\nok\r\nok\r\n"
    assert machine.controller.position() == [7 * 320, 0, 0]
    machine.do("$LINK=1", "G0 X0")
    machine.settle()
    assert machine.controller.position() == [320, 0, 0]
    machine.put(b"\x18")
    machine.turns(2)
    assert b"Grbl 1.1h" in serial.outgoing


def check_decimals(value, places):
    text = decimal(value, places)
    assert int(text.replace(".", "")) == value and (len(text.split(".")[1]) == places if places else "." not in text)


def check_plain_text():
    assert plain_text(b" $n0 = g1 x1 \xff\x01") == "$N0=G1X1"


def mutated(random):
    line = bytearray(random.choice(GOOD))
    for _ in range(random.between(0, 3)):
        at = random.between(0, len(line) - 1)
        line = line[:at] + bytes((random.choice(ALPHABET),)) * random.choice((1, 1, 1, 30)) + line[at + random.between(0, 1) :]
    return bytes(line)


def recover(machine):
    """Reset and unlock; the machine works again."""
    machine.put(b"\n\x18")
    machine.turns(4)
    machine.said()
    machine.put(b"$X\nG21G90G94\n$J=G91X0.1F1000\n")
    said = []
    for _ in range(300):
        said += machine.turns()
        if len(answers(said)) == 3:
            break
    assert answers(said) == ["ok"] * 3, said
    machine.settle()


def check_noise_is_answered_line_by_line(seed):
    """Any bytes without real-time ones among them: an answer a line, no exception; any bytes: a reset always helps."""
    random = Random(seed)
    machine = Machine().ready()
    quiet = bytes([byte for byte in random.bytes(300) if byte not in (0x3F, 0x21, 0x7E, 0x18) and byte < 0x80])
    for byte in b"\rMm$":  # pauses and settings apart
        quiet = quiet.replace(bytes((byte,)), b"")
    quiet = quiet[:110] + b"\n"
    machine.put(quiet)
    said = []
    for _ in range(40):
        said += machine.turns()
    assert len(answers(said)) == quiet.count(b"\n")
    machine.put(random.bytes(400))
    machine.turns(10)
    recover(machine)


def check_mutated_programmes(seed):
    """Lines good and bad: one answer a line, no motion from a rejected line, and a reset brings everything back."""
    random = Random(seed)
    machine = Machine().ready()
    for _ in range(12):
        line = mutated(random)
        if b"M" in line.upper() and (b"0" in line or b"6" in line or b"1" in line) or b"P" in line.upper() or b"38" in line:
            continue  # pauses wait for the operator, dwells and probing may last
        before = machine.controller.queue.target[:]
        machine.put(line + b"\n")
        said = []
        for _ in range(400):
            said += machine.turns()
            if answers(said):
                break
        if not answers(said) and machine.controller.state == "run":  # it waits for a slow motion
            recover(machine)
            continue
        assert len(answers(said)) == 1, (line, said)
        if answers(said)[0] != "ok" and "error:15" not in said:
            assert machine.controller.queue.target == before, line
        number = answers(said)[0][6:]
        assert not number or errors.text(int(number)) != "error " + number
        if random.between(0, 3) == 0 or machine.controller.alarm:
            recover(machine)
    recover(machine)

"""M6 with a place of its own and a tool sensor, over the grbl link, to the step."""

from router import BOARD, Machine, World, home

_LENGTHS = (("first", -14000, -6000), ("second", -14000, -6000))
CASES = {"check_the_length_is_found_to_the_step": _LENGTHS, "check_where_each_way_pauses_and_what_it_measures": _LENGTHS}
RUNS = {"check_the_length_is_found_to_the_step": 4, "check_where_each_way_pauses_and_what_it_measures": 2}
NOT_QUICK = ("check_the_length_is_found_to_the_step", "check_where_each_way_pauses_and_what_it_measures", "check_reset_and_hold_amid")
CHANGE = {"at": [10, 20], "sensor": [250, 150], "distance_mm": 40, "seek_mm_min": 600, "locate_mm_min": 25}
STEPS_MM = (320, 320, 400)


class Bench(World):
    """The sensor stands at X 250, Y 150 only; it touches at `floor` there."""

    def input(self, tick, name):
        if name == "probe":
            near = abs(self.place[0] - 250 * 320) < 2000 and abs(self.place[1] - 150 * 320) < 2000
            return 0 if near and self.floor is not None and self.place[2] <= self.floor else 1
        return World.input(self, tick, name)


def machine(floor, **changes):
    made = Machine(Bench(), tool_change=CHANGE, **changes)
    home(made)
    made.world.floor = floor
    return made


def change(made, tool, floor=None):
    """Send M6, wait for the pause, put the tool in, go on. The lines said."""
    made.put("M6 T%d\n" % tool)
    said = []
    for _ in range(20_000):
        made.app.cycle()
        said += made.said()
        if "[MSG:Tool change: T%d, ~ to continue]" % tool in said and made.status()["state"] == "Hold:0":
            break
    place = made.controller.position()
    assert place == [3200, 6400, 0] and made.world.tool == 0, place
    if floor is not None:
        made.world.floor = floor
    made.put(b"~")
    for _ in range(80_000):
        made.app.cycle()
        said += made.said()
        if [line for line in said if line == "ok" or line[:5] in ("error", "ALARM")]:
            break
    made.settle()
    return said


def tool_length(made):
    """The tool length offset in steps."""
    text = [line for line in made.ask("$#") if line.startswith("[TLO:")][0]
    return round(float(text[5:-1]) * STEPS_MM[2])


def check_the_length_is_found_to_the_step(first, second):
    made = machine(first)
    zero = made.world.place[2]
    made.do("G0 X30 Y40 Z-5")
    assert change(made, 1)[-1] == "ok"
    assert made.controller.position() == [9600, 12800, 0] and tool_length(made) == 0
    assert change(made, 2, second)[-1] == "ok"
    assert made.controller.position() == [9600, 12800, 0]
    assert abs(tool_length(made) - (second - first)) <= 1, (tool_length(made), second - first)
    made.do("G0 Z-20")
    made.settle()
    assert abs(made.world.place[2] - zero - (-8000 + second - first)) <= 1
    assert change(made, 1, first)[-1] == "ok"
    assert abs(tool_length(made)) <= 1


def check_spindle_and_coolant_come_back():
    made = machine(-9000, spindle={"max_rpm": 24000, "min_rpm": 0})
    made.do("M3 S1000 M8")
    assert made.world.tool == 1
    assert change(made, 3)[-1] == "ok"
    assert made.world.tool == 1 and made.world.outputs["flood"] == 1 and made.status()["state"] == "Idle"


def check_no_sensor_is_an_alarm():
    made = machine(None)
    said = change(made, 1)
    assert "ALARM:5" in said, said
    made.settle()
    assert made.status()["state"] == "Alarm" and made.world.tool == 0
    assert made.controller.position()[2] == -16000 and tool_length_after_unlock(made) == 0


def tool_length_after_unlock(made):
    made.said()
    made.do("$X")
    return tool_length(made)


def check_what_is_refused():
    made = Machine(Bench(), tool_change=CHANGE).ready()
    assert made.ask("M6 T1") == ["error:107"], "before homing the tools' places are not known"
    made = machine(-9000)
    assert made.ask("M6 T1 G0 X5") == ["error:31"]
    assert made.controller.position() == [0, 0, 0]


def check_a_board_without_it_pauses_where_it_stands():
    made = home(Machine())
    made.do("G0 X30 Y40 Z-5")
    made.put("M6 T4\n")
    made.cycles(1000)
    assert made.status()["state"] == "Hold:0" and made.controller.position() == [9600, 12800, -2000]
    assert BOARD.get("tool_change") is None


def wait(made, ends):
    """Cycle until `ends` is true of the lines read. All of it."""
    said = []
    for _ in range(200_000):
        made.app.cycle()
        said += made.said()
        if ends(said):
            return said
    raise AssertionError(said)


def answered(said):
    return [line for line in said if line == "ok" or line[:5] in ("error", "ALARM")]


def pause(made, text):
    """Waits for a pause that says `text`, and its stand."""
    wait(made, lambda said: text in said)
    wait(made, lambda said: made.controller.state == "hold" and made.controller.machine.stood)


PLATE = "[MSG:Pause: ~ to continue]"
IN = "[MSG:Tool change: T%d, ~ to continue]"
PAUSES_AT = {0: [9600, 12800, -2000], 1: [9600, 12800, 0], 2: [80000, 48000, 0], 3: [3200, 6400, 0]}


class Plate(Bench):
    """A touch plate wherever the tool is; a sensor as ever."""

    def input(self, tick, name):
        if name == "probe" and self.floor is not None:
            return 0 if self.place[2] <= self.floor else 1
        return Bench.input(self, tick, name)


def ready(way, floor=-9000, **changes):
    made = Machine(Plate() if way == 1 else Bench(), tool_change=CHANGE, **changes)
    home(made)
    made.world.floor = floor
    made.do("$341=%d" % way, "G0 X30 Y40 Z-5")
    made.settle()
    return made


def check_where_each_way_pauses_and_what_it_measures(first, second):
    """The tool off at the pause. 1 pauses again, for the plate to be taken away, before the spindle turns."""
    for way in (0, 1, 2, 3):
        made = ready(way)
        zero = made.world.place[2] + 2000
        for tool, floor in (1, first), (2, second):
            made.do("M3 S1000 M8")
            made.put("M6 T%d\n" % tool)
            pause(made, IN % tool)
            assert made.controller.position() == PAUSES_AT[way], way
            assert made.world.tool == made.world.outputs["flood"] == (way == 0), way
            made.world.floor = floor
            made.put(b"~")
            if way == 1:
                pause(made, PLATE)
                assert made.world.tool == 0 and made.controller.position() == PAUSES_AT[1]
                made.put(b"~")
            assert answered(wait(made, answered)) == ["ok"]
            made.settle()
            assert made.controller.position() == [9600, 12800, 0 if way else -2000] and made.world.tool == 1
            assert made.world.outputs["flood"] == 1
            made.said()
        if way:
            assert abs(tool_length(made) - (second - first)) <= 1, (way, tool_length(made))
            made.do("G0 Z-20")
            made.settle()
            assert abs(made.world.place[2] - zero - (-8000 + second - first)) <= 1
        else:
            assert tool_length(made) == 0


def check_way_4_does_nothing():
    """As grblHAL's: M6 is read over, what else its line says is done, and no axis need have homed."""
    made = Machine(Bench(), tool_change=CHANGE).ready()
    made.do("$341=4", "M6 T1", "M6 T2 M3 S1000 M8", "G91", "G1 X1 F900 M6 T3")
    made.settle()
    assert made.world.tool == 1 and made.world.outputs["flood"] == 1 and made.controller.state == "idle"


def check_its_line_does_the_rest_too():
    """A dwell and coolant behind the change; a motion is refused in 1 to 3 only."""
    made = ready(3)
    made.put("M6 T1 M8 G4 P0.5\n")
    pause(made, IN % 1)
    made.put(b"~")
    wait(made, lambda said: made.controller.position() == [9600, 12800, 0] and made.world.outputs["flood"] == 1)
    begun = made.port.now
    assert answered(wait(made, answered)) == ["ok"] and made.port.now - begun > 4_000_000, "12 500 ticks a millisecond"
    for way, error in (0, None), (1, "error:31"), (2, "error:31"), (3, "error:31"):
        made.do("$341=%d" % way)
        if error:
            assert made.ask("M6 T4 G0 X5") == [error]


def check_settings():
    made = machine(-9000)
    said = made.ask("$$")
    assert [line for line in said if line[:3] == "$34"] == ["$341=3", "$342=40.000", "$343=25.000", "$344=600.000"]
    for line in ("$341=5", "$342=0.9", "$342=1001", "$343=0", "$344=10001"):
        assert answered(made.ask(line))[0][:5] == "error", line
    assert made.ask("$341=-1") == ["error:4"]
    made = Machine().ready()
    assert made.ask("$341=3") == ["error:3"] and not [line for line in made.ask("$$") if line[:3] == "$34"]


def check_beside_settings_of_other_keys():
    """Parking and backlash have settings of their own; none loses those of the other."""
    for key, data, number in ("backlash", {"x": 50}, 160), ("parking", {"target_mm": -2}, 58):
        made = Machine(Bench(), tool_change=CHANGE, **{key: data}).ready()
        for name in (number, 341, 344):
            assert [line for line in made.ask("$$") if line.startswith("$%d=" % name)], (key, name)
        home(made)
        made.do("$341=4", "M6 T1")


def check_distance_and_speeds_are_the_settings():
    """$342 bounds the probe from the top, the travel does, too; down at $344, up at $343."""
    for way in (1, 2, 3):
        made = ready(way, None)
        made.do("$342=7")
        made.put("M6 T1\n")
        pause(made, IN % 1)
        made.put(b"~")
        assert "ALARM:5" in wait(made, lambda said: [line for line in said if line[:5] == "error"])
        made.settle()
        assert made.controller.position()[2] == -7 * 400 and made.world.tool == 0
        assert tool_length_after_unlock(made) == 0
        made.do("$342=1000", "G0 Z-5")
        made.settle()
        made.put("M6 T1\n")
        pause(made, IN % 1)
        made.put(b"~")
        assert "ALARM:5" in wait(made, lambda said: [line for line in said if line[:5] == "error"])
        assert made.controller.position()[2] == -80 * 400
    made = ready(2)
    made.do("$343=60", "$344=1200")
    made.world.path = []
    made.put("M6 T1\n")
    pause(made, IN % 1)
    del made.world.path[:]
    made.put(b"~")
    assert answered(wait(made, answered)) == ["ok"]
    ticks = [row[0] for row in made.world.path]
    steps = [row[3] for row in made.world.path]
    down = [ticks[n + 1] - ticks[n] for n in range(len(steps) - 1) if steps[n + 1] < steps[n]]
    lowest = steps.index(min(steps))
    up = [ticks[n + 1] - ticks[n] for n in range(lowest + 1, lowest + 8)]
    assert min(down) == 12_500_000 * 60 // (1200 * 400), min(down)
    assert abs(min(up) - 12_500_000 * 60 // (60 * 400)) <= 1, up


def check_reset_and_hold_amid():
    """At each pause and in each motion of a change a hold stands until ~, and a reset ends it: no motion, no tool, the offset as it was."""
    for way in (1, 2, 3):
        amid = 0
        for after in (20, 100, 400, 900, 1300, 1700, 2500, 3500):
            made = ready(way, spindle={"max_rpm": 24000, "min_rpm": 0})
            made.do("M3 S1000")
            made.put("M6 T1\n")
            for _ in range(after):
                made.app.cycle()
                if made.controller.state == "hold" and made.controller.machine.stood:
                    made.put(b"~")
            said = made.said()
            made.put(b"!")
            said += made.cycles(300)
            if "ok" in said:
                break  # it was over
            amid += 1
            assert made.controller.state == "hold", made.controller.state
            place = made.world.place[:]
            made.cycles(500)
            assert made.world.place == place and made.world.tool == 0
            made.put(b"\x18")
            made.cycles(500)
            assert made.world.place == place and made.world.tool == 0 and made.controller.state in ("idle", "alarm")
            made.said()
            made.put("$X\n")
            wait(made, answered)
            assert tool_length(made) == 0
            made.do("G53 G0 Z-1")
            made.settle()
            assert made.controller.position()[2] == -400, (way, after)
        assert amid >= 5, (way, amid)


def check_a_hold_amid_changes_nothing():
    for way in (1, 2, 3):
        made = ready(way)
        made.put("M6 T1\n")
        said = []
        for cycle in range(60_000):
            if cycle % 700 == 300:
                made.put(b"!")
            if cycle % 700 == 600 or made.controller.state == "hold" and made.controller.machine.stood and cycle % 700 < 300:
                made.put(b"~")
            made.app.cycle()
            said += made.said()
            if answered(said):
                break
        assert answered(said) == ["ok"], said
        made.put(b"~")
        made.settle()
        assert made.controller.position() == [9600, 12800, 0] and tool_length(made) == 0

"""M6 with a place of its own and a tool sensor, over the grbl link, to the step."""

from router import BOARD, Machine, World, home

CASES = {"check_the_length_is_found_to_the_step": (("first", -14000, -6000), ("second", -14000, -6000))}
RUNS = {"check_the_length_is_found_to_the_step": 4}
NOT_QUICK = ("check_the_length_is_found_to_the_step",)
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
    assert made.ask("M6 T1") == ["error:107"], "where the places are is not known before homing"
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

"""The page and pulse files: the board plays the stored file, forward, backward and code by code; a jog ends; teach-in makes the same steps."""

from draws import Random
from passo import errors
from passo.options.step_program.errors import RETURN_OR_CONTINUE
from passo.protocols.pulses.errors import NO_CODE, NUMBER_MISSING
from passo.records import TICKS_PER_MS
from pulses_desk import PulsesDesk

MM = 80  # steps
FILE = "[+2000(" + "A" * 90 + "\n" + "G" * 40 + ")*200" + "D" * 30 + "]"
END = [130, 10, 0]
CASES = {"check_a_hold_before_the_stand_is_taken_off": (("refusals", 0, 3),), "check_teach_in_makes_the_same_steps": (("seed", "seed"),)}
RUNS = {"check_teach_in_makes_the_same_steps": 3}


def loaded(text=FILE, **config):
    desk = PulsesDesk(**config)
    desk.store.put_job("a.txt", text)
    return desk


def check_a_file_is_played_and_played_back():
    desk = loaded()
    assert desk.order("run", name="a.txt") == 0
    desk.until(lambda state: state["wait"] > 0.05)
    assert desk.machine.state["state"] == "Run"
    job = desk.job()
    assert job["how"] == "done" and job["done"] == job["lines"] == 166 and desk.place() == END, job
    forward = desk.board.picture()
    assert desk.order("play", what="back") == 0
    desk.until(lambda state: state["job"]["how"] == "run")
    job = desk.job()
    assert job["how"] == "start" and desk.place() == [0, 0, 0], job
    back = [row[:3] for row in desk.board.picture()[len(forward) :]]
    assert back == [row[:3] for row in forward[-2::-1]] + [(0, 0, 0)]
    desk.settle()
    assert desk.order("run", name="a.txt", passes=3) == 0
    assert desk.job()["pass"] == 3 and desk.place() == [3 * part for part in END]


def check_no_file_commands_the_machine():
    """A control command amid a file would be carried out as it comes, and move, unlock or set the machine: no such file is sent."""
    for command in ("{home}", "{unlock}", "{jog x 100}", "{$100=5}", "{", "{end}{run}", "{link}"):
        for text in (command + FILE, FILE[:20] + command + FILE[20:], FILE + "\n" + command):
            desk = loaded(text)
            before = desk.place()
            assert desk.order("run", name="a.txt") == NO_CODE, text
            desk.settle()
            assert desk.place() == before and desk.machine.state["state"] == "Idle"


def check_a_pause_moves_by_hand_and_the_way_back():
    desk = loaded("[+200" + FILE[6:])
    assert desk.order("run", name="a.txt") == 0
    desk.until(lambda state: state["job"]["how"] == "run" and state["job"]["done"] > 40)
    assert desk.order("hold") == 0
    desk.until(lambda state: state["state"] == "Hold")
    left = desk.place()
    desk.hold_jog(1, 300, way={"z": 1})
    desk.order("release")
    desk.settle()
    assert desk.place()[2] > 0 and desk.machine.state["manual"] == desk.place()[2]
    assert desk.order("step", by={"y": -1}, speed=1) == 0
    desk.settle()
    assert desk.place()[1] == left[1] - MM
    assert desk.order("play", what="run") == 0
    desk.run_ms(100)
    assert desk.machine.log()[-1] == RETURN_OR_CONTINUE
    assert desk.order("play", what="return") == 0
    assert desk.job()["how"] == "done" and desk.place() == END


def check_code_by_code():
    desk = loaded("[A+600C(G)]")
    assert desk.order("run", name="a.txt", single=True) == 0
    desk.settle()
    assert desk.place() == [0, 0, 0] and desk.machine.state["job"]["how"] == "run"
    places = []
    for what in ("step",) * 8 + ("step_back",) * 3:
        assert desk.order("play", what=what) == 0
        desk.settle()
        places.append((desk.machine.state["job"]["done"], desk.place()))
    assert places[1] == (2, [1, 0, 0]) and places[3] == (4, [1, 1, 0]), places
    assert places[-1][1] == [1, 1, 0] and places[-1][0] < 8, places


def check_what_is_wrong_is_named():
    desk = loaded("AA\nC*D")
    for check in (True, False):
        assert desk.order("run", name="a.txt", check=check) == 0
        job = desk.job()
        assert (job["how"], job["error"], job["row"], job["column"]) == ("failed", NUMBER_MISSING, 2, 2), job
        desk.settle()
    assert desk.place() == [0, 0, 0]
    desk.store.put_job("a.txt", "AA" * 300 + "?" + "A" * 300)
    assert desk.order("run", name="a.txt") == 0
    job = desk.job()
    assert (job["error"], job["row"], job["column"]) == (NO_CODE, 1, 601), job
    desk.settle()
    assert desk.order("step", by={"x": 1}, speed=1) == 0
    desk.settle()
    assert desk.place() == [MM, 0, 0], "an answer was lost"


def check_a_file_that_the_board_cannot_keep_is_streamed():
    text = "[" + "ACBD" * 600 + "A" * 9 + "]"
    desk = loaded(text, cells=1024)
    assert desk.order("run", name="a.txt", check=True) == 0
    assert desk.job()["how"] == "done" and desk.place() == [0, 0, 0]
    desk.settle()
    assert desk.order("run", name="a.txt", passes=2) == 0
    job = desk.job()
    assert job["how"] == "done" and desk.place() == [18, 0, 0], job
    desk.store.put_job("a.txt", text + "?")
    desk.settle()
    assert desk.order("run", name="a.txt", check=True) == 0
    assert desk.job()["error"] == NO_CODE


def check_a_jog_ends():
    """Released, or its lease lapsed: at the next step, and nothing is left that holds the machine."""
    desk = loaded()
    desk.hold_jog(1, 300, way={"x": 1})
    at = desk.board.port.now
    desk.order("release")
    desk.settle()
    last = desk.board.world.path[-1][0]
    assert (last - at) / TICKS_PER_MS < 100, (last - at) / TICKS_PER_MS
    assert desk.machine.state["state"] == "Idle", desk.machine.state
    at = desk.board.port.now
    assert desk.order("jog", lease=2, beat=desk.beats, way={"y": 1}, speed=1) == 0
    desk.settle()
    took = (desk.board.world.path[-1][0] - at) / TICKS_PER_MS
    assert 150 < took <= 250, took
    assert desk.machine.state["state"] == "Idle"
    assert desk.order("keep", lease=2, beat=desk.beats) == errors.LEASE


def check_a_hold_before_the_stand_is_taken_off(refusals):
    """A board says that it holds while the steps ahead are still played, and refuses the jog of no steps that takes the hold off."""
    desk = loaded()
    refused = []
    feed = desk.machine.wire.feed
    jog = b"{jog x 0}"

    def put(data):
        if jog in bytes(data) and len(refused) < refusals:
            refused.append(desk.now_ms())
            feed(b"error:8\n", desk.now_ms())
        else:
            desk.line.incoming += data

    desk.machine.wire._write = put
    desk.hold_jog(1, 300, way={"x": 1})
    desk.order("release")
    desk.settle()
    assert len(refused) == refusals and desk.machine.state["state"] == "Idle", desk.machine.state
    assert not desk.machine.log()
    assert desk.order("step", by={"y": 1}, speed=1) == 0
    desk.order("hold")  # by somebody: it stays
    desk.run_ms(500)
    assert desk.machine.state["state"] == "Hold"


def check_stop_and_switches():
    desk = loaded("[" + "A" * 3000 + "]")
    assert desk.order("output", name="tool_on") == 0
    desk.settle()
    assert desk.machine.state["tool"] and desk.machine.state["port"] & 1
    assert desk.order("output", name="tool_off") == 0
    desk.settle()
    assert desk.order("pace", speed=300) == 0
    desk.settle()
    assert desk.machine.state["feed"] == 300
    assert desk.order("run", name="a.txt") == 0
    desk.until(lambda state: state["job"]["how"] == "run" and state["job"]["done"] > 20)
    assert desk.order("pace", speed=2000) == 0
    desk.run_ms(200)
    assert desk.machine.state["feed"] > 1990
    assert desk.api.answer_order({"do": "stop"}, False)["error"] == 0
    assert desk.job()["error"] == errors.STOPPED
    stood = desk.place()
    desk.run_ms(300)
    assert desk.place() == stood and 20 < stood[0] < 3000
    for fields in ({"do": "pace", "speed": 0}, {"do": "pace"}, {"do": "play", "what": "away"}, {"do": "output", "name": "tool_maybe"}):
        assert desk.api.answer_order(fields, True)["error"], fields
    assert desk.api.answer_order({"do": "zero", "axes": "x"}, True)["error"] == errors.UNKNOWN_COMMAND
    assert desk.api.answer_order({"do": "pace", "speed": 100}, False)["error"] == errors.NO_SESSION


def check_teach_in_makes_the_same_steps(seed):
    random = Random(seed)
    desk = loaded()
    assert desk.order("teach", what="begin") == 0
    start = len(desk.board.world.path)
    for number in range(6):
        axis = "xyz"[random.between(0, 2)]
        sign = -1 if random.between(0, 1) else 1
        if random.between(0, 1):
            desk.hold_jog(number + 1, 60 * random.between(1, 5), way={axis: sign})
            desk.order("release")
        else:
            assert desk.order("step", by={axis: sign * random.between(1, 200) / 100}, speed=1) == 0
        desk.settle()
        if number == 2:
            desk.order("output", name="tool_on")
            desk.settle()
    taught = desk.board.picture()[start:]
    end = desk.place()
    assert desk.order("teach", what="save", name="taught.txt") == 0
    desk.order("output", name="tool_off")
    desk.settle()
    begin = len(desk.board.world.path)
    assert desk.order("run", name="taught.txt") == 0
    assert desk.job()["how"] == "done"
    replayed = desk.board.picture()[begin:]
    assert [[row[axis] - end[axis] for axis in range(3)] + [row[3]] for row in replayed] == [list(row) for row in taught]

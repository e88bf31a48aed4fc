"""LPTControl's language on the whole firmware: every code, every command, and everything an operator may do to a run."""

from draws import Random
from lpt import Lpt
from passo import commands
from passo.motion.integers import isqrt
from passo.options.step_program.commands import STEPS_ABORT, STEPS_CLOSE, STEPS_ITEMS, STEP_PROGRAM_ADD
from passo.protocols.pulses.codes import CODES
from passo.protocols.pulses.protocol import Pulses, frame
from passo.protocols.pulses.report import port_byte

CASES = {
    "check_interrupted_and_returned": (("seed", "seed"),),
    "check_reversed_anywhere": (("seed", "seed"),),
    "check_live_speed": (("seed", "seed"),),
    "check_any_pieces": (("seed", "seed"),),
    "check_noise": (("data", "bytes", 60),),
}
RUNS = {"check_interrupted_and_returned": 3, "check_reversed_anywhere": 2, "check_live_speed": 4, "check_any_pieces": 10}

# As the document has it.
TABLE = """A X+ B X- C Y+ D Y- E Z+ F Z- G X+Y+ H X+Y- I X-Y+ J X-Y- K X+Z+ L X+Z- M X-Z+ N X-Z- O Y+Z+ P Y+Z- Q Y-Z+
R Y-Z- S X+Y+Z+ T X+Y+Z- U X+Y-Z+ V X+Y-Z- W X-Y+Z+ X X-Y+Z- Y X-Y-Z+ Z X-Y-Z-""".split()
STEP_NM = 12_500
# About 1300 commands: all codes, three speeds, the tool, waits.
PICTURE = "[+1000(" + "A" * 90 + "*7" + "GHIJ" * 40 + ")+2200" + "KLMNOPQR" * 30 + "($STUVWXYZ" * 20 + "@)"
PICTURE += "CD" * 150 + "*30(+600" + "C" * 40 + "BD" * 60 + ")]"
NOT_QUICK = ("check_interrupted_and_returned",)


def codes_of(text):
    """[(moves)] of the steps of a file, by the document's table."""
    steps = {}
    for letter, axes in zip(TABLE[::2], TABLE[1::2]):
        moves = [0, 0, 0]
        for place in range(0, len(axes), 2):
            moves["XYZ".find(axes[place])] = 1 if axes[place + 1] == "+" else -1
        steps[letter] = moves
    found = []
    tool = 0
    for byte in text:
        if byte in "()":
            tool = 1 if byte == "(" else 0
        elif byte in steps:
            found.append((steps[byte], tool))
    return found


def places_of(steps, start=(0, 0, 0)):
    at = list(start)
    places = []
    for moves, tool in steps:
        at = [place + by for place, by in zip(at, moves)]
        places.append((at[0], at[1], at[2], tool))
    return places


def opposite(steps):
    return [([-by for by in moves], tool) for moves, tool in steps][::-1]


WHOLE = places_of(codes_of(PICTURE))


def check_every_code_moves_its_axes():
    machine = Lpt()
    for letter, axes in zip(TABLE[::2], TABLE[1::2]):
        before = machine.world.place[:]
        machine.play(letter * 3)
        moved = [to - at for at, to in zip(before, machine.world.place)]
        assert moved == [3 * by for by in codes_of(letter)[0][0]], letter
    assert len(machine.world.path) == 78


def image(text, config):
    """The port's byte for each command of a file that shows on it."""
    shown = []
    drives = tool = 0
    for letter in text:
        step = 0
        if letter in "[]":
            drives = letter == "["
        elif letter in "()":
            tool = letter == "("
        else:
            step = CODES[ord(letter) - 65]
        shown.append(port_byte(step, tool, drives, config))
    return shown


def check_port_bytes():
    """The document's test vector, and with bits moved, inverted and left out."""
    text = "[AABXP(QRMYZ)]"
    vector = bytes((0x80, 0x86, 0x86, 0x84, 0xDC, 0xD8, 0x81, 0xF1, 0xD1, 0xE5, 0xF5, 0xD5, 0x80, 0x00))
    assert bytes(image(text, {"port_bits": "76543210", "port_invert": 0})) == vector
    inverted = image(text, {"port_bits": "76543210", "port_invert": 0x81})
    assert inverted == [byte ^ 0x81 for byte in vector]
    moved = image(text, {"port_bits": "01234567", "port_invert": 0})
    for byte, other in zip(vector, moved):
        assert [byte >> bit & 1 for bit in range(8)] == [other >> 7 - bit & 1 for bit in range(8)]
    without_tool = image(text, {"port_bits": "7654321-", "port_invert": 0})
    assert without_tool == [byte & 0xFE for byte in vector]
    both = image(text, {"port_bits": "7-543210", "port_invert": 0x60})
    assert both == [(byte ^ 0x60) & 0xBF for byte in vector]


def check_port_byte_live():
    """The same images while the firmware really makes those steps."""
    machine = Lpt(default_mm_min=1)  # 0.75 s a step: long enough to look
    machine.load("[AXQ(Z)]")
    expected = {0x86: 1, 0xDC: 1, 0xF0: 1, 0xD5: 1}
    machine.tell("run")
    seen = []
    while machine.steps.may_change():
        seen.append(int(machine.status()["port"], 16))
    for byte in expected:
        assert byte in seen or byte | 0x80 in seen, (byte, seen)
    assert machine.status()["port"] == "00"


def check_periods():
    """Steps, diagonals of two axes and of three at the same speed along the path, in whole microseconds."""
    machine = Lpt()
    for letter, axes in (("A", 1), ("G", 2), ("S", 3)):
        machine.world.path = []
        machine.play("[+1000" + letter * 60)
        ticks = [row[0] for row in machine.world.path][2:]  # the first intervals lend the directions their time
        period_us = (60 * isqrt(axes * STEP_NM * STEP_NM) + 500) // 1000
        assert period_us == (750, 1061, 1299)[axes - 1]
        for number in range(len(ticks)):
            assert abs(2 * (ticks[number] - ticks[0]) - 25 * period_us * number) <= 2
        count = len(ticks) - 1 & ~1
        assert 2 * (ticks[count] - ticks[0]) == 25 * period_us * count


def check_automatic_speeds():
    """The document's test of the automatic mode."""
    machine = Lpt()
    machine.load("+1000*10000$*500@*500")
    machine.tell("run")
    machine.run_ms(100)
    status = machine.status()
    assert status["speed"] == "1000.0" and 9700 < int(status["wait"]) <= 9980 and status["state"] == "run"
    machine.run_ms(5000)
    assert 4700 < int(machine.status()["wait"]) < 4980
    machine.run_ms(5200)
    assert machine.status()["speed"] == "2403.8"  # 312 µs a step
    machine.run_ms(500)
    assert machine.status()["speed"] == "1200.0"
    machine.until("end")
    machine.play("+5000A")
    assert machine.status()["speed"] == "2403.8"  # the fastest there is
    machine.play("+333A")
    assert machine.status()["speed"] == "333.0"  # 2252 µs


def check_picture_stored_and_streamed():
    stored = Lpt()
    stored.play(PICTURE)
    assert stored.picture() == WHOLE
    assert stored.app.controller.machine.log.entries == []
    streamed = Lpt(cells=512)
    assert streamed.send(PICTURE, "stream").startswith("ok ")
    streamed.until("end")
    assert streamed.picture() == WHOLE
    gaps = [
        [after[0] - before[0] for before, after in zip(machine.world.path, machine.world.path[1:])]
        for machine in (stored, streamed)
    ]
    assert gaps[0] == gaps[1]  # to the tick


def check_interrupted_and_returned(seed):
    """200 times, somewhere: a pause, a few moves by hand, the automatic return. The picture is the same, step by step."""
    random = Random(seed)
    machine = Lpt()
    machine.load(PICTURE)
    kept = []
    interruptions = 0
    while interruptions < 200:
        machine.tell("run")
        while machine.steps.may_change() and interruptions < 200:
            machine.run_ms(random.between(0, 12))
            if not machine.steps.may_change():
                break
            machine.tell("pause")
            machine.settle()
            if machine.status()["state"] != "hold":
                break
            interruptions += 1
            path = machine.world.path
            kept += path
            machine.world.path = path = []
            jogged = 0
            for _ in range(random.between(1, 3)):
                by, up = random.between(-6, 6), random.between(0, 2)
                jogged += abs(by) + up
                machine.tell("jog", random.choice("xy"), by, "z", up)
                if random.between(0, 1):
                    machine.settle()
            machine.settle()
            made = len(path)
            assert made == jogged and all([row[4] == 0 for row in path])
            assert machine.status()["state"] == "hold" and int(machine.status()["manual"]) == made
            if random.between(0, 4) == 0 and made:
                assert machine.ask("run") == "error:127"
            machine.tell("return")
            while len(path) < 2 * made:
                machine.cycle()
            back = [row[1:4] for row in path[: 2 * made]]
            assert back[:made][::-1][1:] == back[made : 2 * made - 1]  # the way it came
            machine.world.path = path[2 * made :]
        machine.settle()
        machine.cycle()
        if machine.status()["state"] == "idle":
            kept += machine.world.path
            assert [row[1:] for row in kept] == WHOLE, len(kept)
            kept = []
            machine.world.path = []
            machine.world.place = [0, 0, 0]
            machine.take()
    if kept or machine.world.path:
        machine.until("end")
        assert [row[1:] for row in kept + machine.world.path] == WHOLE


def check_reversed_anywhere(seed):
    """Back from random points over the same steps to the start, and forward again."""
    random = Random(seed)
    machine = Lpt()
    machine.load(PICTURE)
    for _ in range(6):
        machine.world.path = []
        machine.tell("run")
        machine.run_ms(random.between(30, 900))
        if random.between(0, 1):
            machine.tell("pause")
            machine.settle()
        machine.tell("back")
        if random.between(0, 1):  # and to and fro
            machine.run_ms(random.between(0, 40))
            machine.tell("run")
            machine.run_ms(random.between(0, 40))
            machine.tell("back")
        machine.until("start")
        assert machine.world.place == [0, 0, 0]
        walk_there_and_back(machine.world.path)
        status = machine.status()
        assert status["at"] == "0" and status["state"] == "idle" and status["going"] == "-"
    machine.world.path = []
    machine.tell("run")
    machine.until("end")
    assert machine.picture() == WHOLE
    machine.world.path = []
    machine.tell("back")  # from the end
    machine.until("start")
    assert machine.picture() == places_of(opposite(codes_of(PICTURE)), WHOLE[-1][:3])


def walk_there_and_back(path):
    """A walk to and fro along the picture, from its start to its start: each step the next one, or the last one back."""
    steps = codes_of(PICTURE)
    possible = {0}  # how many steps of the picture may lie behind: some look alike
    place = (0, 0, 0)
    for row in path:
        made = ([to - was for was, to in zip(place, row[1:4])], row[4])
        undone = ([-by for by in made[0]], row[4])
        ahead = [at + 1 for at in possible if at < len(steps) and steps[at] == made]
        behind = [at - 1 for at in possible if at and steps[at - 1] == undone]
        possible = set(ahead + behind)
        assert possible, row
        place = row[1:4]
    assert 0 in possible


def check_a_hundred_times():
    machine = Lpt()
    machine.play("[(AGCD)IDB*3H", 100)
    once = codes_of("[(AGCD)IDB*3H")
    assert machine.picture() == places_of(once * 100)
    assert len(machine.picture()) == 800
    status = machine.status()
    assert status["pass"] == "100/100"
    assert machine.ask("run", 101) == "error:128" and machine.ask("repeat", 0) == "error:128"
    assert machine.ask("repeat", 100) == "ok"


def check_live_speed(seed):
    """From the command on the wire to another interval on the pins: 20 ms."""
    random = Random(seed)
    machine = Lpt()
    machine.load("A" * 8000 + "+1200" + "A" * 50)
    machine.tell("run")
    before = 1200
    for _ in range(12):
        machine.run_ms(random.between(20, 120))
        speed = random.between(40, 2400)
        if speed * 10 // before == 10:
            continue
        now = machine.port.now
        machine.put(frame("speed", speed))
        machine.run_ms(60)
        period = 25 * ((60 * STEP_NM + speed // 2) // speed)
        ticks = [row[0] for row in machine.world.path]
        changed = [
            at for at, after in zip(ticks, ticks[1:]) if after > now and abs(2 * (after - at) - period) <= 2
        ]
        assert changed and changed[0] - now <= 250_000, (speed, changed[:1], now)
        before = speed
    machine.tell("speed", 2403)
    machine.until("end")
    assert machine.status()["speed"] == "1200.0"  # the file's own, at its place


def check_slow_speed_changes_too():
    """One step in 7.5 s does not keep a new speed waiting."""
    machine = Lpt()
    machine.load("A" * 20)
    machine.tell("speed", 1)
    machine.tell("run")
    machine.run_ms(300)
    assert len(machine.world.path) == 1
    now = machine.port.now
    machine.tell("speed", 1000)
    machine.run_ms(40)
    assert machine.world.path[1][0] - now < 250_000
    machine.until("end")


def check_operator_speed():
    machine = Lpt()
    machine.load("(AA+0BB$C)")
    machine.tell("run")
    machine.until("speed")
    machine.run_ms(500)
    status = machine.status()
    assert status["state"] == "hold" and status["ask"] == "1" and status["at"] == "4"
    assert machine.ask("speed", 0) == "error:105"
    machine.tell("speed", 700)
    machine.until("end")
    ticks = [row[0] for row in machine.world.path]
    assert abs(2 * (ticks[3] - ticks[2]) - 25 * 1071) <= 2 * 500
    machine.tell("step", "back")
    machine.settle()
    machine.tell("step", "back")  # C, and with it what was the speed before $
    machine.settle()
    machine.tell("step", "back")
    machine.settle()
    machine.tell("step", "back")
    machine.settle()
    assert machine.status()["speed"] == "700.2"  # 1071 µs


def check_single_steps():
    machine = Lpt()
    count = machine.load("[+1000A(*20B)C]")
    places = []
    for _ in range(count):
        machine.tell("step")
        machine.settle()
        places.append((machine.status()["at"], tuple(machine.world.place), machine.status()["tool"]))
    assert [int(place[0]) for place in places] == list(range(1, count + 1))
    assert places[2][1] == (1, 0, 0) and places[5][1] == (0, 0, 0) and places[5][2] == "1"
    assert places[7][1] == (0, 1, 0) and places[7][2] == "0"
    assert machine.world.outputs["enable"] == 1  # active low: off at the end
    for number in range(count - 1, -1, -1):
        machine.tell("step", "back")
        machine.settle()
        assert int(machine.status()["at"]) == number
    assert machine.world.place == [0, 0, 0]


def check_drives():
    """They are on where the file, or the operator, has switched them on, and off elsewhere, steps or not."""
    machine = Lpt()
    machine.tell("drives", "on")
    assert machine.world.outputs["enable"] == 0 and machine.status()["port"] == "80"
    machine.tell("drives", "off")
    assert machine.world.outputs["enable"] == 1
    machine.load("[A*40]*40A*40")
    machine.tell("run")
    machine.run_ms(50)
    assert machine.world.outputs["enable"] == 0 and machine.world.place == [1, 0, 0]
    machine.run_ms(45)
    assert machine.world.outputs["enable"] == 1
    machine.run_ms(35)
    assert machine.world.outputs["enable"] == 1 and machine.status()["port"][0] in "01"
    machine.until("end")
    assert machine.world.place == [2, 0, 0]  # the port's pulses are those of the file


def check_no_words_before_the_motors_are_ready():
    """An interrupt that feeds comes at any moment: here as soon as a walk is queued, before the app has looked at the motors."""
    machine = Lpt()
    app = machine.app
    queue = machine.steps._queue
    walk = queue.walk
    early = []

    def interrupted(walker):
        walk(walker)
        made = app.ring.head
        if app.feeder.open:
            app.feeder.fill(app.player.words_played(), 150_000)
        if app.ring.head != made and not app.controller.may_feed():
            early.append(app.ring.head - made)

    queue.walk = interrupted
    machine.load("[A*40]*40A[*40A]")
    machine.tell("run")
    machine.until("end")
    assert machine.world.place == [3, 0, 0] and not early


def enabled_while(machine, *words):
    """The levels of the output enable, active low, that are seen up to the stand."""
    seen = set()
    machine.tell(*words)
    for _ in range(100_000):
        seen.add(machine.world.outputs["enable"])
        machine.cycle()
        if not machine.steps.may_change():
            machine.settle()
            machine.take()
            return seen
    raise AssertionError("it does not end")


def check_drives_that_are_off_stay_off():
    """Without [ in the file, after `drives off`, stored or streamed, forward and backward, through a pause."""
    machine = Lpt()
    machine.load("(A*20)C*20" + "AC" * 20)
    for words in (("run",), ("back",), ("step",)):
        assert enabled_while(machine, *words) == {1}, words
    machine.tell("drives", "on")
    assert enabled_while(machine, "run") == {0}
    machine.tell("drives", "off")
    assert enabled_while(machine, "back") == {1}
    machine.tell("run")
    machine.run_ms(10)
    machine.tell("pause")
    machine.settle()
    assert machine.world.outputs["enable"] == 1
    assert enabled_while(machine, "run") == {1}
    machine.put("AAAA")
    machine.until("end")
    assert machine.world.outputs["enable"] == 1
    machine.tell("run")
    machine.run_ms(10)
    machine.tell("stop")
    assert machine.world.outputs["enable"] == 1


def check_drives_on_the_way_back():
    """On, as they were forward, although the file has ended with them off; off at its start."""
    machine = Lpt()
    machine.play("[+10AAAA]")
    assert machine.world.outputs["enable"] == 1
    places = []
    machine.tell("back")
    while machine.steps.may_change():
        machine.cycle()
        places.append((machine.world.place[0], machine.world.outputs["enable"]))
    assert (4, 0) in places and (1, 0) in places and (3, 1) not in places and (1, 1) not in places
    machine.until("start")
    assert machine.world.place == [0, 0, 0] and machine.world.outputs["enable"] == 1
    machine.tell("step")
    machine.settle()
    assert machine.world.outputs["enable"] == 0
    machine.tell("drives", "off")
    assert enabled_while(machine, "back") == {1}


def check_moves_by_hand_and_the_drives():
    """They switch the drives on, but where the operator has switched them off."""
    machine = Lpt()
    machine.tell("jog", "x", 4)
    machine.settle()
    assert machine.world.outputs["enable"] == 0 and machine.status()["drives"] == "1"
    machine.tell("drives", "off")
    assert machine.ask("jog", "x", 4) == "error:130"
    machine.load("[AAA*500A]")
    machine.tell("run")
    machine.run_ms(100)
    machine.tell("pause")
    machine.settle()
    machine.tell("jog", "y", 5)
    machine.settle()
    machine.tell("drives", "off")
    assert machine.ask("return") == machine.ask("jog", "y", 1) == "error:130"
    machine.tell("drives", "on")
    machine.tell("return")
    machine.until("end")
    assert machine.world.place == [8, 0, 0] and machine.world.outputs["enable"] == 1


def check_where_unpowered_motors_are_nobody_knows():
    machine = Lpt()
    machine.app.controller.machine.homed = True
    machine.play("[AAA]")
    assert machine.app.controller.machine.homed
    machine.play("A")
    assert not machine.app.controller.machine.homed


def check_continue_from_here():
    """The octagon's way: back, deeper by hand, and forward again from there."""
    machine = Lpt()
    machine.load("(AAAACCCC)")
    machine.tell("run")
    machine.until("end")
    machine.tell("back")
    machine.run_ms(22)
    machine.tell("pause")
    machine.settle()
    machine.tell("jog", "z", -5)
    machine.settle()
    machine.tell("continue")
    machine.until("end")
    assert machine.world.place == [4, 4, -5]
    machine.load("AAAA")
    machine.tell("jog", "x", -4)  # before it begins: there is nothing to return to
    machine.settle()
    machine.tell("run")
    machine.until("end")
    assert machine.world.place == [4, 4, -5]


def check_return_interrupted():
    """A pause on the way back, another move, and the return is still exact."""
    machine = Lpt()
    machine.load("A" * 40 + "C" * 40)
    machine.tell("run")
    machine.run_ms(40)
    machine.tell("pause")
    machine.settle()
    machine.tell("jog", "y", -60)
    machine.settle()
    machine.tell("return")
    machine.run_ms(20)
    machine.tell("pause")
    machine.settle()
    assert 0 < int(machine.status()["manual"]) < 60
    machine.tell("jog", "z", 7)
    machine.run_ms(3)
    machine.tell("pause")  # in the middle of the move
    machine.settle()
    machine.tell("return")
    machine.until("end")
    assert machine.world.place == [40, 40, 0]


def check_files_that_are_wrong():
    """One numbered error with line and column; nothing has moved, and nothing of the file is left."""
    machine = Lpt()
    for text, said in (
        ("AA\nB?C", "error:120 line 2 column 2"),
        ("AAb", "error:120 line 1 column 3"),
        ("\r\n\r\n  a", "error:120 line 3 column 3"),
        ("AA*\nB", "error:121 line 1 column 3"),
        ("AA+", "error:121 line 1 column 3"),
        ("(A\n*x", "error:121 line 2 column 1"),
        ("A*3600001A", "error:122 line 1 column 2"),
        ("A\n\n +900001", "error:122 line 3 column 2"),
        ("A" * 900 + "\n*99999999999999", "error:122 line 2 column 1"),
        ("A-5", "error:120 line 1 column 2"),
        ("A\xe9", "error:120 line 1 column 2"),
    ):
        assert machine.send(text.encode("latin-1") if text == "A\xe9" else text, "load") == said, text
        assert machine.ask("run") == "error:125"
        machine.run_ms(1100)
        assert machine.take() == []
    assert machine.world.path == [] and machine.world.tool_changes == []
    assert machine.load("A*3600000+900000+0$@ \t\r\nZ") == 7


def check_files_cut_off():
    machine = Lpt()
    machine.tell("load", 100)
    machine.put("\nAAAA\nCC")
    assert machine.ask("end") == "error:123 line 2 column 3"
    machine.tell("load", 100)
    machine.put("AAAA")
    assert machine.until("error")[-1] == "error:123 line 1 column 5"  # nothing comes any more
    assert machine.ask("run") == "error:125" and machine.world.path == []
    machine.tell("load", 3)
    machine.put("AAAA")
    assert machine.ask("end") == "error:123 line 1 column 5"
    machine.tell("stream", 100)
    machine.put("(AAAA")
    assert machine.until("error")[-1] == "error:123 line 1 column 6"
    machine.run_ms(100)
    assert machine.world.place == [4, 0, 0] and machine.world.tool == 0
    assert machine.status()["state"] == "idle"


def check_a_stream_that_is_wrong():
    """It stops where it is, the tool goes off, and the rest is dropped."""
    machine = Lpt()
    said = machine.send("[(" + "A" * 100 + "#" + "C" * 900, "stream")
    assert said == "error:120 line 1 column 103"
    machine.run_ms(1500)
    assert machine.take() == []
    assert machine.world.tool == 0 and machine.world.place[1] == 0 and 0 <= machine.world.place[0] <= 100
    assert machine.status()["state"] == "idle"
    assert machine.ask("run") == "error:125"
    machine.play("B")


def check_too_long_is_refused():
    machine = Lpt(cells=512)
    said = machine.send("AC" * 300, "load")
    assert said == "error:126"
    assert machine.ask("run") == "error:125"
    assert machine.send("AC" * 2000, "stream") == "ok 4000"
    machine.until("end")
    assert machine.world.place == [2000, 2000, 0]
    assert machine.ask("run") == "error:125"  # its beginning is forgotten
    machine.tell("back")
    machine.until("oldest")
    assert 1500 < machine.world.place[0] < 1900  # as far as the window remembers
    oldest = machine.world.place[:]
    assert machine.status()["state"] == "idle" and machine.ask("run 2") == machine.ask("repeat 2") == "error:125"
    machine.tell("step", "back")
    machine.until("oldest")
    machine.tell("run")
    machine.until("end")
    assert machine.world.place == [2000, 2000, 0]
    machine.tell("back")
    machine.until("oldest")
    assert machine.world.place == oldest
    machine.load("AAAC")  # and another file may come
    machine.tell("run", 2)
    machine.until("end")
    assert machine.world.place == [oldest[0] + 6, oldest[1] + 2, 0]


def check_moved_by_hand_behind_a_forgotten_start():
    """From the oldest step on the rest is played where the machine stands, and soft limits are looked at there."""
    machine = Lpt(cells=512)
    machine.send("AC" * 2000, "stream")
    machine.until("end")
    machine.tell("back")
    machine.until("oldest")
    at = machine.world.place[0]
    machine.tell("jog", "x", 40)
    machine.settle()
    machine.tell("run")
    machine.until("end")
    assert machine.world.place == [2040, 2000, 0] and machine.steps._origin == [40, 0, 0]
    machine.tell("back")
    machine.until("oldest")
    assert machine.world.place[0] == at + 40


def check_a_stream_turned_round_before_its_end():
    """As far as it is remembered; then the rest of it comes as before."""
    machine = Lpt(cells=512)
    machine.tell("stream")
    text = "AC" * 900
    while text:
        machine.put(text[:64])
        text = text[64:]
        machine.run_ms(60)
    machine.run_ms(2000)
    machine.tell("back")
    machine.until("oldest")
    assert machine.status()["state"] == "hold"
    machine.tell("run")
    machine.put("{end}")
    machine.until("end")
    assert machine.world.place == [900, 900, 0] and machine.status()["state"] == "idle"


def check_a_file_that_was_dropped_is_never_played_as_typed():
    """The rest of the file is dropped up to its end, however long the line is quiet before it."""
    machine = Lpt()
    for verb in ("load", "stream"):
        machine.tell(verb, 100)
        machine.put("AAAA#")
        assert machine.until("error")[-1] == "error:120 line 1 column 5"
        machine.run_ms(6000)
        machine.put("A" * 50)
        machine.run_ms(3000)
        place = machine.world.place[:]
        machine.put("C" * 50)
        machine.run_ms(3000)
        assert machine.take() == [] and machine.world.place == place and place[0] <= 4
        assert machine.ask("end") == "error:125"
        machine.run_ms(1100)
        machine.put("Z" if verb == "load" else "A")  # typed
        machine.until("end")
        assert machine.world.place != place
    machine.load("AAA")


def check_typed():
    """Codes without more: played as they come, until the line is quiet."""
    machine = Lpt()
    machine.put("AAA\r\nC")
    machine.until("end")
    assert machine.world.place == [3, 1, 0]
    machine.put("B")
    machine.until("end")
    assert machine.ask("home") == "error:106"
    assert machine.world.place == [2, 1, 0]


def check_stream_pauses():
    machine = Lpt()
    machine.tell("stream")
    machine.put("(" + "A" * 300)
    machine.cycle()
    machine.tell("pause")  # before it has set out
    machine.run_ms(100)
    assert machine.world.path == [] and machine.status()["state"] == "hold"
    machine.tell("run")
    machine.run_ms(60)
    machine.tell("pause")
    machine.settle()
    at = machine.world.place[0]
    assert 0 < at < 300
    machine.tell("jog", "y", 5)
    machine.settle()
    machine.tell("return")
    machine.put("C" * 10)
    machine.tell("end")
    machine.until("end")
    assert machine.world.place == [300, 10, 0]


def check_stop():
    """At once, the tool off; the file is at its start again."""
    machine = Lpt()
    machine.load("[(" + "A" * 1000)
    machine.tell("run")
    machine.run_ms(200)
    now = machine.port.now
    machine.put(frame("stop"))
    machine.cycle()
    path = machine.world.path
    machine.answer()
    assert machine.world.tool == 0 and path[-1][0] <= now + 2 * 100_000
    at = machine.world.place[0]
    status = machine.status()
    assert status["state"] == "idle" and status["at"] == "0" and status["place"] == "%d,0,0" % at
    machine.run_ms(1500)
    machine.tell("run")
    machine.until("end")
    assert machine.world.place == [at + 1000, 0, 0]
    gaps = [after[0] - before[0] for before, after in zip(path, path[1:])]
    assert min(gaps) >= 3900 - 250  # never closer than the drivers want


def check_dry_run():
    machine = Lpt(dry_run=True)
    machine.play("[(AA)BB(C)")
    assert machine.world.tool_changes == [] and len(machine.world.path) == 5


def check_steps_and_passes():
    """A single step at the end of a pass does not set out on the next."""
    machine = Lpt()
    machine.load("AB")
    machine.tell("repeat", 2)
    for at, place in ((1, 1), (0, 0), (1, 1), (2, 0)):
        machine.tell("step")
        machine.settle()
        assert int(machine.status()["at"]) == at and machine.world.place[0] == place
    assert machine.status()["pass"] == "2/2" and machine.status()["state"] == "idle"


def check_return_while_a_speed_is_wanted():
    machine = Lpt()
    machine.load("(AA+0BB)")
    machine.tell("run")
    machine.until("speed")
    machine.tell("tool", "on")
    machine.tell("jog", "z", 9)
    machine.settle()
    machine.tell("return")
    machine.settle()
    machine.run_ms(100)
    assert machine.world.place == [2, 0, 0] and machine.status()["ask"] == "1"
    assert [row[4] for row in machine.world.path] == [1] * 11 + [0] * 9  # the way back with the tool off
    machine.tell("speed", 900)
    machine.until("end")
    assert machine.world.place == [0, 0, 0] and machine.picture()[-1][3] == 1


def check_button_on_the_way_back():
    machine = Lpt()
    machine.load("A" * 100)
    machine.tell("run")
    machine.run_ms(50)
    machine.tell("pause")
    machine.settle()
    machine.tell("jog", "y", 100)
    machine.settle()
    machine.tell("return")
    machine.run_ms(40)
    machine.app.controller.machine.carry_out(commands.HOLD)
    machine.run_ms(60)
    assert machine.status()["state"] == "hold" and 0 < machine.world.place[1] < 100
    machine.app.controller.machine.carry_out(commands.RESUME)
    machine.until("end")
    assert machine.world.place == [100, 0, 0]


def check_button():
    """The input that holds and resumes the motion of other languages does it here, too."""
    machine = Lpt()
    machine.load("A" * 400)
    machine.tell("run")
    machine.run_ms(50)
    machine.app.controller.machine.carry_out(commands.HOLD)
    machine.run_ms(60)
    at = machine.world.place[0]
    machine.run_ms(60)
    assert machine.world.place[0] == at and machine.status()["state"] == "hold"
    machine.app.controller.machine.carry_out(commands.RESUME)
    machine.until("end")
    assert machine.world.place == [400, 0, 0]


def check_control_commands_that_are_wrong():
    machine = Lpt()
    for words in (
        ("fly",), ("run", 1, 2), ("speed",), ("speed", "fast"), ("jog",), ("jog", "x"), ("jog", "a", 5), ("tool",),
        ("step", "on"), ("x" * 100,), (), ("repeat",), ("load", "all"), ("jog", "x", "5.5"), ("jog", "x", "-"),
    ):  # fmt: skip
        assert machine.ask(*words) == "error:124", words
    for words in (("run",), ("back",), ("step",), ("return",), ("continue",), ("end",)):
        assert machine.ask(*words) == "error:125", words
    machine.put("{spee")
    assert machine.until("error")[-1] == "error:124"
    machine.load("AAAA")
    assert machine.ask("jog", "x", 5) == "ok"
    machine.settle()
    assert machine.world.place == [5, 0, 0]
    assert machine.ask("return") == "error:125"


def check_travel():
    """If soft limits are on, a file that would leave the travel does not begin."""
    machine = Lpt()
    controller = machine.app.controller
    controller.machine.homed = True
    controller.machine.settings.value = lambda number: 1
    machine.load("[AAAB]")
    assert machine.ask("run") == "ok"
    machine.until("end")
    machine.load("D" * 5)
    assert machine.ask("run") == "error:104"
    machine.load("A" * 330)
    assert machine.ask("run", 100) == "error:104"
    assert machine.ask("jog", "y", -1) == "error:15"
    assert machine.world.place == [2, 0, 0]
    machine.load("[" + "C" * 40 + "D" * 40)
    machine.tell("run")
    machine.run_ms(40)
    machine.tell("pause")
    machine.settle()
    y = machine.world.place[1]
    machine.tell("jog", "y", 32_000 - y)
    machine.settle()
    assert machine.ask("continue") == "error:104"  # from here it would leave the travel
    machine.tell("return")
    machine.until("end")
    assert machine.world.place == [2, 0, 0]


def check_any_pieces(seed):
    """However a file is torn, and control commands put between its bytes, the same items come of it."""
    random = Random(seed)
    config = {"port_bits": "76543210", "port_invert": 0}
    text = b"AAB*5000\nC+1200 D$@(+0)[]" * 4 + b"ZZZZZ"

    def items_of(pieces):
        protocol = Pulses("xyz", config)
        found = []
        ended = False
        for piece in pieces:
            for command in protocol.feed(piece, 0):
                if command.kind == STEP_PROGRAM_ADD:
                    assert command.value != STEPS_ABORT and not ended
                    if command.value == STEPS_ITEMS:
                        for item in command.target:
                            if found and item & 15 and found[-1] & 255 == item & 255:
                                found[-1] += item >> 8 << 8
                            else:
                                found.append(item)
                    ended = command.value == STEPS_CLOSE
        assert ended
        return found

    whole = items_of((frame("load", len(text)) + b"\n", text, frame("end")))
    pieces = [frame("load", len(text)), b"\r\n"]
    at = 0
    while at < len(text):
        count = random.between(1, 9)
        pieces.append(text[at : at + count])
        if random.between(0, 2) == 0:
            pieces += [b"{sp", b"eed 500", b"}"]
        at += count
    assert items_of(pieces + [b"{e", b"nd}"]) == whole


def check_noise(data):
    """Whatever comes, the protocol goes on, and a file after it is understood."""
    protocol = Pulses("xyz", {"port_bits": "76543210", "port_invert": 0})
    protocol.feed(data, 0)
    protocol.feed(b"", 10_000)
    protocol.feed(b"", 20_000)
    commands = protocol.feed(frame("load", 2) + b"\nAA" + frame("end"), 20_001)
    values = [command.value for command in commands if command.kind == STEP_PROGRAM_ADD]
    assert values[-2:] == [STEPS_ITEMS, STEPS_CLOSE]

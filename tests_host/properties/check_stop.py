"""After a stop, a reset, an alarm or a hand-over nothing that was sent before moves anything: any language, any link."""

from passo import commands, errors
from passo.protocols.torch import protocol as torch
from passo.protocols.plotter.host import COMMANDS, packet, status_from
from router import Machine
from table import Machine as Plotter

LANGUAGES = ("plotter", "torch", "pulses", "keys", "grbl")
EVENTS = ("list", 14, ("who", 0, 1), ("what", 0, 99), ("turns", 0, 12))
CASES = {
    "check_nothing_moves_after_a_stop": (
        ("first", "choice") + LANGUAGES, ("second", "choice") + LANGUAGES, ("commander", "choice", "a", "pc"),
        ("events",) + EVENTS, ("late", 0, 99), ("how", 0, 4), ("cut", 0, 9),
    ),
    "check_nothing_moves_after_a_hand_over": (
        ("first", "choice") + LANGUAGES, ("second", "choice") + LANGUAGES, ("commander", "choice", "a", "pc"),
        ("events",) + EVENTS, ("late", 0, 99),
    ),
}  # fmt: skip
RUNS = {"check_nothing_moves_after_a_stop": 100, "check_nothing_moves_after_a_hand_over": 60}
EXAMPLES = {
    "check_nothing_moves_after_a_stop": (
        ("plotter", "grbl", "a", [(0, 8, 3), (0, 2, 30), (0, 8, 9)], 0, 0, 0),
        ("plotter", "torch", "pc", [(1, 0, 3)], 1, 0, 0),
        ("plotter", "torch", "a", [(0, 8, 3), (0, 2, 30), (0, 3, 1)], 0, 1, 0),
        ("plotter", "pulses", "pc", [(1, 0, 60)], 0, 0, 3),
        ("plotter", "grbl", "pc", [(1, 3, 3)], 3, 0, 2),
        ("plotter", "grbl", "pc", [(0, 7, 3)], 9, 1, 6),
        ("plotter", "plotter", "a", [(0, 2, 0)] * 3, 0, 0, 0),
    ),
}


def point(name, x=0, y=0):
    return packet(COMMANDS[name], x, y)


SQUARE = point("MOVE", 900, 300) + point("LINE", 900, 900) + point("LINE", 1700, 900)
WORDS = {
    "plotter": (
        point("LINE", 2000, 100), point("MOVE", 40, 2000), point("END"), point("ORIGIN"), point("SPEED", 900),
        point("UP"), point("RIGHT"), point("LINK"), 8 * SQUARE, point("END") + SQUARE + point("END"),
    ),
    "torch": (
        torch.frame("CONNECT"), torch.move(900, 4000, 700, -3000), torch.frame("JOG_X+"), torch.frame("JOG_Y-"),
        torch.configure(300, 200, 3000, 2000), torch.passo(torch.LINK_OF), torch.passo(torch.UNLOCK_OF), torch.frame("ORIGIN"),
    ),
    "pulses": (
        60 * b"A", b"{stream 300}" + 150 * b"GC", b"{load 4}AACC{end}", b"{run}", b"{run 5}", b"{jog x 400}", b"{home}",
        b"{link}", b"{pause}", b"{unlock}", b"{back}", b"{continue}",
    ),
    "keys": (b"I", b"C", b"D", b"A\x02", b"G", b"H", b"J", b"E"),
    "grbl": (
        b"$X\n", b"G0 X9 Y8\n", b"G1 X20 F900\nG1 Y9\nG1 X3\nG0 X7\n", b"G91\nG1 X1 F500\nX1\nX1\nX1\nX1\nX1\nX1\n",
        b"$J=G91X5F900\n", b"$H\n", b"G4 P0.05\n", b"!", b"~", b"$LINK=0\n", b"M0\n", b"G2 X9 Y9 I5 J5 F900\n", b"G38.3 Z-9 F300\n",
    ),
}  # fmt: skip
STOPS = {"plotter": point("STOP"), "torch": torch.frame("STOP"), "pulses": b"{stop}", "grbl": b"\x18"}
HAND_OVER = {"plotter": point("LINK"), "torch": torch.passo(torch.LINK_OF), "pulses": b"{link}", "grbl": b"$LINK=0\n"}
# Commands that end a wait, and draw the points left, if any.
LEFT = {
    "plotter": point("END"), "torch": torch.passo(torch.UNLOCK_OF) + torch.frame("CONNECT"), "pulses": b"{unlock}",
    "keys": b"J", "grbl": b"$X\n~",
}  # fmt: skip


class Two:
    """The router with two links, `a` and `b`."""

    def __init__(self, first, second, **changes):
        links = [
            {"name": "a", "port": "uart0", "tx": 0, "rx": 1, "protocol": first},
            {"name": "pc", "port": "usb", "protocol": second},
        ]
        self.machine = Machine(links=links, jog={"steps": 10, "up": "y+"}, step_program={}, store_points=20, **changes)
        self.controller = self.machine.controller
        self.world = self.machine.world
        self.languages = first, second
        self.lines = [self.machine.port.lines[name] for name in ("a", "pc")]
        self.controller.machine.guarded = 0
        self.controller.machine.alarm = 0
        self.stood = None  # steps made when it was stopped, from arm() on
        self._armed = False
        for kind in (commands.STOP, commands.RESET, commands.HAND_OVER):
            self._watch(kind)
        self._raise_alarm = self.controller.machine.raise_alarm
        self.controller.machine.raise_alarm = self.raises_alarm

    def _watch(self, kind):
        handler = self.controller.machine.handlers[kind]

        def watched(command):
            before = self.controller.machine.commander
            result = handler(command)
            if kind != commands.HAND_OVER or self.controller.machine.commander != before:
                self._mark()
            return result

        self.controller.machine.handlers[kind] = watched

    def raises_alarm(self, number, who=None, also=0):
        self._raise_alarm(number, who, also)
        self._mark()

    def arm(self):
        self._armed = True

    def _mark(self):
        if self._armed and self.stood is None:
            self.stood = self.world.steps

    def say(self, who, data):
        self.lines[who].incoming += data

    def events(self, events):
        """Say all of them, each the given number of cycles before the next."""
        for who, what, turns in events:
            words = WORDS[self.languages[who]]
            self.say(who, words[what % len(words)])
            self.cycles(turns)

    def cycles(self, count):
        for _ in range(count):
            self.machine.app.cycle()

    def stands(self):
        """Fail if the machine has moved since, or moves once an open line or wait is ended."""
        assert self.stood is not None
        for who in (0, 1, 0):
            self.cycles(60)
            assert self.world.steps == self.stood, "sent before, and moves"
            self.say(who, HAND_OVER.get(self.languages[who], b""))
            self.cycles(30)
            self.say(who, LEFT[self.languages[who]])
        self.cycles(150)
        assert self.world.steps == self.stood, "sent before, and moves"


def fail(machine, number):
    """An alarm, as one turn of the main loop raises and tells it."""
    machine.app.controller.machine.raise_alarm(number, "test")
    machine.app._send_events()


def check_nothing_moves_after_a_stop(first, second, commander, events, late, how, cut):
    """`how`: the first or second link's word for stop, the emergency stop, a limit that is hit, or the button for reset.
    In the same turn the other link has said one thing more, `late`, but for `cut` bytes of it."""
    two = Two(first, second, commands=commander)
    two.events(events)
    who = how if how < 2 and two.languages[how] in STOPS else -1
    other = 0 if how else 1
    words = WORDS[two.languages[other]]
    data = words[late % len(words)]
    two.say(other, data[: max(len(data) - cut, 0)])
    two.arm()
    if who >= 0:
        two.say(who, STOPS[two.languages[who]])
    elif how == 3:
        fail(two.machine, errors.ALARM_HARD_LIMIT)
    elif how == 4:
        two.controller.machine.carry_out(commands.RESET)
        two.machine.app._send_events()
    else:
        two.world.switches["stop"] = 1
    turns = 200
    while two.stood is None and turns:
        two.cycles(1)
        turns -= 1
    two.world.switches.clear()
    two.stands()


def check_nothing_moves_after_a_hand_over(first, second, commander, events, late):
    """The motion begun may end; then the command changes hands, in the cycle in which the other link sends one thing more."""
    two = Two(first, second, commands=commander)
    two.events(events)
    for _ in range(3):
        two.cycles(400)
        for who in (0, 1):
            two.say(who, STOPS.get(two.languages[who], b"J") if two.controller.state in ("run", "hold", "door") else b"")
    two.cycles(20)
    two.controller.machine.alarm = 0
    two.cycles(20)
    links = two.controller.machine
    who = 1 - links.commander
    if two.languages[who] not in HAND_OVER:
        return
    words = WORDS[two.languages[1 - who]]
    two.say(1 - who, words[late % len(words)])
    if who:  # the link that speaks first is read first
        two.cycles(200)
        if two.controller.state != "idle":
            return
    two.arm()
    two.say(who, HAND_OVER[two.languages[who]])
    two.cycles(20)
    if two.stood is not None:
        two.stands()


# --- one after the other


def drawing(store_points=20):
    """The plotter of 2014 with a long object under way."""
    plotter = Plotter(store_points=store_points)
    assert plotter.ask("ORIGIN") == b"o"
    for pen, x, y in ((0, 50, 40), (1, 800, 90), (1, 50, 40), (1, 800, 90)):
        assert plotter.ask("LINE" if pen else "MOVE", x, y) == b"n"
    plotter.send("END")
    plotter.cycles(60)
    return plotter


def stopped(plotter):
    """STOP: DONE and no other answer; then the machine stands, and the next points are a whole object of their own."""
    said = plotter.ask("STOP") + plotter.cycles(20)
    steps = plotter.table.steps
    said += plotter.cycles(1500)
    assert said == b"d" and plotter.table.steps == steps and plotter.table.pen == 0
    status = plotter.status()
    assert status["state"] == "idle" and status["free"] == plotter.app.controller.features["drawing"].points.capacity
    plotter.table.path = []
    zero = [place - at for place, at in zip(plotter.table.place, plotter.app.controller.position())]
    plotter.draw(((0, 300, 40), (1, 340, 40)))
    seen = [(x - zero[0], y - zero[1], pen) for x, y, pen in plotter.table.path]
    drawn = [place for place in seen if place[2]]
    assert drawn and drawn == [(x, 40, 1) for x in range(301, 341)]


def check_points_that_waited_for_room():
    plotter = Plotter(store_points=20)
    assert plotter.ask("ORIGIN") == b"o"
    count = 0
    while plotter.ask("LINE", 40 + 700 * (count & 1), 30 + count, turns=20) == b"n":
        count += 1
    assert count >= 20
    stopped(plotter)


def check_origin_sent_while_drawing():
    plotter = drawing()
    plotter.send("ORIGIN")
    plotter.cycles(5)
    stopped(plotter)


def check_an_object_sent_while_drawing():
    plotter = drawing()
    for name, x, y in (("MOVE", 9, 9), ("LINE", 99, 9), ("END", 0, 0)):
        plotter.send(name, x, y)
    plotter.cycles(5)
    stopped(plotter)


def check_origin_that_waited_for_an_alarm():
    """Homing leads out of an alarm, but not by an ORIGIN from before it."""
    plotter = drawing()
    plotter.send("ORIGIN")
    plotter.cycles(5)
    fail(plotter, errors.ALARM_SENSOR_DEAD)
    steps = plotter.table.steps
    assert plotter.cycles(1500) == b"" and plotter.table.steps == steps
    assert plotter.status()["state"] == "alarm"
    assert plotter.ask("ORIGIN") == b"o"


def check_a_sender_hears_of_a_stop_from_another_link():
    """A reset's banner ends its job; lines it still sends are answered; the line half sent before gets an answer, too."""
    two = Two("plotter", "grbl", commands="pc")
    machine = two.machine
    machine.do("G91", "G1 X9 F600")
    machine.put("X9\nX9\nG4 P1\nX9\nX")
    two.cycles(20)
    machine.said()
    two.say(0, point("STOP"))
    two.cycles(20)
    said = machine.said()
    assert "Grbl 1.1h ['$' for help]" in said and "ok" not in said, said
    place = two.controller.position()
    machine.put("9\n")
    assert machine.cycles(60) == ["error:%d" % errors.STOPPED] and two.controller.position() == place
    assert machine.do("$G")[0].startswith("[GC:G0 G54 G17 G21 G90 ")
    machine.do("G0 X0")


def check_lines_behind_an_alarm():
    """Each is answered, and none is done: an unlocking from before the alarm does not count either."""
    two = Two("grbl", "grbl", commands="pc")
    machine = two.machine
    machine.do("G91", "G1 X9 F600")
    machine.settle()
    steps = two.world.steps
    machine.put("G38.2 Z-1 F900\nX9\n$X\nX9\n\nX9\n")
    said = machine.cycles(800)
    assert said[0] == "ALARM:5" and said.count("ok") == 2  # the probing itself, as grbl has it, and the empty line
    assert said.count("error:9") == 4 and two.controller.machine.alarm == errors.ALARM_PROBE_MISSED
    assert two.world.steps == steps + 400
    machine.do("$X", "G0 X0")


def check_a_hand_over_forgets_the_object():
    """Points that were stored before the command went away are not drawn when it comes back."""
    two = Two("plotter", "grbl")
    two.say(0, SQUARE)
    two.cycles(5)
    assert two.controller.features["drawing"].points.count == 3
    two.machine.do("$LINK=2", "G0 X3")
    two.machine.settle()
    two.machine.do("$LINK=1")
    steps = two.world.steps
    two.lines[0].outgoing = b""
    two.say(0, point("END"))
    two.cycles(100)
    assert two.lines[0].outgoing == b"d" and two.world.steps == steps


def check_every_stop_is_answered():
    """Also one that comes while the one before it is still being carried out."""
    two = Two("torch", "pulses")
    two.say(0, torch.move(9000, 4000, 0, 1))
    two.cycles(30)
    two.say(0, 2 * STOPS["torch"])
    two.say(1, 2 * STOPS["pulses"])
    two.cycles(30)
    place = two.controller.position()[0]
    assert two.lines[0].outgoing == 2 * torch.answer("STOP", place, 0)
    assert two.lines[1].outgoing.count(b"ok\n") == 2


def check_a_pause_ends_a_jog_where_no_link_speaks_grbl():
    two = Two("torch", "pulses")
    two.say(0, torch.configure(3000, 3000, 4000, 4000) + torch.frame("JOG_X+"))
    two.cycles(30)
    two.say(1, b"{pause}")
    two.cycles(60)
    place = two.controller.position()[0]
    assert 0 < place < 3000 and two.controller.state == "idle"
    two.cycles(300)
    assert two.controller.position()[0] == place


def check_a_pulse_file_hears_of_a_stop_from_another_link():
    two = Two("pulses", "plotter")
    two.say(0, b"{stream 9000}" + 400 * b"A")
    two.cycles(70)
    assert two.world.steps
    two.say(1, point("STOP"))
    two.cycles(5)
    steps = two.world.steps
    assert two.lines[0].outgoing.endswith(b"stopped\n")
    two.say(0, 40 * b"A")
    two.cycles(60)
    assert two.world.steps == steps
    status = status_from(ask(two, 1, point("STATUS")))
    assert status["state"] == "idle"


def ask(two, who, data):
    two.lines[who].outgoing = b""
    two.say(who, data)
    two.cycles(20)
    return two.lines[who].outgoing

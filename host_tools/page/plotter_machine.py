"""A machine that speaks the plotter's packets, as the page sees it: orders in, one state out.

    machine = PlotterMachine(write, tell, board)    # a checked board file: steps/mm, which way UP goes
    machine.job.run("square.txt", [(1, b"MOVE 200 150"), (2, b"LINE 200 550"), (3, b"END")], 1, False)

A job (plotter_job.py) is in the words of `passo send`: MOVE and LINE with a place in steps, SPEED, and END, which draws what has been
sent. Where the pen is, is known from that, and from the points drawn that STATUS counts. The language has no word for "no": STATUS, which is asked all the time, tells what was refused. What is not answered, though a later STATUS is, has
got lost and is sent again; a point twice is a line of no length. A held jog ends with STOP, which also lifts the pen.
"""

from micropython import const

from host_tools.page.cable_machine import CableMachine
from host_tools.page.plotter_job import PlotterJob
from passo import errors
from passo.protocols.page.orders import number
from passo.protocols.page.plotter import MOST_PLACE, PlotterPage, jogs_of, signs
from passo.protocols.page.steps import steps_by, steps_to
from passo.protocols.plotter.host import ANSWERS, COMMANDS, STATUS_LENGTH, packet, status_from

_LOST = const(3)  # STATUS answered behind a packet that was not
_ATTEMPTS = const(8)
_TORN_MS = const(400)  # of a STATUS: the rest does not come any more
_ANSWER_TO = {"LINE": "NEXT", "MOVE": "NEXT", "END": "DONE", "SPEED": "SPEED_OK", "ORIGIN": "ORIGIN_OK", "STOP": "DONE", "LINK": "LINK_OK",
              "UP": "NEXT", "DOWN": "NEXT", "LEFT": "NEXT", "RIGHT": "NEXT"}  # fmt: skip
_TAKES_TIME = ("END", "ORIGIN", "STOP")  # answered when they are done
_ONCE = ("UP", "DOWN", "LEFT", "RIGHT")


class PlotterMachine(CableMachine):
    language = "plotter"
    ask_ms = 60
    silent_ms = 5000  # a torn packet keeps the board silent for two seconds
    again_ms = 250
    can = PlotterPage.can + ("jobs", "single")

    def __init__(self, write, tell, board):
        CableMachine.__init__(self, tell, PlotterJob(self), board)
        self._write = write
        self._jogs = jogs_of(board)
        self._travel = [min(axis["travel_steps"], MOST_PLACE) for axis in board["axes"]]
        self._buffer = b""
        self._queue = []  # (name, x, y, answered): the first one is under way
        self._asked = 0  # STATUS answered since it was sent
        self._idle = 0  # of these the newest in a row that said idle
        self._attempts = 0
        self._steps = None
        self._way = None
        self.orders = {"pace": self._pace}

    # --- packets

    def send(self, name, x, y, answered):
        """A packet behind those that are not answered; answered(error): 0, or why not."""
        self._queue.append((name, x, y, answered))
        if len(self._queue) == 1:
            self._say()

    def _say(self):
        name, x, y, _ = self._queue[0]
        self._asked = self._idle = 0
        self._write(packet(COMMANDS[name], x, y))

    def _end_packet(self, error):
        """The packet under way is done with."""
        answered = self._queue.pop(0)[3]
        self._attempts = 0
        if error:
            self._drop(error)
        elif self._queue:
            self._say()
        answered(error)

    def _drop(self, error):
        """Nothing behind it is sent any more."""
        lost = self._queue
        self._queue = []
        for each in lost:
            each[3](error)

    def feed(self, data, now_ms):
        if self._buffer and (now_ms - self._now_ms) % 0x20000000 > _TORN_MS:
            self._buffer = b""
        self._now_ms = now_ms
        self._buffer += bytes(data)
        while self._buffer:
            if self._buffer[0] != COMMANDS["STATUS"]:
                answer = ANSWERS.get(self._buffer[0])
                self._buffer = self._buffer[1:]
                self._hear(answer)
            elif len(self._buffer) < STATUS_LENGTH:
                return
            else:
                try:
                    status = status_from(self._buffer[:STATUS_LENGTH])
                except (ValueError, IndexError):
                    self._buffer = self._buffer[1:]
                    continue
                self._buffer = self._buffer[STATUS_LENGTH:]
                self._report(status)

    def _hear(self, answer):
        if self._queue and answer == _ANSWER_TO[self._queue[0][0]]:
            self._end_packet(0)

    def _lose(self):
        self._buffer = b""
        self._drop(errors.NO_ANSWER)
        CableMachine._lose(self)

    def _ask(self):
        self._write(packet(COMMANDS["STATUS"]))

    def _report(self, status):
        state = self.state
        self._reported()
        name = status["state"]
        state["state"] = name[:1].upper() + name[1:]
        self._steps = [status["x"], status["y"]]
        self._show_place(self._steps)
        state["drawn"], state["free"] = status["drawn"], status["free"]
        self.job.report(status["drawn"])
        error = status["error"]
        state["pen"] = self._pen(name)
        alarm = name == "alarm"
        state["alarm"] = (error or state["alarm"] or errors.NUMBER) if alarm else 0
        if error and error not in PlotterPage.untold:
            self.note(error)
        self._settle(name, error if error == errors.STOPPED or error not in PlotterPage.untold else 0, alarm, status["free"])
        if self.watcher:
            self.watcher(state)

    def _pen(self, name):
        """up, down, or "": not known. It goes up behind each object."""
        if name == "hold":
            return self.state.get("pen", "")
        if name != "run":
            return "up"
        down = self.job.pen_is_down()
        if down is None and not self._queue:
            return ""  # another link draws
        return "down" if down else "up"

    def _settle(self, name, error, alarm, free):
        """What a STATUS tells of the packet under way, which has not been answered: refused, held back, done, or lost."""
        if not self._queue:
            return
        what = self._queue[0][0]
        if error or alarm and what not in ("ORIGIN", "STOP"):
            self._end_packet(error or self.state["alarm"])
            return
        self._asked += 1
        self._idle = self._idle + 1 if name in ("idle", "alarm") else 0
        waits = what in ("LINE", "MOVE") and free == 0 or what in _TAKES_TIME and not self._idle or name == "jog" and what in _ONCE
        if waits or (self._idle if what in _TAKES_TIME else self._asked) < _LOST:
            return
        self._attempts += 1
        if what in _ONCE or self._attempts > _ATTEMPTS:
            self._end_packet(errors.NO_ANSWER)
        else:
            self._say()

    # --- orders

    def stands_at(self, line):
        """True if the last STATUS has the place of a line of a job, (name, x, y)."""
        return self._steps == [line[1], line[2]]

    def play(self, what):
        """A drawing point by point: step, step_back, back, run."""
        return self.job.play(what)

    def still(self):
        return errors.BUSY if self._queue else CableMachine.still(self)

    def _order(self, name, x=0, y=0):
        self.send(name, x, y, self.finished)
        return 0

    def stop(self):
        """Stop at once, pen up; the drawing is forgotten."""
        self.drop_jog()
        self.job.fail(errors.STOPPED)
        self._drop(0)
        return self._order("STOP")

    def home(self):
        return self.still() or self._order("ORIGIN")

    def give(self, owner):
        """Take the command from another link; the page gives it to none."""
        return self._order("LINK") if owner == "page" else errors.UNKNOWN_COMMAND

    def _pace(self, order):
        """The drawing speed, in the unit of the board file."""
        return self.refusal() or self.still() or self._order("SPEED", int(number(order, "speed", 1, MOST_PLACE)))

    def _move(self, wanted):
        """Go to a place in steps, pen up: an object of one point."""
        error = self.still() or (errors.BUSY if self._steps is None else 0)
        if error:
            return error
        if [axis for axis in range(2) if not 0 <= wanted[axis] <= self._travel[axis]]:
            return errors.JOG_TRAVEL
        self._order("MOVE", wanted[0], wanted[1])
        return self._order("END")

    def step(self, way, speed):
        """{axis: mm} from here."""
        if self._steps is None:
            return errors.BUSY
        return self._move([at + by for at, by in zip(self._steps, steps_by(way, self.axes, self.scale))])

    def go(self, place, speed):
        """{axis: mm}."""
        if self._steps is None:
            return errors.BUSY
        return self._move(steps_to(place, self.axes, self.scale, self._steps))

    # --- the jog

    def _may_jog(self, direction):
        return signs(direction) in self._jogs and self._steps is not None and not self._queue

    def _start_jog(self, direction, speed):
        self._way = self._jogs[signs(direction)]
        self.jog.active = True

    def _go_on(self):
        if self.jog.active and not self._queue:
            self.send(self._way, 0, 0, self._jogged)

    def _jogged(self, error):
        if error and self.jog.active:
            self.lease.end()
            self.jog.end()

    def _brake(self):
        self._drop(0)
        self._order("STOP")

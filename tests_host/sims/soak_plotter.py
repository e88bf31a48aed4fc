"""The plotter of the soak: drawings at random, in packets over a wire that damages them, or in frames over a noisy one.

These must hold, seen from the wire, the coils and the plant: all points that were answered are drawn, in their order, each line once, with
the pen as asked; a damaged packet draws nothing; one answer a packet; STOP, a lost host and a power cut end the path on the path, pen up; the
place in STATUS is the plant's, and a board that has just been switched on draws nothing before it is homed.
"""

from host_tools import boards
from host_tools.clients.frames import FramedPort
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import PowerCut
from noisy_wire import damaged
from passo.protocols.plotter.host import ANSWERS, COMMANDS, STATUS_LENGTH, packet, status_from
from soak_bench import Cabled, Wrong
from soak_witness import Line, follow

TRAVEL = (4000, 3000)
HALF_US = 50  # shortest half period of a step
LEAST_TICKS = [2 * HALF_US * 12.5] * 2
LOST_MS = 4000  # longer than it takes to notice that a packet got lost
PEN_MS = 12
RESEND_MS = 2600  # after which a packet that got lost is sent again
LONGEST_MS = 600_000
LAST = 20
HARMLESS = ("fight", "fight", "garbage", "noise", "cut")
ENDS = ("stop", "other stop", "power", "board", "long cut")


def board():
    made = boards.load("plotter_2014")
    made["tool"].update(on_ms=PEN_MS, off_ms=PEN_MS)
    made["speed"].update(overhead_us=0, default=HALF_US, min=HALF_US)
    made["homing"].update(seek_steps_s=4000, locate_steps_s=200, required=True)
    made["store_points"] = 60
    made["links"][0].update(frames=True, lost_ms=LOST_MS)
    made["links"].append({"name": "panel", "port": "uart1", "tx": 20, "rx": 21, "baud": 57600, "protocol": "plotter", "idle_gap_ms": 5})
    return made


class Plotter(Cabled):
    NAME = "plotter"

    def __init__(self, seed, given=None, framed=None):
        """`given`: another board file than board(), checked by nobody; `framed`: whether the link has frames, None: at random."""
        super().__init__(seed)
        self.board = given or board()
        self.policy = self.dice.choice(("go_on", "stop"))
        self.board["links"][0].setdefault("lost", self.policy)
        self.framed = self.dice.random() < 0.5
        if framed is not None:
            self.framed = framed
        self.ended = ""
        self._heard = b""
        self.note(f"seed {seed}, {'frames' if self.framed else 'packets'}, lost host: {self.policy}")
        self.boot((700, 500))

    def close(self):
        self.machine.close()

    def boot(self, start):
        self.forget()
        self.switch_on(VirtualMachine(self.board, trace=None, start=start, seed=self.dice.randrange(1 << 30)), LEAST_TICKS)
        self.port = None
        self.line.renew(self.now_ms())
        self.run_ms(100)
        self.line.arrived = self._heard = b""
        self.known = False
        if self.framed:
            self.open_frames()
        if self.place() != list(start) or self.machine.plant.tool:
            raise Wrong("a board that has just been switched on moves")

    def open_frames(self):
        port = FramedPort(self.wire, lambda: int(self.now_ms()))
        self._heard = b""
        if not any(port.begin(1) for _ in range(5)):
            raise Wrong("no session of frames")
        self.port = port

    def place(self):
        return list(self.machine.plant.position)

    # --- packets and answers

    def put(self, data):
        if self.port:
            self.port.write(data)
        else:
            self.line.wires[0].put(data)

    def hear(self):
        """The answers that have come: their names, and the fields of STATUS."""
        if self.port:
            self._heard += self.port.read(256) if self.port.in_waiting else b""
        else:
            self.cycle()
            self._heard += self.line.arrived
            self.line.arrived = b""
        found = []
        while self._heard:
            if self._heard[0] == COMMANDS["STATUS"]:
                if len(self._heard) < STATUS_LENGTH:
                    break
                found.append(status_from(self._heard[:STATUS_LENGTH]))
                self._heard = self._heard[STATUS_LENGTH:]
            else:
                if self._heard[0] not in ANSWERS:
                    raise Wrong(f"the board says {self._heard!r}")
                found.append(ANSWERS[self._heard[0]])
                self._heard = self._heard[1:]
        return found

    def ask(self, name, x=0, y=0, wanted=None, limit_ms=LONGEST_MS, wire=False):
        """Send a packet, again if it is asked for; its answer. None if the program has ended. `wire`: it may be damaged."""
        data = packet(COMMANDS[name], x, y)
        trouble = self.dice.random() if wire and not self.port else 1  # 1: the packet has come whole, as far as the host knows
        again_ms = None
        if trouble < 0.03:
            self.fault("damaged packet", name)
            self.put(damaged(self.dice, data))
        elif trouble < 0.04:
            self.fault("lost packet", name)
            again_ms = self.now_ms() + RESEND_MS
        else:
            trouble = 1
            self.put(data)
        end_ms = self.now_ms() + limit_ms
        polled_ms = self.now_ms()
        while True:
            for answer in self.hear():
                if answer == "RESEND":
                    trouble = 1
                    self.put(data)
                elif wanted is None and isinstance(answer, dict) or answer == wanted:
                    return answer
                elif not isinstance(answer, dict):
                    raise Wrong(f"{name} is answered with {answer}")
            if self.ended:
                return None
            now = self.now_ms()
            if again_ms is not None and now > again_ms:
                again_ms, trouble = None, 1
                self.put(data)
            if self.policy == "stop" and wanted and trouble == 1 and now - polled_ms > 400:
                polled_ms = now
                self.put(packet(COMMANDS["STATUS"]))
            if now > end_ms:
                raise Wrong(f"no answer to {name}")

    # --- a round

    def round(self):
        self.rounds += 1
        self.forget()
        self.ended = ""
        self.machine.plant.errors.clear()
        self.begin()
        start = self.place()
        self.witness.take()
        moves = self.drawing(start)
        if self.port:
            self.line.set(self.dice.choice((0, 0.003, 0.01, 0.02)))
        self.plan()
        self.accepted = []
        self.drawn = False
        try:
            self.draw(moves)
            if self.ended:
                self.await_end()
        except PowerCut:
            self.last_steps = self.witness.take()
            self.note("the board is switched off, and on again")
            self.boot(self.place())
        except OSError as error:
            if self.ended != "long cut":
                raise Wrong(f"the link is lost: {error}") from None
            self.await_end()
        self.judge(start)
        self.recover()
        if not self.rounds % LAST and self.known:
            self.jump()
            self.check_heap()

    def begin(self):
        self.line.set(0)
        self.note(f"round {self.rounds}")
        if not self.known:
            before = self.place()
            self.put(packet(COMMANDS["LINE"], 10, 10) + packet(COMMANDS["END"]))
            self.run_ms(400)
            if self.place() != before:
                raise Wrong("it draws although it cannot know where it is")
            self.hear()
            self.ask("ORIGIN", wanted="ORIGIN_OK")
            self.known = True
            if any(self.place()):
                raise Wrong(f"homed, it stands at {self.place()}")
            self.machine.plant.errors.clear()
        self.check_place()

    def check_place(self):
        status = self.ask("STATUS")
        if [status["x"], status["y"]] != self.place():
            raise Wrong(f"the board says {status}, and it is at {self.place()}")
        return status

    def drawing(self, start):
        """[(packet's name, x, y)]"""
        x, y = start
        points = []
        for _ in range(self.dice.randint(5, 150)):
            if self.dice.random() < 0.3:
                x, y = self.dice.randint(0, TRAVEL[0]), self.dice.randint(0, TRAVEL[1])
            else:
                x = min(max(x + self.dice.randint(-120, 120), 0), TRAVEL[0])
                y = min(max(y + self.dice.randint(-120, 120), 0), TRAVEL[1])
            points.append(("MOVE" if self.dice.random() < 0.15 else "LINE", x, y))
        return points

    def draw(self, points):
        for name, x, y in points:
            self.accepted.append(Line((x, y), name == "LINE"))  # it may be drawn as soon as it is sent
            if self.ask(name, x, y, "NEXT", wire=True) is None:
                return
            if self.dice.random() < 0.005:
                self.fault("point outside")
                self.put(packet(COMMANDS["LINE"], TRAVEL[0] + 900, 5))
                answers = self.hear_ms(50)  # RESEND, if the packet before left a byte in front of it
                if any(answer == "NEXT" for answer in answers):
                    raise Wrong("a point outside is answered with NEXT")
                if self.ended:
                    return
        if self.ask("END", wanted="DONE", wire=True) is not None:
            self.drawn = True

    def plan(self):
        for _ in range(self.dice.randint(0, 6)):
            kind = self.dice.choice(HARMLESS)
            self.after(self.dice.uniform(0, 9000), lambda kind=kind: self.harmless(kind))
        if self.dice.random() < 0.5:
            kind = self.dice.choice(ENDS)
            self.after(self.dice.uniform(0, 12_000), lambda: self.end(kind))

    def harmless(self, kind):
        if self.ended or not self.line.plugged:
            return
        if kind == "fight":
            self.fault("fight")
            for name, x, y in (("LINE", 5, 5), ("END", 0, 0), ("ORIGIN", 0, 0), ("SPEED", 900, 0), ("UP", 0, 0)):
                self.machine.send(packet(COMMANDS[name], x, y), "panel")
        elif kind == "garbage":
            self.fault("garbage")
            self.machine.send(bytes(self.dice.randrange(256) for _ in range(50)), "panel")
        elif kind == "noise" and self.port:
            self.line.set(self.dice.choice((0, 0.003, 0.01, 0.02)))
        elif kind == "cut" and self.port:
            self.fault("short cut")
            self.unplug(self.dice.uniform(5, 700))

    def end(self, kind):
        if self.ended:
            return
        self.ended = kind
        self.fault(kind)
        if kind == "stop":
            self.put(packet(COMMANDS["STOP"]))
        elif kind == "other stop":
            self.machine.send(packet(COMMANDS["STOP"]), "panel")
        elif kind == "long cut":
            self.unplug(1e9)
        else:
            raise PowerCut

    def await_end(self):
        self.forget()
        if self.ended == "long cut":
            self.run_ms(LOST_MS + 1000)
        else:
            self.line.plugged = True
            if self.ended == "stop":
                self.say_stop()
            self.run_ms(800)
        self.settle()

    def say_stop(self):
        """Until it is done: behind a damaged packet it is dropped, and asked for again."""
        again_ms = self.now_ms() + RESEND_MS
        end_ms = self.now_ms() + 10 * RESEND_MS
        while True:
            answers = self.hear()
            if "DONE" in answers:
                return
            if "RESEND" in answers or self.now_ms() > again_ms:
                again_ms = self.now_ms() + RESEND_MS
                self.put(packet(COMMANDS["STOP"]))
            if self.now_ms() > end_ms:
                raise Wrong("STOP is not answered")

    def judge(self, start):
        self.count_noise()
        if self.ended in ("power", "board"):
            steps = self.last_steps
        else:
            self.settle()
            if self.ended:
                self.check_stands(tool_off=self.ended != "long cut" or self.policy == "stop")
            steps = self.witness.take()
            self.check_late()
        steps.check_intervals(strict=False)
        done, begun, place = follow(steps, start, self.accepted)
        self.note(f"{self.ended or 'ended'}: {done} of {len(self.accepted)} points, {len(steps)} steps")
        if self.drawn and not self.ended and (done != len(self.accepted) or self.machine.plant.tool):
            raise Wrong(f"only {done} of {len(self.accepted)} points are drawn, the pen is {'down' if self.machine.plant.tool else 'up'}")
        if place != self.place() and len(steps):
            raise Wrong(f"it stands at {self.place()}, and its path ends at {place}")
        self.check_plant()

    def recover(self):
        self.forget()
        self.line.set(0)
        self.line.plugged = True
        if self.ended in ("power", "board"):
            return
        if self.ended == "long cut" and self.port:
            self.open_frames()
        self.hear_ms(RESEND_MS)
        if self.ended:
            self.ended = ""
            self.ask("STOP", wanted="DONE")
        self.machine.take("panel")
        self.check_place()
        self.hear_ms(300)  # the session's last acknowledgements

    def hear_ms(self, ms):
        """Return the answers that come within `ms`."""
        answers, end_ms = [], self.now_ms() + ms
        while self.now_ms() < end_ms:
            answers += self.hear()
        return answers

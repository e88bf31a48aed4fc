"""Fuzz of the grbl link on the whole firmware: lines good, mutated, random and torn, and bytes of any kind.

    MICROPYPATH=build/unix/STATE:tests_host/properties:tests_host/sims:. micropython tests_host/properties/fuzz_grbl.py LINES [SEED]

    fuzz = Fuzz(seed)
    fuzz.run(1000)           # raises AssertionError, or whatever the firmware raised
    fuzz.lines, fuzz.refused, fuzz.resets

It fails on an exception; on a line without exactly one answer; on a refused line that steps or changes the queue's target; and if a reset and `$X` do not bring
back a machine that moves. A machine of two steps/mm on a
player that swallows its words makes motion cheap.
"""

import sys

from boards.router_3axis import BOARD
from check_gcode import ALPHABET, GOOD
from digest import Sink
from draws import Random
from passo.app import App
from passo.config.boardfile import check

TURN_MS = 8
PATIENCE = 400  # turns without an answer, then whatever is under way is ended by a reset
LONG = (
    b"G2 X10 Y10 R8 F900", b"G3 X0 Y0 Z-1 I5 J0 P2 F400", b"G17", b"G20", b"G21", b"G91", b"G90", b"G18 G3 X3 Z-3 R3 F90",
    b"G1 X20 Y20 Z-20 F1500", b"G0 X300 Y200 Z-80", b"M4 S300", b"M5", b"M8", b"M9", b"M0", b"M6 T1", b"G30", b"G92.1",
    b"G1 X5 Y2 S450 F900", b"X6S0", b"X7.5 S1000", b"G0X3S300", b"G1X4", b"M3 S200", b"S.5 X2", b"G49", b"G81 X30 Y20 Z-9 R-2 F300", b"G80", b"G54", b"T3", b"F400", b"X10", b"Y-5", b"", b"%", b"(x) G1 X1 ; y",
)  # fmt: skip
SYSTEM = (
    b"$", b"$$", b"$#", b"$G", b"$I", b"$N", b"$N0=G21", b"$N1=", b"$X", b"$C", b"$SLP", b"$H", b"$J=X1F100",
    b"$J=G91Y-1F900", b"$110=500", b"$11=0.01", b"$20=1", b"$13=0", b"$10=3", b"$RST=$", b"$RST=#", b"$32=1", b"$I=me",
)  # fmt: skip
DIGITS = b"0123456789.-+"
NUMBERS = (0, 1, 2, 3, 4, 5, 17, 20, 28, 30, 38.2, 53, 54, 80, 81, 90, 91, 92, 93, -3, 7.5)
REAL_TIME = b"?!~\x84\x85\x90\x91\x92\x93\x94\x95\x96\x97\x99\x9a\x9b\x9c\x9d\x9e\xa0\xa1"


class Port(Sink):
    """The digest's, with a clock that goes faster and switches that can be set."""

    def __init__(self):
        Sink.__init__(self)
        self.active = ()

    def input(self, name):
        return name in self.active

    def levels(self):
        return sum([1 << len(name) for name in self.active])

    def power(self, level):
        pass

    def wait(self, busy, fine, at_once):
        self._ms = (self._ms + TURN_MS) & 0x1FFFFFFF


class Fuzz:
    def __init__(self, seed):
        self.random = Random(seed)
        self.lines = self.refused = self.resets = self.late = 0
        self.log = None  # set it to []: the bytes on the wire, cycle by cycle
        self._start()

    def _start(self):
        board = check(dict(BOARD, journal=None))
        for axis in board["axes"]:
            axis["travel_steps"] = axis["travel_steps"] * 2000 // axis["steps_per_m"]
            axis["steps_per_m"] = 2000
        board["homing"]["pull_off_steps"] = 2
        laser = bool(self.random.between(0, 1))
        board["spindle"] = {"max_rpm": 1000, "min_rpm": 0, "pwm": True, "pin": 20, "laser": laser, "spin_up_ms": 40, "coolant_ms": 20}
        board["links"] = [dict(board["links"][0], lost="go_on")]  # a `?` amid the noise is no host that watches
        self.port = Port()
        self.app = App(board, self.port)
        self.controller = self.app.controller
        self.controller.machine.homed = True
        self._recover()

    # --- the wire

    def _turn(self, data=b""):
        """One turn with `data` arriving; how many lines it answered, and the last answer."""
        self.port.incoming += data
        self.app.cycle()
        said = self.port.outgoing.split(b"\r\n")
        self.port.outgoing = b""
        answered = [line for line in said if line == b"ok" or line[:6] == b"error:"]
        if self.log is not None and (len(data) > 1 or answered):
            self.log.append((data, said))
        return len(answered), answered[-1] if answered else b""

    def _recover(self):
        """A reset, `$X`, settings as they were, and the machine moves."""
        self._turn(b"\n\x18")
        self._turn()
        for data, count in ((b"$X\n", 1), (b"$RST=*\n", 1), (b"$X\nG21G90G94\n", 2)):
            assert self._answers(data, count), (data, self.controller.state)
            self._settle()  # a start-up line may have set it moving
        self.controller.machine.homed = True
        self.controller.queue.set_origin()
        before = self.port.stepping
        assert self._answers(b"$J=G91X1F1000\n", 1), self.controller.state
        self._settle()
        assert self.port.stepping == before + 2, "the machine does not move"
        self.controller.queue.set_origin()
        self.resets += 1

    def _answers(self, data, count):
        """True once `count` lines are answered."""
        for _ in range(PATIENCE):
            count -= self._turn(data)[0]
            data = b""
            if count <= 0:
                return count == 0
        return False

    def _settle(self):
        """Until nothing moves any more; whether it came to that. `late` counts the answers on the way."""
        self.late = 0
        for _ in range(PATIENCE):
            self.late += self._turn()[0]
            if self.controller.state in ("idle", "alarm", "check", "sleep") and self.controller.queue.still():
                return True
        return False

    # --- lines

    def _mutated(self, line):
        random = self.random
        line = bytearray(line)
        for _ in range(random.between(0, 3)):
            at = random.between(0, len(line))
            line = line[:at] + bytes((random.choice(ALPHABET),)) * random.choice((1, 1, 1, 1, 30)) + line[at + random.between(0, 1) :]
        return bytes(line)

    def _words(self):
        random = self.random
        line = b""
        for _ in range(random.between(1, 6)):
            line += bytes((random.choice(b"GMXYZIJKFSPLRTN"),))
            line += str(random.choice(NUMBERS)).encode()
        return line

    def line(self):
        """A line without its end, and without bytes that end a line or act at once."""
        random = self.random
        kind = random.between(0, 9)
        if kind < 2:
            return random.choice(LONG)
        if kind < 5:
            return self._mutated(random.choice(GOOD + LONG))
        if kind < 7:
            return self._words()
        if kind == 7:
            return self._mutated(random.choice(SYSTEM))
        count = random.choice((5, 20, 79, 80, 81, 200, 300))
        return bytes([byte for byte in random.bytes(count) if byte not in b"\r\n?!~\x18" and byte < 0x80])

    # --- rounds

    def run(self, lines):
        """Send at least `lines` more."""
        end = self.lines + lines
        while self.lines < end:
            kind = self.random.between(0, 9)
            if kind < 6:
                self._one_by_one()
            elif kind < 9:
                self._streamed()
            else:
                self._noise()
            if self.controller.state not in ("idle", "run", "jog") or self.random.between(0, 30) == 0:
                self._recover()

    def _one_by_one(self):
        """Send lines that each wait for their answer, to a machine that stands: a refused one changes nothing."""
        for _ in range(20):
            line = self.line()
            if not self._settle():
                return self._recover()
            controller = self.controller
            before = controller.queue.target[:], self.port.stepping, controller.machine.alarm
            self.lines += 1
            answers, last = self._turn(line + b"\n")
            turns = held = 0
            while not answers and turns < PATIENCE:
                turns += 1
                held = held + 1 if controller.state in ("hold", "door") else 0
                if held % 5 == 4:
                    self.port.incoming += b"~"
                answers, last = self._turn()
            if not answers:
                assert held < 5 or controller.state in ("run", "home", "jog"), (line, controller.state, held)
                return self._recover()
            if last != b"ok":
                self.refused += 1
                homing = last == b"error:9" and controller.machine.alarm and not before[2]  # refused on the way
                self._turn()
                self._settle()
                if not homing:
                    assert (controller.queue.target[:], self.port.stepping) == before[:2], (line, last)
            extra = self._turn()[0]
            assert answers + extra == 1 or b"$H" in line.upper(), (line, answers, extra)
            if controller.state not in ("idle", "run", "jog"):
                return self._recover()

    def _streamed(self):
        """Several lines at once, torn anywhere, with real-time bytes between and inside: as many answers as lines."""
        random = self.random
        data = bytearray()
        count = random.between(2, 8)
        for _ in range(count):
            line = self.line()
            if line.strip()[:1] == b"$":  # a reset of $C or $RST would drop what comes behind it
                line = b"G4P0"
            for byte in line + (b"\n", b"\r\n", b"\r")[random.between(0, 2)]:
                data.append(byte)
                if random.between(0, 60) == 0:
                    data.append(random.choice(REAL_TIME))
        data += b"G4P0\n"
        plain = bytes([byte for byte in data if byte < 0x80 and byte not in b"?!~"])
        count = plain.replace(b"\r\n", b"\n").replace(b"\r", b"\n").count(b"\n")
        self.lines += count
        at = answered = 0
        for turn in range(PATIENCE):
            piece = data[at : at + random.between(1, 90)]
            at += len(piece)
            if turn % 10 == 9 or turn > 50:
                piece += b"~"
            answered += self._turn(bytes(piece))[0]
            if answered >= count:
                break
        before = -1
        while before != answered:  # a slow move, and the lines that wait behind it
            before = answered
            self._settle()
            answered += self.late + self._turn()[0]
        if answered != count:
            assert answered < count and self.controller.state != "idle", (answered, count, bytes(data))
            self._recover()

    def _noise(self):
        """Bytes of any kind, resets among them: afterwards a reset helps."""
        data = self.random.bytes(self.random.between(1, 400))
        self.lines += data.count(b"\n") + data.count(b"\r") + 1
        for at in range(0, len(data), 50):
            self._turn(data[at : at + 50])
        self.port.active = self.random.choice(((), ("door",), ("probe",), ("limit_x",)))
        self._turn()
        self.port.active = ()
        self._recover()


def main(arguments):
    fuzz = Fuzz(int(arguments[1]) if len(arguments) > 1 else 1)
    fuzz.log = [] if "-v" in arguments else None
    try:
        fuzz.run(int(arguments[0]))
    except BaseException:
        for turn in (fuzz.log or [])[-20:]:
            print(turn)
        raise
    print(fuzz.lines, fuzz.refused, fuzz.resets)


if __name__ == "__main__":
    main(sys.argv[1:])

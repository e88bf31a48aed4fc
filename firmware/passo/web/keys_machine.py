"""A kit of two motors that speaks keys, as the page sees it: orders in, one state out.

    machine = KeysMachine(write, tell, board)
    machine.attached(True)          # the port is open: nothing else tells that there is a board

The board never answers. The state shown is what follows from the keys that this page has sent, from the start of the board on: both
off, clockwise, speed 1. A motor that turns while a button is held is switched off when it is let go; one that has been switched on
turns until it is switched off, as the language has it.
"""

from passo import errors
from passo.protocols.keys.protocol import MOTORS, SLOWEST, SPEED, STEP_MS
from passo.web.any_machine import AnyMachine
from passo.web.api import Wrong, number, text
from passo.web.torch_machine import NoJob

# What each task is called, by motor; 0: both.
_ON = (b"I", b"C", b"D")
_OFF = (b"J", b"E", b"F")
_REVERSE = (b"", b"G", b"H")
_SPEED = dict([(motor + 1, bytes((key,))) for key, motor in SPEED.items()])


class KeysMachine(AnyMachine):
    language = "keys"
    jogs_from = ("Idle", "Run", "Jog")
    can = ("jog", "turning")

    def __init__(self, write, tell, board):
        AnyMachine.__init__(self, tell, NoJob(), board)
        self._write = write
        self._motors = [{"on": False, "back": False, "speed": 1} for _ in range(MOTORS)]
        self._open = False
        self._held = 0  # the motor that turns while a button is held
        self.orders = {"motor": self._motor}

    def feed(self, data, now_ms):
        """The board never speaks."""
        self._now_ms = now_ms

    def attached(self, is_open):
        self._open = is_open
        if not is_open:
            self._lose()

    def _ask(self):
        self._asking = False
        if not self._open:
            return
        self._reported()
        self._show()
        if self.watcher:
            self.watcher(self.state)

    def _show(self):
        turning = [motor for motor in self._motors if motor["on"]]
        self.state["state"] = "Jog" if self.jog.active else "Run" if turning else "Idle"
        self.state["motors"] = [
            {"on": motor["on"], "back": motor["back"], "speed": motor["speed"], "rate": round(1000 / (STEP_MS * motor["speed"]), 1)}
            for motor in self._motors
        ]

    def _say(self, key, which, name, value):
        """A task of motor `which`, 0: both; what it makes of them."""
        self._write(key)
        for motor in range(MOTORS):
            if which in (0, motor + 1):
                self._motors[motor][name] = value
        self._show()
        return 0

    def stop(self):
        """Both off."""
        self.drop_jog()
        return self._say(_OFF[0], 0, "on", False)

    def _motor(self, order):
        """`motor` 1 or 2, 0: both; `what`: on, off, reverse, speed; `speed`: 1, the fastest, to 127."""
        which = int(number(order, "motor", 0, MOTORS))
        what = text(order, "what", 8)
        error = self.refusal()
        if error or what == "off":
            return error or self._say(_OFF[which], which, "on", False)
        if self.jog.active:
            return errors.BUSY
        if what == "on":
            return self._say(_ON[which], which, "on", True)
        if not which or what not in ("reverse", "speed"):
            raise Wrong("what")
        if what == "reverse":
            return self._say(_REVERSE[which], which, "back", not self._motors[which - 1]["back"])
        value = int(number(order, "speed", 1, SLOWEST))
        return self._say(_SPEED[which] + bytes((value,)), which, "speed", value)

    # --- while a button is held

    def _may_jog(self, direction):
        turned = [axis for axis in range(len(direction)) if direction[axis]]
        return len(turned) == 1 and turned[0] < MOTORS and not self._motors[turned[0]]["on"] and not self.jog.active

    def _start_jog(self, direction, speed):
        axis = 0 if direction[0] else 1
        self._held = axis + 1
        self.jog.active = True
        if self._motors[axis]["back"] != (direction[axis] < 0):
            self._say(_REVERSE[self._held], self._held, "back", direction[axis] < 0)
        self._say(_ON[self._held], self._held, "on", True)

    def _brake(self):
        self._say(_OFF[self._held], self._held, "on", False)

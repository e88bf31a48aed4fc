"""The page of a kit of two motors, whose language is keys.

    machine = KeysPage(record, number, board, tell, spoken)     # `spoken`: what understands keys

The state shown is what follows from the keys that this page has sent, from the start of the board on: both off, clockwise, speed 1. A motor
that turns while a button is held is switched off when it is let go; one that has been switched on turns until it is switched off, as the
language has it.
"""

from passo import errors
from passo.protocols.keys.kit import KIT_MOTORS, KIT_SLOWEST, KIT_STEP_MS
from passo.protocols.page.orders import Wrong, number_field, text_field
from passo.protocols.page.page_machine import PageMachine

# The byte of each task, by motor; 0: both.
_ON = (b"I", b"C", b"D")
_OFF = (b"J", b"E", b"F")
_REVERSE = (b"", b"G", b"H")
_SPEED = (b"", b"A", b"B")


class Kit:
    """The state of the motors, as keys change it."""

    def __init__(self, write):
        """`write(bytes)`: keys."""
        self._write = write
        self._motors = [{"on": False, "back": False, "speed": 1} for _ in range(KIT_MOTORS)]
        self._held = 0  # the motor that turns while a button is held

    def is_turning(self):
        """True if a motor is on."""
        return bool([motor for motor in self._motors if motor["on"]])

    def motor_states(self):
        """The state of each motor, a list of dicts; "rate": steps/s."""
        return [
            {"on": motor["on"], "back": motor["back"], "speed": motor["speed"], "rate": round(1000 / (KIT_STEP_MS * motor["speed"]), 1)}
            for motor in self._motors
        ]

    def _send_key(self, key, which, name, value):
        """Send the key of a task of motor `which`, 0: both, and note its effect."""
        self._write(key)
        for motor in range(KIT_MOTORS):
            if which in (0, motor + 1):
                self._motors[motor][name] = value
        return 0

    def switch_off(self):
        return self._send_key(_OFF[0], 0, "on", False)

    def carry_out(self, order, machine):
        """Carry out a page's order: `motor` 1 or 2, 0: both; `what`: on, off, reverse, speed; `speed`: 1, the fastest, to 127. Returns 0 or an error.
        Raises Wrong."""
        which = int(number_field(order, "motor", 0, KIT_MOTORS))
        what = text_field(order, "what", 8)
        error = machine.refusal()
        if error or what == "off":
            return error or self._send_key(_OFF[which], which, "on", False)
        if machine.jog.active:
            return errors.BUSY
        if what == "on":
            return self._send_key(_ON[which], which, "on", True)
        if not which or what not in ("reverse", "speed"):
            raise Wrong("what")
        if what == "reverse":
            return self._send_key(_REVERSE[which], which, "back", not self._motors[which - 1]["back"])
        value = int(number_field(order, "speed", 1, KIT_SLOWEST))
        return self._send_key(_SPEED[which] + bytes((value,)), which, "speed", value)

    # --- while a button is held

    def may_hold(self, direction):
        turned = [axis for axis in range(len(direction)) if direction[axis]]
        return len(turned) == 1 and turned[0] < KIT_MOTORS and not self._motors[turned[0]]["on"]

    def hold_motor(self, direction):
        """Turn the motor of an axis in its direction, until let_go()."""
        axis = 0 if direction[0] else 1
        self._held = axis + 1
        if self._motors[axis]["back"] != (direction[axis] < 0):
            self._send_key(_REVERSE[self._held], self._held, "back", direction[axis] < 0)
        self._send_key(_ON[self._held], self._held, "on", True)

    def let_go(self):
        """Switch the motor off that hold_motor() has turned."""
        self._send_key(_OFF[self._held], self._held, "on", False)


class KeysPage(PageMachine):
    language = "keys"
    speaks = True
    jogs_from = ("Idle", "Run", "Jog")
    can = ("jog", "turning")

    def __init__(self, record, number, board, tell, spoken):
        PageMachine.__init__(self, record, number, board, tell)
        self._spoken = spoken
        self._keys = b""
        self._kit = Kit(self._write_key)
        self.orders = {"motor": self._order_motor}

    def _write_key(self, key):
        self._keys += key

    def commands(self):
        """Yield the commands of the keys, then the page's own."""
        keys, self._keys = self._keys, b""
        for command in self._spoken.feed(keys, self._now_ms):
            yield command
        for command in PageMachine.commands(self):
            yield command

    def pending(self):
        return self._keys or PageMachine.pending(self)

    def _state_word(self, state):
        return "Jog" if self.jog.active else "Run" if self._kit.is_turning() else "Idle"

    def _show_fields(self, report):
        self.state["motors"] = self._kit.motor_states()
        self._tell_error(report)

    # --- orders

    hold = resume = home = unlock = PageMachine._refuse_order

    def stop(self):
        """Switch both motors off at once. Returns 0."""
        self.drop_jog()
        return self._kit.switch_off()

    def _order_motor(self, order):
        return self._kit.carry_out(order, self)

    def _may_jog(self, direction):
        return not self.jog.active and self._kit.may_hold(direction)

    def _start_jog(self, direction, speed):
        self.jog.active = True
        self._kit.hold_motor(direction)

    def _brake(self):
        self._kit.let_go()

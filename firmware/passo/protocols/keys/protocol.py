"""The two-motor kit's language: a byte is a task, two are a speed; the board answers nothing but `?` and `$`, which the kit's own programs never say.

    keys = Keys(turning, axes)
    for command in keys.feed(serial.read(), now_ms): …

    A n, B n    speed of motor 1, motor 2: a step every n × 4 ms, n = 1 … 127
    C D I       motor 1, motor 2, both on           G H     reverse motor 1, motor 2
    E F J       motor 1, motor 2, both off, their coils without current
    $…          a line about settings, as setting_lines.py and typed_words.py have it: digits and signs that are no task
    ?           answered by `?` and a byte: the number of what was refused last since it was asked, 0: nothing, or of the alarm

At the start both are off, turn clockwise (the axis's positive direction) when they are switched on, and have speed 1.
Whatever else comes, a speed of 0 or above 127 included, changes nothing: the event log has it.
A speed whose second byte does not come within 2 s is dropped, so that no later key is taken for it.
"""

from micropython import const

from passo import errors
from passo.commands import BAD, STATUS, Command
from passo.options.independent.commands import FOREVER, LIVE, Rest, Run
from passo.protocols.keys.kit import KIT_MOTORS, KIT_SLOWEST, KIT_STEP_MS
from passo.protocols.setting_lines import teach_lines
from passo.protocols.typed_words import TypedWords
from passo.records import COUNT_MASK

_PATIENCE_MS = const(2000)

# Byte of each task, and the mask of the motors that it is for.
SPEED = {0x41: 0, 0x42: 1}  # motor
ON = {0x43: 1, 0x44: 2, 0x49: 3}
OFF = {0x45: 1, 0x46: 2, 0x4A: 3}
REVERSE = {0x47: 0, 0x48: 1}  # motor
WHY = const(0x3F)


class Keys:
    def __init__(self, is_turning, axes):
        """`is_turning(axis)`: whether an axis runs; `axes`: how many the machine has, two at least."""
        self._is_turning = is_turning
        self._axes = axes
        self._speed = [1] * KIT_MOTORS
        self._negative = [False] * KIT_MOTORS
        self.words = TypedWords()
        teach_lines(self.words)
        self._waiting = None  # the motor whose speed comes next
        self._since_ms = 0

    def feed(self, data, now_ms):
        """Yield commands, each to be carried out before the next is asked for."""
        if self._waiting is not None and (now_ms - self._since_ms) & COUNT_MASK >= _PATIENCE_MS:
            self._waiting = None
            yield Command(BAD, error=errors.GARBLED)
        if self.words.is_amid_line() and (now_ms - self._since_ms) & COUNT_MASK >= _PATIENCE_MS:
            self.words.forget_line()
            yield Command(BAD, error=errors.GARBLED)
        for byte in data:
            command = self._take_byte(byte, now_ms)
            if command is not None:
                yield command

    def _take_byte(self, byte, now_ms):
        """Return the command of a byte, or None."""
        if self._waiting is not None:
            motor = self._waiting
            self._waiting = None
            return self._set_speed(motor, byte)
        if self.words.takes_byte(byte):
            self._since_ms = now_ms
            return self.words.take_byte(byte)
        self.words.forget_line()
        if byte in SPEED:
            self._waiting = SPEED[byte]
            self._since_ms = now_ms
            return None
        if byte in ON:
            return self._run_motors(self._turning_mask() | ON[byte], ON[byte])
        if byte in OFF:
            command = Rest(OFF[byte])
            command.unpowered = self._mask_without(self._turning_mask() & ~OFF[byte])
            return command
        if byte in REVERSE:
            motor = REVERSE[byte]
            self._negative[motor] = not self._negative[motor]
            return self._run_motors(self._turning_mask(), 1 << motor) if self._is_turning(motor) else None
        return Command(STATUS) if byte == WHY else Command(BAD, error=errors.UNKNOWN_COMMAND)

    def _set_speed(self, motor, speed):
        """Return the command of a motor's new speed, a step every `speed` × 4 ms; None if it stands."""
        if not 1 <= speed <= KIT_SLOWEST:
            return Command(BAD, error=errors.NUMBER_RANGE)
        self._speed[motor] = speed
        return self._run_motors(self._turning_mask(), 1 << motor) if self._is_turning(motor) else None

    def _turning_mask(self):
        """Return the mask of the motors that are on."""
        mask = 0
        for motor in range(KIT_MOTORS):
            if self._is_turning(motor):
                mask |= 1 << motor
        return mask

    def _mask_without(self, on):
        """Return the mask of all axes but those of `on`."""
        return (1 << self._axes) - 1 & ~on

    def _run_motors(self, on, named):
        """Return the command by which the motors of the mask `named` turn as they are set; `on`: all that turn then."""
        steps = [None] * self._axes
        rates = [None] * self._axes
        for motor in range(KIT_MOTORS):
            if named >> motor & 1:
                steps[motor] = -FOREVER if self._negative[motor] else FOREVER
                rates[motor] = (1, KIT_STEP_MS * self._speed[motor])
        command = Run(steps, rates, LIVE)
        command.unpowered = self._mask_without(on)
        return command

    def reply(self, event):
        """Return the answer to `?` or a line of settings; the kit's own tasks have none."""
        said = self.words.event_bytes(event)
        if said is not None:
            return said
        return bytes((WHY, event.value["error"])) if event.command.kind == STATUS else b""

    def push_bytes(self, event):
        """Return b"": the board never speaks unasked."""
        return b""

    def drop(self, event):
        """Do nothing: half a speed moves no motor."""
        return b""

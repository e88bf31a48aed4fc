"""The settings by number and name: typed, bounded, with the board file's values as defaults, kept across power cuts.

    settings = Settings(board, Journal(FileSlots("/settings")))
    settings.value(110)              # 500000: $110 in thousandths
    settings.change(110, 600_000)    # 0, or the number of an error; the board dict follows
    settings.save()                  # if something has changed; never while the machine moves
    before = settings.snapshot()
    error = settings.change(110, 600_000) or settings.save(before)     # what cannot be kept does not count
    settings.put("G54", "0,0,0")     # texts beside the numbers: offsets, start-up lines

Levels of pins ($0, $2, $3, $4) change with the next start, all else at once. Numbers and meanings are grbl 1.1's, also of MASKS, whose
defaults say how the board file has it. Those with decimals are held in thousandths. $12 is kept and changes nothing: arcs are walked as
circles, not in chords of a tolerance. Unchanged values are not stored, so that a new board file shows; numbers that this firmware does not
know stay stored for the one that does.

A stored line is NUMBER=VALUE, of masks VERSION:NUMBER=VALUE. Without a version a mask is of the first firmware,
where it said what differs from the board file: it is converted. That firmware in its turn leaves masks with a version alone.
"""

from micropython import const

from passo import errors
from passo.config.setting_numbers import (
    DIRECTION_INVERT, ENABLE_INVERT, HOMING, HOMING_DEBOUNCE, HOMING_DIRECTION, HOMING_LOCATE, HOMING_PULL_OFF,
    HOMING_SEEK, IDLE_DELAY, INTERVAL, JERK, JOG, JOG_SPEED, LASER, LIMIT_INVERT, PROBE_INVERT, PULSE_US, SOFT_LIMITS, SPEED, STEPS,
    STEP_INVERT, TRAVEL,
)  # fmt: skip
from passo.steps.word import TICKS_PER_S, us_to_ticks

_LONGEST_TEXT = const(80)
_LEAST_JERK = const(10_000)  # 10 mm/s³; 0: no limit

MASKS = (STEP_INVERT, DIRECTION_INVERT, ENABLE_INVERT, LIMIT_INVERT, PROBE_INVERT, HOMING_DIRECTION)
_VERSION = "2:"


class Settings:
    def __init__(self, board, journal, more=(), writing=None, steps_s=1_000_000):
        """`board`: a checked board, which follows the settings from now on. `more`: functions (board, table) that add what the
        board's languages have. `writing`: called with True before something is written, and with False after it. `steps_s`: as
        limit_steps()."""
        self._writing = writing
        self._board = board
        self._journal = journal
        self._board_travel = [axis["travel_steps"] for axis in board["axes"]]
        self._board_reversed = [axis["reversed"] for axis in board["axes"]]
        self._board_release_ms = board["idle_release_ms"]
        self._board_pulses_s = self._pulses_s(board["drive"]["pulse_us"])
        self._most_steps_s = steps_s
        from passo.config.setting_numbers import make  # the app forgets it again

        self._table = make(board)
        for add in more:
            add(board, self._table)
        additions = board.get("additions")
        self._one_belt = bool(additions) and additions.one_belt
        if additions:
            self._table.update(additions.settings)
            additions.value = self.value
        self.numbers = sorted(self._table)
        self._changed = {}
        self._texts = {}
        self.dirty = False
        self.failed = False  # it could not be saved, and nothing has changed since
        self.version = 0  # goes up with each change of a number
        self.steps_per_m = [0] * len(board["axes"])  # of each axis: one list
        self._load_lines(journal.read() or "")
        self.damaged = journal.damaged
        self._apply_to_board()

    def limit_steps(self, steps_s):
        """Limit all speeds to `steps_s` steps a second: the most of the player, whose ring these settings decide."""
        self._most_steps_s = steps_s

    # --- numbers

    def value(self, number):
        """Return a setting as an integer; in thousandths if places() is 3. Raises KeyError if there is no such setting."""
        if number in self._changed:
            return self._changed[number]
        return self._table[number][2]

    def mask_change(self, number):
        """Return the bits in which one of MASKS differs from the board file."""
        return self.value(number) ^ self._table[number][2]

    def masks(self):
        """Return [(number, value in the board file)] of MASKS."""
        return [(number, self._table[number][2]) for number in MASKS]

    def name(self, number):
        """Return the name of a setting. Raises KeyError."""
        return self._table[number][0]

    def places(self, number):
        """Return the decimals of a setting, 0 or 3; None if there is no such setting."""
        rule = self._table.get(number)
        return rule[1] if rule else None

    def reset(self, number):
        """Reset a setting to the board file's value, whatever the bounds. Returns 0, STATEMENT (no such), STEP_RATE or LIMITS_NEED_HOMING."""
        error = self._check_value(number, self._table[number][2]) if number in self._table else errors.STATEMENT
        if error in (errors.STATEMENT, errors.STEP_RATE, errors.LIMITS_NEED_HOMING):
            return error
        self._changed.pop(number, None)
        if number - STEPS in (0, 1) and self._one_belt:
            self._changed.pop(STEPS + 1 - (number - STEPS), None)
        self._mark_changed()
        return 0

    def change(self, number, value):
        """Change a setting; save() stores it. Returns 0, or the error number of a value that is not allowed."""
        error = self._check_value(number, value)
        if error:
            return error
        self._changed[number] = value
        if number - STEPS in (0, 1) and self._one_belt:
            self._changed[STEPS] = self._changed[STEPS + 1] = value
        if number == HOMING and not value:
            self._changed[SOFT_LIMITS] = 0
        self._mark_changed()
        return 0

    def _check_value(self, number, value):
        """Return 0, or the error number of a value out of bounds, or that does not go with other settings."""
        if number not in self._table:
            return errors.STATEMENT
        _, _, _, least, most = self._table[number]
        if value < 0 <= least:
            return errors.NEGATIVE
        if number == PULSE_US and value < 3:
            return errors.STEP_PULSE
        if number == HOMING and value and not most:
            return errors.NO_HOMING
        if number == SOFT_LIMITS and value and not self.value(HOMING):
            return errors.LIMITS_NEED_HOMING
        if number == LASER and value and not self._board["spindle"]["pwm"]:
            return errors.LASER_WITHOUT_PWM
        if not least <= value <= most:
            return errors.SETTING_RANGE
        if number == JERK and 0 < value < _LEAST_JERK:
            return errors.SETTING_RANGE
        axis = number % 10
        if number in (STEPS + axis, SPEED + axis):
            steps = value if number < SPEED else self.value(STEPS + axis)
            speed = value if number >= SPEED else self.value(SPEED + axis)
            if number in (STEPS, STEPS + 1) and self._one_belt:  # both axes get them
                speed = max(self.value(SPEED), self.value(SPEED + 1))
            if steps * speed > min(self._most_steps_s, self._most_pulses_s) * 60_000_000:
                return errors.STEP_RATE
        if number == INTERVAL and value * self._most_steps_s < 1_000_000:
            return errors.STEP_RATE
        if number == PULSE_US:
            for axis in range(len(self.steps_per_m)):
                if self.value(STEPS + axis) * self.value(SPEED + axis) > self._pulses_s(value) * 60_000_000:
                    return errors.STEP_RATE
        return 0

    def _pulses_s(self, pulse_us):
        """Return the most STEP pulses of `pulse_us` that a drive can make in a second: the low level lasts as long. For coils 1 000 000."""
        return TICKS_PER_S // (2 * us_to_ticks(pulse_us)) if self._board["drive"]["kind"] == "step_dir" else 1_000_000

    def _mark_changed(self):
        """Count a new version of the settings, to be saved, and apply it to the board."""
        self.dirty = True
        self.failed = False
        self.version += 1
        self._apply_to_board()

    # --- texts

    def get(self, key):
        """Return the text kept under `key`, or None."""
        return self._texts.get(key)

    def keeps(self, text):
        """Return True if put() takes `text`: at most 80 characters on one line."""
        return len(text) <= _LONGEST_TEXT and "\n" not in text

    def put(self, key, text):
        """Keep a text of at most 80 characters, none of them a line's end. Raises ValueError for others."""
        if not self.keeps(text) or "=" in key:
            raise ValueError("no text to keep")
        if self._texts.get(key) != text:
            self._texts[key] = text
            self.dirty = True
            self.failed = False

    # --- all of them

    def restore(self, numbers, texts):
        """Reset to the board file's values: of all `numbers`, and of `texts`: 1 the places, G…, 2 all of them."""
        if numbers:
            self._changed = {}
        for key in list(self._texts):
            if texts == 2 or texts and key[0] == "G":
                del self._texts[key]
        self._mark_changed()

    def snapshot(self):
        """Return a copy of all values and texts as they count now, for save()."""
        return dict(self._changed), dict(self._texts), self.dirty

    def save(self, before=None):
        """Write changed settings and texts, while the machine stands still. Returns 0, or MEMORY: then all counts again as in the snapshot
        `before`, if there is one."""
        if self.dirty:
            try:
                text = self._dump_lines()
                try:
                    if self._writing:
                        self._writing(True)
                    self._journal.write(text)
                finally:
                    if self._writing:
                        self._writing(False)
            except (OSError, MemoryError):
                if before is not None:
                    self._changed, self._texts, dirty = before
                    self._mark_changed()
                    self.dirty = dirty
                self.failed = True
                return errors.MEMORY
            self.dirty = self.damaged = False
        return 0

    def _dump_lines(self):
        """Return the stored lines of all changed numbers and texts."""
        lines = []
        for number in sorted(self._changed):
            lines.append("%s%d=%d" % (_VERSION if number in MASKS else "", number, self._changed[number]))
        lines += ["%s=%s" % (key, self._texts[key]) for key in sorted(self._texts)]
        return "\n".join(lines)

    def _load_lines(self, text):
        """Read stored lines; a number out of bounds is dropped, an unknown one kept as a text."""
        old = []  # masks of the first firmware
        for line in text.split("\n"):
            key, _, value = line.partition("=")
            if not key:
                continue
            new = key[:2] == _VERSION
            try:
                number, amount = int(key[2:] if new else key), int(value)
            except ValueError:
                self._texts[key] = value
                continue
            rule = self._table.get(number)
            if rule is None:
                self._texts[key] = value
            elif rule[3] <= amount <= rule[4]:
                if number in MASKS and not new:
                    old.append((number, amount))
                else:
                    self._changed[number] = amount
        for number, amount in old:  # last: where there are both, that firmware has been the later one
            self._changed[number] = amount ^ self._table[number][2]
            self.dirty = True

    def _apply_to_board(self):
        """Hand the values that the board file also has to the board dict."""
        for number, axis in enumerate(self._board["axes"]):
            axis["steps_per_m"] = self.steps_per_m[number] = self.value(STEPS + number)
            axis["reversed"] = self._board_reversed[number] != bool(self.mask_change(DIRECTION_INVERT) >> number & 1)
            axis["step_inverted"] = bool(self.mask_change(STEP_INVERT) >> number & 1)
            axis["travel_steps"] = self._board_travel[number]
            if TRAVEL + number in self._changed or STEPS + number in self._changed:
                axis["travel_steps"] = self.value(TRAVEL + number) * self.value(STEPS + number) // 1_000_000
        if IDLE_DELAY in self._changed:
            delay_ms = self._changed[IDLE_DELAY]
            self._board["idle_release_ms"] = 0 if delay_ms == 255 else max(delay_ms, 1)
        else:
            self._board["idle_release_ms"] = self._board_release_ms
        self._most_pulses_s = self._board_pulses_s
        if PULSE_US in self._changed:
            self._board["drive"]["pulse_us"] = self._changed[PULSE_US]
            self._most_pulses_s = self._pulses_s(self._changed[PULSE_US])
        homing = self._board["homing"]
        if homing:
            homing["high_end"] = ""
            for number, axis in enumerate(self._board["axes"]):
                if axis["name"] in homing["sensors"] and not self.value(HOMING_DIRECTION) >> number & 1:
                    homing["high_end"] += axis["name"]
            homing["debounce_ms"] = self.value(HOMING_DEBOUNCE)

    # --- what the machine asks

    def frame(self):
        """Return the base of positions: steps/m of each axis, and a mask of the ends that they home to."""
        return self.steps_per_m[:], self.value(HOMING_DIRECTION)

    def jog_steps(self, axis):
        """Return the steps of one jog of an axis: the board file's, unless they or its steps/mm have been changed."""
        if JOG + axis in self._changed or JOG + axis in self._table and STEPS + axis in self._changed:
            um = self.value(JOG + axis)
            return max((um * self.value(STEPS + axis) + 500_000) // 1_000_000, 1 if um else 0)
        return self._board["axes"][axis]["jog_steps"] or self._board["jog"]["steps"]

    def jog_steps_s(self, axis):
        """Return the steps a second of a jog of an axis, by the same rule."""
        if JOG_SPEED + axis in self._changed or JOG_SPEED + axis in self._table and STEPS + axis in self._changed:
            return max((self.value(JOG_SPEED + axis) * self.value(STEPS + axis) + 30_000_000) // 60_000_000, 1)
        return self._board["axes"][axis]["jog_steps_s"] or self._board["speed"]["default"]

    def keep_jogs(self, steps, steps_s):
        """Keep a host's jogs of the first axes, as millimetres; values out of bounds count until the power goes."""
        for axis in range(len(steps)):
            steps_per_m = self.value(STEPS + axis)
            for number, value in (
                (JOG + axis, (steps[axis] * 1_000_000 + steps_per_m // 2) // steps_per_m),
                (JOG_SPEED + axis, (steps_s[axis] * 60_000_000 + steps_per_m // 2) // steps_per_m),
            ):
                if number in self._table and value != self.value(number):
                    self.change(number, value)

    def homing(self, axis):
        """Return (seek and locate speed in steps/s, pull-off in steps) of an axis: the board file's, where unchanged."""
        board = self._board["homing"]
        if board["each"]:
            board = dict(board)
            board.update(board["each"].get(self._board["axes"][axis]["name"], {}))
        steps_per_m = self.value(STEPS + axis)
        seek, locate, pull_off = board["seek_steps_s"], board["locate_steps_s"], board["pull_off_steps"]
        if HOMING_SEEK in self._changed:
            seek = self._changed[HOMING_SEEK] * steps_per_m // 60_000_000
        if HOMING_LOCATE in self._changed:
            locate = self._changed[HOMING_LOCATE] * steps_per_m // 60_000_000
        if HOMING_PULL_OFF in self._changed:
            pull_off = self._changed[HOMING_PULL_OFF] * steps_per_m // 1_000_000
        return max(seek, 1), max(locate, 1), max(pull_off, 1)

"""The words of a line of G-code: codes by modal group, values in nanometres. Each word is taken once."""

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.protocols.gcode.codes import AXES, CODES, G43, GROUP, GROUPS, LETTER, ON, why_unknown
from passo.protocols.gcode.words import A, F, H, L, M_CODES, P, Q, R, X, Y, Z, Words, round_half_away

MAX_LINE = const(10_000_000)
MAX_TOOL = const(255)
NONE = const(-1)
_M66 = const(1_006_600)  # as in CODES


class Refused(Exception):
    """The line is refused with the error number that is its argument."""


class Reader:
    _length_before = None  # while a line is read that changes it
    turns = 0  # bits: 1 the fourth axis, A, counts degrees; 2 an absolute word leads it by half a turn at most; 4 it homes at no sensor

    def __init__(self, axes, offsets):
        self.axes = axes
        self.offsets = offsets
        mask = ((1 << axes) - 1) << X
        self._axis_mask = mask & (1 << 26) - 1 | mask >> 26  # behind Z comes A
        self.words = Words(self._axis_mask)
        self.position = [0] * axes  # machine coordinates
        self.feed = self.tool = self.coolant = 0  # as the lines so far have them
        self._system = 0  # as this line has it
        self._found = [NONE] * GROUPS
        self._on = ()  # the line's codes that are handed on
        self._left = 0
        self._flat = 0  # the line's words of axes that the machine has not
        self._inches = False
        self.inch_feed = self._inch_feed = False  # F was given in G20: so far, and with this line

    # --- reading the line: `_left` has the words that no command has taken yet

    def _find_codes(self):
        """Sort the line's codes into `_found`, by modal group. Raises Refused."""
        words = self.words
        found = self._found
        for group in range(GROUPS):
            found[group] = NONE
        self._on = ()
        self._axis_command = False
        for index in range(words.count):
            code = words.codes[index]
            entry = CODES.get(code, NONE)
            if entry == NONE:
                raise Refused(why_unknown(code))
            if entry & AXES:
                if self._axis_command:
                    raise Refused(errors.TWO_AXIS_COMMANDS)
                self._axis_command = True
            group = entry & GROUP
            if found[group] != NONE:
                raise Refused(errors.SAME_GROUP)
            found[group] = code
            if entry & ON:
                self._on += (code,)
        # Z0 of a machine of two axes: Z stands there.
        self._flat = words.have & ~self._axis_mask & 7 << X
        for letter in (Y, Z):
            if self._flat >> letter & 1 and words.word_value(letter, 6):
                raise Refused(errors.UNSUPPORTED)
        self._left = words.have & ~self._flat

    def _take_word(self, letter):
        """Return True if the word is there; no other command may have it then."""
        if not self._left >> letter & 1:
            return False
        self._left &= ~(1 << letter)
        return True

    def _length_of(self, letter):
        """Return the word's value in nanometres, of inches exact to five decimals; of a rotary axis in millionths of a degree."""
        if self._inches and not (letter == A and self.turns):
            return self.words.word_value(letter, 5, 254)
        return self.words.word_value(letter, 6)

    def _read_count(self, letter, default, most, error):
        """Return the number behind `letter`, which counts something; `default` without it. Raises Refused with `error` above `most`."""
        if not self._take_word(letter):
            return default
        number = self.words.word_value(letter, 0)
        if number > most:
            raise Refused(error)
        return number

    # --- values

    def _read_feed(self, per_minute, wants):
        """Return (feed in nm/s, thousandths of 1/minute): one of them, the other 0. `wants`: the motion needs it. Raises Refused."""
        given = self._take_word(F)
        self._inch_feed = self._inches if given else self.inch_feed
        feed = per_min = 0
        if not per_minute:
            per_min = self.words.word_value(F, 3) if given else 0
        else:
            feed = round_half_away(self._length_of(F), 60) if given else self.feed
        if wants and not (feed or per_min):
            raise Refused(errors.NO_FEED)
        return feed, per_min

    def _read_coolant(self, code):
        """Return the coolant that the line's code switches on: 1 flood, 2 mist, 3 both."""
        if code == NONE:
            return self.coolant
        return (self.coolant | 2, self.coolant | 1, 0)[(code - M_CODES) // 100 - 7]

    def _read_dwell(self):
        """Return the dwell behind P in microseconds. Raises Refused."""
        if not self._take_word(P):
            raise Refused(errors.VALUE_MISSING)
        return self.words.word_value(P, 6)

    def _whole_number(self, letter):
        """Return the word's value. Raises Refused if it is not whole."""
        number = self.words.word_value(letter, 0)
        if self.words.word_value(letter, 3) != number * 1000:
            raise Refused(errors.NOT_INTEGER)
        return number

    def _hand_on(self, code):
        """Return the command of a code that is handed on to a feature. Raises Refused."""
        letter = CODES[code] >> LETTER
        if letter and not self._take_word(letter):
            raise Refused(errors.VALUE_MISSING)
        command = Command(commands.CODE + (code - M_CODES) // 100, value=self._whole_number(letter) if letter else 0)
        if code == _M66:
            command.power = self._whole_number(L) if self._take_word(L) else 0
            command.feed = self.words.word_value(Q, 3) if self._take_word(Q) else 0
        return command

    def _take_axes(self, old, system=None):
        """Return a copy of the offsets `old` with the values of the axis words; with `system`, the offsets that make the words the position there."""
        changed = old[:]
        for axis in range(self.axes):
            letter = (X + axis) % 26
            if self._take_word(letter):
                value = self._length_of(letter)
                changed[axis] = value if system is None else self.position[axis] - self.offsets.offset_of(system, axis) + old[axis] - value
        return changed

    def _read_length(self, code, tool):
        """Return the tool's length of G43, G43.1 or G49, nm. It counts for this line's motion; interpret_line() puts the old one back if the line is
        refused. A machine without a table keeps its length: none, or a measured one. Raises Refused."""
        offsets = self.offsets
        length = 0
        if code == 4310:
            return self._only_z()
        if code == G43:
            tool = self._read_count(H, tool, MAX_TOOL, errors.TOOL_NUMBER)
            text = offsets.length_of(tool) if tool else "0"
            length = offsets.tool if text is None else int(text)
            if text is None and [None for other in range(1, MAX_TOOL + 1) if offsets.length_of(other)]:
                raise Refused(errors.NO_SUCH_TOOL)
        self._length_before = offsets.tool
        offsets.tool = length
        return length

    def _only_z(self):
        """Return the length behind Z, nm. Raises Refused if another axis word is there."""
        if self._left & self._axis_mask != 1 << Z:
            raise Refused(errors.TOOL_LENGTH_AXIS)
        self._take_word(Z)
        return self._length_of(Z)

    def _read_offsets(self, code, axis_words):
        """Return (method of Offsets, its arguments …) for G10, G28.1, G30.1, G92 or G92.1. Raises Refused."""
        offsets = self.offsets
        if code in (2810, 3010):
            return offsets.set_home, code // 100, self.position[:]
        if code == 9210:
            return offsets.set_shift, [0] * self.axes
        if not axis_words:
            raise Refused(errors.NO_AXIS_WORDS)
        if code == 9200:
            return offsets.set_shift, self._take_axes(offsets.shift, self._system)
        if not self._take_word(P) or not self._take_word(L):
            raise Refused(errors.VALUE_MISSING)
        number = self.words.word_value(P, 0)
        if self.words.word_value(L, 0) == 1:
            if not 0 < number <= MAX_TOOL:
                raise Refused(errors.TOOL_NUMBER)
            return offsets.set_length, number, self._only_z()
        if number > 6:
            raise Refused(errors.NO_SUCH_SYSTEM)
        system = number - 1 if number else self._system
        how = self.words.word_value(L, 0)
        if how not in (2, 20) or self._left >> R & 1:
            raise Refused(errors.UNSUPPORTED)
        return offsets.set_system, system, self._take_axes(offsets.systems[system], system if how == 20 else None)

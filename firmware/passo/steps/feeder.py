"""The feeder: has each block's geometry make its next segment, writes the words to the ring, and knows where the machine is.

    block ─► geometry (which axes step) ─► pace (when) ─► drive (which pins) ─► ring ─► player

    feeder = Feeder(ring, layout, planner, drive, setup_ticks, min_word_ticks)
    feeder.fill(player.words_played(), 30 * TICKS_PER_MS)     # words until so many ticks lie ahead of the player
    feeder.position(player.words_played())                    # steps of each axis, exact at any word

It fills by time, so that what it has committed to is never more than a few milliseconds ahead. Only it writes the ring, the
checkpoints and its `state`; geometries and ramp answer "next segment" and know nothing of it. At the end of each segment it
leaves a checkpoint: words, ticks and position so far. Position is the last checkpoint played plus the words played since,
never a walk over more than one segment. Words count as free only up to that checkpoint.

fill() and all it calls may run in an interrupt: no allocation, no integer of 2³⁰. The main loop calls all others; it calls retire() and
cancel(), which drop words, only while `open` is cleared.
"""

import micropython

from passo.motion.line import MAX_RUN
from passo.records import *
from passo.steps.pace_viper import repay
from passo.steps.position import Position
from passo.steps.segments_viper import ENDED, LATER, make, retire

_ROOM = MAX_RUN + 2  # words the longest segment needs, with a change of direction before it


class Feeder(Position):
    def __init__(self, ring, layout, planner, drive, setup_ticks, min_word_ticks, burn=None, short_ticks=0):
        """`drive` turns the step form into pin levels, or is None if the pins take the step form; `setup_ticks` pass between a change of
        direction and the next step (0 without a DIR pin); `burn`: an option's function if the tool takes rows of dots; `short_ticks`: while a
        line is under way, fill() makes words this many ticks less far ahead than `lead_ticks`, so that a hold begins sooner. This does not
        hold for an arc, whose segments are too long. Default: 0."""
        Position.__init__(self, ring, layout, planner, drive)
        self.setup_ticks = setup_ticks
        self.min_word_ticks = min_word_ticks
        self.ramp = planner.ramp
        state = self.state
        state[FEED_BITS] = layout.bits
        state[FEED_AXES] = layout.axes
        state[FEED_MASK] = ring.mask
        state[FEED_LIMIT] = ring.size - _ROOM
        state[FEED_SETUP] = setup_ticks
        state[FEED_TOOL] = layout.tool_mask
        state[FEED_DRIVE] = 0 if drive is None else 1
        state[FEED_SHORT] = short_ticks
        # Two flags that app and port set each cycle, where a call would cost 10 µs; an interrupt reads them.
        self.open = True  # the main loop closes it while the motors are not ready, or while it stops the machine
        self.brake = False  # as `hold`, set by the port for as long as the main loop does not run
        self.hold = False  # see set_hold()
        self.late = 0  # times the player ran dry inside a block
        if drive is not None:
            ring.words[ring.mask] = drive.levels()  # the pins before the first word
        self._arrays = (  # fetched at once; the bound method too, which would allocate
            state, self.marks, ring.words, planner.rows, planner.scratch, planner.indices, planner.line_state, ring.power.marks,
            ring.power, ring, self.settle, burn,
        )  # fmt: skip
        self._reset(0)

    def _reset(self, played):
        """Begin anew at the word count `played`, at rest and without a block: one checkpoint at the present position."""
        self.ramp.stall()
        self.stood = False
        self._geometry = None
        state = self.state
        state[FEED_KIND] = KIND_WAIT
        state[FEED_LEFT] = state[FEED_WAIT] = state[FEED_FAST] = state[FEED_BEGINS] = 0
        state[FEED_POWER] = POWER_UNKNOWN
        state[FEED_HEAD] = played
        state[FEED_DEBT] = state[FEED_TICKS] = state[FEED_INDEX] = state[FEED_PACE] = 0
        state[FEED_OLDEST] = state[FEED_NEWEST] = 0
        marks = self.marks
        marks[MARK_WORD] = played
        marks[MARK_TICKS] = marks[MARK_INDEX] = marks[MARK_PACE] = 0
        marks[MARK_ENDS] = 1
        for axis in range(self.layout.axes):
            marks[MARK_FIELDS + axis] = state[FEED_POSITION + axis]

    # --- filling: may run in an interrupt

    @micropython.native
    def fill(self, played, lead_ticks):  # ISR: no allocation
        """Make words until `lead_ticks` are ahead of the word count `played`, or nothing is released, or no room. True where
        a block had been begun, so that the player ought not to have stood still meanwhile."""
        if not self.open:
            return False
        state, marks, words, rows, scratch, indices, path, power_marks, power, ring, settle, burn = self._arrays
        held = self.hold or self.brake
        if held and self.standing():
            self.retire(played)
            if power_marks[POWER_TAIL] != power_marks[POWER_HEAD]:
                power.play(played)
            self.stood = True
            state[FEED_POWER] = POWER_UNKNOWN
            return False
        amid = (state[FEED_LEFT] or state[FEED_WAIT]) and not self.stood
        self.stood = False
        state[FEED_DRY] = 0
        state[FEED_HOLD] = 1 if held else 0
        ramp = self.ramp
        while True:
            what = make(
                state, marks, words, rows, scratch, indices, ramp.state, path, power_marks, ramp.cut, ramp.take_up, settle, burn,
                self._geometry, played, lead_ticks,
            )  # fmt: skip
            ring.head = state[FEED_HEAD]
            if what != ENDED or held and self.standing() or not self._fetch() or held and self.standing():
                break
        if what == LATER:
            self.stood = True  # no word comes late
        if amid and state[FEED_DRY]:
            self.late += 1
        if power_marks[POWER_TAIL] != power_marks[POWER_HEAD]:
            power.play(played)
        return amid

    def set_hold(self, on):
        """Bring the machine to a stand on its path (True), or let it go on (False)."""
        self.hold = on

    def count_late(self):  # ISR: no allocation
        """Count in `late` that the player ran dry while words were made."""
        self.late += 1

    def standing(self):  # ISR: no allocation
        """Return True when a hold has come to its stand; the words already made may still be playing."""
        if not (self.hold or self.brake) or self.ramp.moving():
            return False
        state = self.state
        return not state[FEED_LEFT] or state[FEED_KIND] != KIND_INDEPENDENT or not self._geometry.rolling()

    def amid(self):  # ISR: no allocation
        """Return True while a block has been begun that has words to come."""
        state = self.state
        return bool(state[FEED_LEFT] or state[FEED_WAIT]) and not self.stood

    def retire(self, played):  # ISR: no allocation
        """Give back the room, and the blocks, of all segments that have been played to their end."""
        state = self.state
        state[FEED_PLAYED] = played
        retire(state, self.marks, self.planner.indices)

    @micropython.native
    def _fetch(self):  # ISR: no allocation
        """Take up the next block released. Returns False if there is none."""
        ramp = self.ramp
        block = self.planner.next(ramp.moving())
        if block is None:
            return False
        state = self.state
        rows = block.rows
        row = block.at
        kind = block.kind
        geometry = block.walker
        self._geometry = geometry
        state[FEED_ROW] = row
        state[FEED_KIND] = kind
        state[FEED_BEGINS] = 1
        state[FEED_FAST] = 0
        if kind == KIND_WAIT:
            state[FEED_LEFT] = 0
            state[FEED_WAIT] = rows[row + ROW_TICKS]
            ramp.stall()
        elif kind == KIND_INDEPENDENT or kind == KIND_STEP_PROGRAM:
            state[FEED_LEFT] = 1
            ramp.stall()
        else:
            ramp.begin(block)
            state[FEED_LEFT] = geometry.left
            if kind == KIND_LINE and rows[row + ROW_GAIN]:
                state[FEED_FAST] = 1
        return True

    @micropython.native
    def settle(self, at, count):  # ISR: no allocation
        """Take what is owed off words[at : at + count] and give them their drive's levels."""
        words = self.ring.words
        state = self.state
        owed = state[FEED_DEBT]
        if owed:
            debt = repay(words, at, count, state[FEED_BITS], owed, self.min_word_ticks)
            state[FEED_TICKS] = (state[FEED_TICKS] - owed + debt) & COUNT_MASK
            state[FEED_DEBT] = debt
        if self.drive is not None:
            self.drive.apply(words, at, count)

    # --- stopping: main loop only; asking is in position.py

    def cancel(self, played):
        """After the player has halted, and with `open` cleared: drop all words not played, take where they led to as truth; a hold
        ends. Returns that position. The planner keeps its blocks."""
        self.retire(played)
        self._walk(played)
        position = list(self._found)
        self.ring.head = played
        self.ring.power.clear()
        for axis in range(self.layout.axes):
            self.state[FEED_POSITION + axis] = position[axis]
        if self.drive is not None:
            self.drive.seek(position)
        levels = self.state[FEED_LEVELS]
        if self.layout.kind == "step_dir":  # directions as at the pins: the next change of one takes its set-up time from there
            levels = self.ring.words[(played - 1) & self.ring.mask]
            if self.drive is not None:
                levels = self.drive.directions(levels)
        self.state[FEED_LEVELS] = levels & self.layout.levels_mask & ~(self.layout.step_mask | self.layout.tool_mask)
        self._reset(played)
        self.hold = False
        return position

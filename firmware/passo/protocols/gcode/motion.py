"""The motions of a line of G-code: lines, arcs, probing, canned cycles, from words to commands in steps."""

from micropython import const

from passo import commands, errors
from passo.commands import Command, Motion
from passo.protocols.gcode.codes import CODES, CYCLE, G73, G80, G82, G83
from passo.protocols.gcode.reader import Reader, Refused
from passo.protocols.gcode.words import A, H, I, L, P, Q, R, X, Z, round_half_away
from passo.records import NM_PER_M

MAX_STEPS = const(0x1FFFFFFF)
_DEGREES = const(360_000_000)
_LEAST_PECK = const(10_000)  # nm
BACK_OFF_NM = const(254_000)  # 0.01 inch: the retreat of G73, and the height of G83 above the bottom of the last peck
_PLANES = {17: (0, 1), 18: (2, 0), 19: (1, 2)}
# Of a series of canned cycles: 1 for G90 + 2 for G20; the height before it, R, and Z as they were read, in the program's coordinates, nm;
# dwell; peck.
NO_CYCLE = (0, 0, 0, 0, 0, 0)


def new_moves():
    """Return motions that are used again, line after line."""
    return [Motion(commands.LINE) for _ in range(2)]


class Motions(Reader):
    def __init__(self, axes, offsets, machine):
        Reader.__init__(self, axes, offsets)
        self.machine = machine
        self.commands = []
        self.laser = False
        self.max_rpm = 1_000_000  # thousandths of a turn a minute, as all spindle speeds
        self.motion = 0
        self.cycle = self._cycle = NO_CYCLE
        self._absolute = self._initial = True  # as this line has them
        self._plane = 17
        self._steps = [0] * axes
        self._moves = new_moves()

    # --- where the machine is

    def _take_position(self):
        """Take the position from the machine's target, if anything else has moved it."""
        target = self.machine.target
        steps = self._steps
        for axis in range(self.axes):
            if steps[axis] != target[axis]:
                steps[axis] = target[axis]
                self.position[axis] = round_half_away(target[axis] * NM_PER_M, self.machine.steps_per_m[axis])

    def _to_steps(self, target):
        """Return `target`, nm, in steps. An axis that it leaves out stays where it is. Raises Refused."""
        steps = [round_half_away(target[axis] * self.machine.steps_per_m[axis], NM_PER_M) for axis in range(len(target))]
        if max(steps) > MAX_STEPS or min(steps) < -MAX_STEPS:
            raise Refused(errors.JOG_TRAVEL)
        return steps + self._steps[len(steps) :]

    def _read_target(self, machine_coordinates):
        """Return the target of the line's axis words, nm in machine coordinates."""
        target = self.position[:]
        for axis in range(self.axes):
            letter = (X + axis) % 26
            if self._take_word(letter):
                value = self._length_of(letter)
                if machine_coordinates:
                    target[axis] = value
                elif self._absolute:
                    target[axis] = value + self.offsets.offset_of(self._system, axis)
                else:
                    target[axis] += value
                if self.turns & 2 and axis == 3 and (self._absolute or machine_coordinates):
                    back = self.position[axis] - target[axis]
                    if abs(back) > _DEGREES // 2:
                        target[axis] += (back + _DEGREES // 2) // _DEGREES * _DEGREES
        return target

    # --- motion

    def _set_shared(self, motion, feed, per_min, number, spindle, rpm):
        """Set the fields that every motion of this line shares: feed in nm/s, 1/min in thousandths, line number, tool and power."""
        self._feed, self._per_min, self._number = feed, per_min, number
        self._cutting = 100 <= motion <= 300
        self._lit = spindle != 5 and rpm > 0 and (self._cutting or not self.laser)
        self._dynamic = self.laser and spindle == 4
        self._power = min(rpm * 1_000_000 // self.max_rpm, 1_000_000) if self._lit else 0

    def _add_motion(self, kind, target, feed):
        """Append the motion to `target`, nm, at `feed` nm/s (0: rapid) to `commands`. Returns it."""
        at = len(self.commands)
        command = self._fill_motion(self._moves[at] if at < len(self._moves) else Motion(kind), target, feed)
        command.kind = kind
        self.commands.append(command)
        return command

    def _go_to(self, kind, target, feed):
        """As _add_motion(); the line's next command starts there, too."""
        command = self._add_motion(kind, target, feed)
        self.position, self._steps = target, command.target
        return command

    def _fill_motion(self, command, target, feed):
        """Fill in a motion of this line. Returns it. Raises Refused."""
        command.target = self._to_steps(target)
        command.feed = feed
        command.per_min = self._per_min if feed else 0
        command.number = self._number
        command.tool = self._lit
        command.power = self._power
        command.dynamic = self._dynamic
        return command

    def _angular_feed(self, target, feed):
        """Return the feed of a line whose F was given in G20: degrees a minute, not inches, if only the rotary axis moves."""
        return round_half_away(feed * 10, 254) if target[:3] == self.position[:3] else feed

    def _read_motion(self, motion, axis_words, machine_coordinates):
        """Append the line's motion, of code `motion`. Returns its end, nm; None if the line has nothing to move. Raises Refused."""
        if motion == G80:
            raise Refused(errors.AXIS_WORDS_UNUSED)
        if motion >= 200 and not axis_words and not self._gives_sweep(motion):
            raise Refused(errors.NO_AXIS_WORDS)
        if not axis_words and motion < 200:
            return None
        if CODES[motion] & CYCLE:
            return self._read_cycle(motion)
        if motion in (200, 300):
            return self._read_arc(motion == 200)
        target = self._read_target(machine_coordinates)
        if self.turns and self._inch_feed:
            self._feed = self._angular_feed(target, self._feed)
        if motion > 300:
            if target == self.position:
                raise Refused(errors.TARGET)
            command = self._add_motion(commands.PROBE, target, self._feed or 1)
            command.value = (1 if motion >= 3840 else 0) | (2 if motion in (3830, 3850) else 0)
        else:
            self._add_motion(commands.LINE, target, (self._feed or 1) if motion else 0)
        return target

    def _gives_sweep(self, motion):
        """Return True if the line gives an arc's angle, H, instead of its end. An extension."""
        return motion in (200, 300) and self._left >> H & 1

    def _read_arc(self, clockwise):
        """Append the arc of G2 or G3. Returns its end, nm. Raises Refused."""
        first, second = _PLANES[self._plane]
        if max(first, second) >= self.axes:
            raise Refused(errors.UNSUPPORTED)
        arcs = self.machine.arcs
        if arcs is None:
            raise Refused(errors.NO_MEMORY)
        in_plane = 1 << first | 1 << second
        swept = self._take_word(H)
        if swept == bool(self._left >> X & in_plane):
            raise Refused(errors.AXIS_WORDS_UNUSED if swept else errors.NO_AXIS_IN_PLANE)
        start = self.position
        target = self._read_target(False)
        if target[3:] != start[3:]:
            raise Refused(errors.UNSUPPORTED)
        across, along = target[first] - start[first], target[second] - start[second]
        sweep = self.words.word_value(H, 6) if swept else 0
        radius = None
        error = 0
        if not swept and self._take_word(R):
            radius = self._length_of(R)
            error, i, j = arcs.centre_of(across, along, radius, clockwise)
        elif self._left >> I & in_plane:
            i, j = [self._length_of(I + axis) if self._take_word(I + axis) else 0 for axis in (first, second)]
            self._take_word(I + 3 - first - second)  # along the third axis: ignored, as grbl does; FreeCAD writes K0 in XY
            if not swept:
                error = arcs.check_centre(across, along, i, j)
            elif not sweep or not (i or j):
                error = errors.TARGET
        else:
            error = errors.NO_CENTRE
        if error:
            raise Refused(error)
        turns = 1
        if swept:
            across, along = arcs.end_of(i, j, sweep, clockwise)
            target[first], target[second] = start[first] + across, start[second] + along
            turns = (sweep - 1) // _DEGREES + 1
            over_half = (sweep - 1) % _DEGREES >= _DEGREES // 2
        else:
            over_half = arcs.over_half(across, along, i, j, clockwise) if radius is None else radius < 0
            if self._take_word(P):
                turns = self._whole_number(P)
                if turns < 1:
                    raise Refused(errors.NOT_INTEGER)
        command = self._add_motion(commands.ARC, target, self._feed or 1)
        centre = start[:]
        centre[first] += i
        centre[second] += j
        centre = self._to_steps(centre)
        command.first, command.second, command.clockwise, command.turns = first, second, clockwise, turns
        command.over_half = over_half
        command.centre = (centre[first] - self._steps[first], centre[second] - self._steps[second])
        return target

    def _go_home(self, number, axis_words):
        """Append the motions of G28 or G30: by way of the axis words, if there are any; then only those axes go on. Returns the end, nm."""
        stored = self.offsets.homes[number]
        target = stored[:]
        if axis_words:
            between = self._read_target(False)
            self._add_motion(commands.LINE, between, 0)
            target = [stored[axis] if axis_words >> (X + axis) % 26 & 1 else between[axis] for axis in range(self.axes)]
        self._add_motion(commands.LINE, target, 0)
        return target

    def _read_cycle(self, motion):
        """G73, G81, G82, G83, an extension; returns where it ends. `commands` are the way to the tops and bottoms of the first and the
        last hole, for the machine to check; `_drilling` makes those after the first, one by one: a hole of many
        pecks as a list would be more than a board has room for. As LinuxCNC's rs274: G98 goes back to the height before the first
        line of the series, whatever was between, and goes to the hole there. R and Z mean another place if G90 or G20 changes: such a line
        is refused without both."""
        if self.axes < 3 or self._left & 1 << A or self._plane != 17:
            raise Refused(errors.UNSUPPORTED)
        pecks = motion in (G73, G83)
        known, level, top, depth, dwell, peck = self.cycle
        modes = (1 if self._absolute else 0) | (2 if self._inches else 0)
        other = 3 if self.motion != motion else modes ^ known
        if other and (1 << R | 1 << Z | (pecks and other > 1) << Q) & ~self._left:
            raise Refused(errors.VALUE_MISSING)
        x, y, z = self.position[:3]
        zero = self.offsets.offset_of(self._system, 2)
        if not CODES.get(self.motion, 0) & CYCLE:
            level = z - zero
        if self._take_word(R):
            top = self._length_of(R)
        if self._left >> Z & 1:
            depth = self._length_of(Z)
        target = self._read_target(False)
        above = top + zero + (0 if self._absolute else level)
        bottom = depth + (zero if self._absolute else above)
        if pecks and self._take_word(Q):
            peck = self._length_of(Q)
            if peck < _LEAST_PECK:
                raise Refused(errors.NUMBER_RANGE)
        if motion == G82 and self._take_word(P):
            dwell = self.words.word_value(P, 6)
            if dwell < 0:
                raise Refused(errors.NEGATIVE)
        times = self._whole_number(L) if self._take_word(L) else 1
        if not 1 <= times <= 100 or bottom > above:
            raise Refused(errors.TARGET)
        back = max(level + zero, above) if self._initial else above
        way = (target[0] - x, target[1] - y, 0 if self._absolute else 1)
        if z < above:
            self._add_motion(commands.LINE, [x, y, above], 0)
        for hole in (1, times if way[2] else 1):
            for height in (max(z, back), bottom, back):
                self._add_motion(commands.LINE, [x + hole * way[0], y + hole * way[1], height], (self._feed or 1) if height == bottom else 0)
        self._drilling = self._drill_holes((x, y, z), way, times, (above, bottom, back), motion, dwell, peck)
        next(self._drilling)  # the first of `commands`
        self._cycle = modes, level, top, depth, dwell, peck
        return [x + hole * way[0], y + hole * way[1], back] + self.position[3:]

    def _drill_holes(self, start, way, times, heights, motion, dwell, peck):
        """Yield all commands of a cycle, then None."""
        x, y, z = start
        above, bottom, back = heights
        height = max(z, back)
        if z < above:
            yield 0
        for hole in range(times):
            if not hole or way[2]:
                x += way[0]
                y += way[1]
            yield self._fill_motion(Motion(commands.LINE), [x, y, height], 0)
            yield self._fill_motion(Motion(commands.LINE), [x, y, above], 0)
            reached = above - peck
            while motion in (G73, G83) and reached > bottom:
                yield self._fill_motion(Motion(commands.LINE), [x, y, reached], self._feed or 1)
                if motion == G83:
                    yield self._fill_motion(Motion(commands.LINE), [x, y, above], 0)
                yield self._fill_motion(Motion(commands.LINE), [x, y, min(above, reached + BACK_OFF_NM)], 0)
                reached -= peck
            yield self._fill_motion(Motion(commands.LINE), [x, y, bottom], self._feed or 1)
            if motion == G82 and dwell:
                yield Command(commands.DWELL, value=dwell)
            height = back
            yield self._fill_motion(Motion(commands.LINE), [x, y, height], 0)
        yield None

"""Runs a job of G-code on the virtual port as fast as it can, without a model of the machine, and says what it would do.

    job = VirtualJob("router_3axis")
    job.run([(1, b"G21"), (2, b"G1X10F600")])
    job.seconds, job.low, job.high, job.errors

It starts at machine zero, unlocked, soft limits off: where the job's box lies on a machine is not known. With `zero`, where
the program's zero lies on the homed machine, soft limits are on.
Pauses for the operator are noted in `pauses` and resumed at once; their time counts for nothing. There is nothing that a
probe could touch: what probes goes its whole way, and is noted in `probes`. $ lines other than settings and jogs are no
part of a job: they are noted in `skipped`.
"""

from host_tools import boards
from host_tools.failure import Failure

TICKS_PER_S = 12_500_000
WINDOW = 120  # bytes under way
SPEED_TICKS = TICKS_PER_S // 50  # speeds are measured over 20 ms
_LIMITLESS_TURNS = 2_000_000  # without an answer: 4 hours of a dwell


class Track:
    """The world of a board that nothing is wired to but its motors: follows their pins."""

    def __init__(self, layout, drive, steps_per_mm, by_height):
        """`by_height`: what is below Z0 of the program, `surface` in mm, is drawn as cut, whether the tool is on or not."""
        self.by_height = by_height
        self.surface = 0.0
        self._layout = layout
        self._drive = drive
        axes = layout.axes
        self._steps_per_mm = steps_per_mm
        self._before = drive.levels() if drive else 0
        self.place = [0] * axes
        self.low = [0] * axes
        self.high = [0] * axes
        self.steps = 0
        self.last_tick = 0
        self.strokes = [(False, [tuple([0.0] * axes)])]
        self.fastest = [0.0] * axes  # mm/min
        self.samples = []  # (seconds, mm/min along the path, mm/min of each axis) over 20 ms or more up to then
        self._window = (0, tuple(self.place))

    def attach(self, tick, names, levels):
        pass

    def edges(self, tick, levels, changed):
        layout = self._layout
        lit = bool(levels & layout.tool_mask)
        moved = False
        for axis in range(layout.axes):
            if self._drive is not None:
                step = self._drive.moved(axis, self._before, levels & (layout.tool_mask - 1))
            elif (changed & levels) >> axis & 1:
                step = 1 if levels >> (layout.axes + axis) & 1 else -1
            else:
                continue
            if step:
                self.place[axis] += step
                self.low[axis] = min(self.low[axis], self.place[axis])
                self.high[axis] = max(self.high[axis], self.place[axis])
                moved = True
        if self._drive is not None:
            self._before = levels & (layout.tool_mask - 1)
        if moved:
            self.steps += 1
            self.last_tick = tick
            self._draw(lit)
            if tick - self._window[0] >= SPEED_TICKS:
                self._measure(tick)

    def _draw(self, lit):
        """Append the position to the picture, each tenth of a millimetre: all steps would be too many."""
        here = tuple(place / scale for place, scale in zip(self.place, self._steps_per_mm))
        kind, places = self.strokes[-1]
        lowered = here[2] < self.surface if self.by_height else lit
        if kind != lowered:
            self.strokes.append((lowered, [places[-1], here]))
        elif max(abs(a - b) for a, b in zip(here, places[-1])) >= 0.1:
            places.append(here)

    def accelerations(self):
        """(seconds, mm/s² of each axis): from each sample to the next."""
        found = []
        for (began, _, before), (_, _, after), middle in zip(self.samples, self.samples[1:], self._middles()):
            found.append((began, [(new - old) / 60 / middle for new, old in zip(after, before)]))
        return found

    def _middles(self):
        """Seconds from the middle of each sample to that of the next."""
        times = [0.0] + [seconds for seconds, _, _ in self.samples]
        return [(later - earlier) / 2 for earlier, later in zip(times, times[2:])]

    def _measure(self, tick):
        began, place = self._window
        minutes = (tick - began) / TICKS_PER_S / 60
        moved = [(now - then) / scale for now, then, scale in zip(self.place, place, self._steps_per_mm)]
        for axis, along in enumerate(moved):
            self.fastest[axis] = max(self.fastest[axis], abs(along) / minutes)
        speeds = [along / minutes for along in moved]
        self.samples.append((tick / TICKS_PER_S, sum(speed * speed for speed in speeds) ** 0.5, speeds))
        self._window = (tick, tuple(self.place))

    def output(self, tick, name, level):
        pass

    def run(self, tick):
        pass

    def next_event(self):
        return None


def _is_order(line):
    """True of $H, $X, $C and the like."""
    return line[:1] == b"$" and not line[1:2].isdigit() and line[1:2] not in b"Jj"


def fits(under_way, line):
    """True if `line` may be sent too. Probing is sent alone: the alarm at its end would refuse the next lines."""
    if under_way and (b"G38" in line.upper() or b"G38" in under_way[-1][1].upper()):
        return False
    return sum(len(sent) + 1 for _, sent in under_way) + len(line) < WINDOW


class VirtualJob:
    def __init__(self, board, changes=(), zero=None):
        """`changes`: $ lines carried out first, as text; `zero`: mm from machine zero, a figure an axis. Raises Failure if the
        board file cannot be used, or `zero` is not on the machine."""
        from passo.app import App
        from passo.config.boardfile import BoardError, check
        from passo.machine_builder import make_drive
        from passo.ports.virtual import VirtualPort

        try:
            checked = check(boards.load(board))
        except BoardError as error:
            raise Failure(str(error)) from error
        self.board = checked
        layout, drive, _ = make_drive(checked)
        self.steps_per_mm = [axis["steps_per_m"] / 1000 for axis in checked["axes"]]
        by_height = len(self.steps_per_mm) > 2 and not checked["spindle"]["laser"]
        self.track = Track(layout, drive, self.steps_per_mm, by_height)
        resting = {item["name"]: 1 - item["active"] for item in checked["inputs"]}
        self.track.input = lambda tick, name: resting[name]
        checked["links"] = [{**checked["links"][0], "protocol": "grbl"}]
        self._port = VirtualPort(checked, self.track)
        self._app = App(checked, self._port)
        self._line = self._port.serial(checked["links"][0])
        self.errors = []  # (line of the file, its text, what was wrong)
        self.pauses = []  # (line of the file, its text)
        self.probes = []  # the same
        self.skipped = []
        self.seconds = 0.0
        self._line.incoming += b"$X\n$20=0\n" + b"".join(change.encode() + b"\n" for change in changes)
        for _ in range(50):
            self._app.cycle()
        self.placed = zero is not None
        if zero is not None:
            self._place(zero)
            self.track.surface = zero[2] if len(zero) > 2 else 0.0
        self._line.outgoing = b""

    def _place(self, zero):
        """The machine has homed and the operator has set G54."""
        names = [axis["name"].upper() for axis in self.board["axes"]]
        if not self.board["homing"]:
            raise Failure(f"{self.board['name']} does not home: it has no soft limits")
        if len(zero) != len(names):
            raise Failure(f"the machine has {len(names)} axes, {', '.join(names)}, and {len(zero)} places are given")
        for number, (name, place) in enumerate(zip(names, zero)):
            low, high = (end / self.steps_per_mm[number] for end in self._app.controller.queue.reach(number))
            if not low <= place <= high:
                raise Failure(f"{name}{place:g} is not on the machine, which goes from {low:g} to {high:g} mm")
        self._app.controller.machine.homed = True
        words = "".join(f"{name}{place:.4f}" for name, place in zip(names, zero))
        self._line.incoming += b"$20=1\nG21G10L2P1" + words.encode() + b"\n"
        for _ in range(50):
            self._app.cycle()

    def run(self, lines, progress=None):
        """Execute [(number, bytes)] to the end of their motion. Calls `progress(number)` now and then."""
        self.skipped = [(number, line.decode()) for number, line in lines if _is_order(line)]
        waiting = [(number, line) for number, line in reversed(lines) if not _is_order(line)]
        under_way = []
        idle_turns = 0
        while waiting or under_way:
            while waiting and fits(under_way, waiting[-1][1]):
                number, line = waiting.pop()
                under_way.append((number, line))
                self._line.incoming += line + b"\n"
            if self._app.controller.state == "hold":
                self._resume(under_way)
            self._turn()
            idle_turns += 1
            for said in self._said():
                idle_turns = 0
                self._answer(said, under_way)
            if idle_turns > _LIMITLESS_TURNS:
                raise Failure(f"line {under_way[0][0]} was never answered")
            if progress and under_way:
                progress(under_way[0][0])
        while not self._app.controller.queue.still():
            self._turn()
        self.seconds = self.track.last_tick / TICKS_PER_S

    def _resume(self, under_way):
        """Act as the operator in a pause: the oldest line without an answer asked for it."""
        paused = (under_way[0][0], under_way[0][1].decode()) if under_way else None
        if paused and paused not in self.pauses[-1:]:
            self.pauses.append(paused)
        self._line.incoming += b"~"

    def _turn(self):
        self._app.cycle()

    def _said(self):
        data = self._line.outgoing
        self._line.outgoing = b""
        return data.decode().split("\r\n")

    def _answer(self, said, under_way):
        from passo import error_texts

        if said.startswith("ALARM:"):
            self._note_alarm(int(said[6:]), under_way)
        if said == "ok" or said.startswith("error:"):
            if not under_way:
                return
            number, line = under_way.pop(0)
            if said != "ok":
                code = int(said[6:])
                self.errors.append((number, line.decode(), f"error {code}, {error_texts.text(code)}"))

    def _note_alarm(self, number, under_way):
        from passo import error_texts, errors

        line, text = under_way[0] if under_way else (0, b"")
        if number + 200 in errors.NEED_RESET:
            raise Failure(f"line {line}, {text.decode()}: alarm {number}, {error_texts.text(200 + number)}")
        if number + 200 in (errors.ALARM_PROBE_STATE, errors.ALARM_PROBE_MISSED):
            self.probes.append((line, text.decode()))
        else:
            self.errors.append((line, text.decode(), f"alarm {number}, {error_texts.text(200 + number)}"))
        under_way.append((line, b"$X"))
        self._line.incoming += b"$X\n"

    @property
    def low(self):
        """Lowest position of each axis in mm."""
        return [place / scale for place, scale in zip(self.track.low, self.steps_per_mm)]

    @property
    def high(self):
        return [place / scale for place, scale in zip(self.track.high, self.steps_per_mm)]

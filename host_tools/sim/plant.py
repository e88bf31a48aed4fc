"""The plant: a model of the machine. It sees only the firmware's pins, by name and time.

    plant = Plant(board, start=(0, 0), bounce_ms=4, faults={"barrier_x": "dead"}, seed=1)
    port = VirtualPort(board, plant)

Motor decoders turn pins back into steps, carriages travel between hard ends, slotted barriers watch them, and the
pen's solenoid has its delay. Times are ticks of 80 ns. Positions are steps from the *nominal* origin: the position after
homing on a barrier that switches exactly at its edge. An axis that homes at its high end has its barrier there. `errors` records all motions that a
real machine could not have followed. Motors and encoders may fail:

    plant.stall_motor("x", 5)         # the next five steps of X are lost
    plant.slip_motor("x2", -3)
    plant.lose_counts("y", 20)

The board file gives axes, drive, polarity, travel and pen delays; options give the rest:

    start        steps from the nominal origin, one number an axis; None: random within reach, by `seed`, or in the middle
                 if nothing homes
    bounce_ms    barriers chatter for up to this long after each change
    faults       {input: text}, of any input: see input_faults.py
    racked       steps that the second side of a gantry stands beyond the first
    seed         of all that is random
    stock        a Stock that the tool can touch: the input probe is active meanwhile
    play         {axis: steps of the motor that its carriage does not follow where it turns}
    stalls       seed of what drivers feel that have `stall`: see slipping.py
"""

import random

from host_tools.sim.belt import Belt
from host_tools.sim.decoders import StepDir, make_decoder
from host_tools.sim.input_faults import InputFaults, Moments
from host_tools.sim.parts import MARGIN_MM, NEVER, Barrier, Carriage, Encoder, Noise, Solenoid, Spindle, hard_ends, pull_off_of
from host_tools.sim.slipping import Slipping

TICKS_PER_MS = 12_500
MAX_ERRORS = 1000  # kept by `errors`; `error_count` goes on


class Plant:
    def __init__(self, board, start=None, bounce_ms=0, faults=None, seed=0, racked=0, stock=None, play=None, stalls=0):
        self._random = random.Random(seed)
        self.errors = []  # (tick, text)
        self.error_count = 0
        self.position = [0] * len(board["axes"])  # of each carriage, in steps; the list itself is kept
        self.tool = 0  # 0 … 1000, once it has arrived
        self.trace = None  # told row(tick, position, tool) at each step and each arrival of the tool
        self.pins = None  # its note_input(tick, name, level) is called at each change of an input
        self._listeners = []  # called with the same
        self._board = board
        self.stock = stock
        self._power = 0 if (board.get("spindle") or {}).get("pwm") else 1000
        self._actives = {item["name"]: item.get("active", 1) for item in board.get("inputs", ())}  # their levels while active
        self._levels = {name: 1 - active for name, active in self._actives.items()}
        # Outputs that give motors their current: by name, the level that does; and those that do not yet.
        self._enables = {item["name"]: item.get("active", 1) for item in board.get("outputs", ()) if item["name"].startswith("enable")}
        self._without = set(self._enables)
        self.enabled = not self._without
        # Relays that bring this board's signals to the drivers: by name, the level that closes them; and those still open.
        outputs = board.get("outputs", ())
        self._relays = {item["name"]: item.get("active", 1) for item in outputs if item.get("role") == "ours"}
        self._open_relays = set(self._relays)
        self._due = NEVER
        self._build_carriages(start, play or {})
        self._build_gantry(racked)
        self._build_barriers(bounce_ms)
        if getattr(board.get("additions"), "stalls", ""):
            self._belt = self.slipping = Slipping(self, board, stalls)
        self.encoders = {}  # by motor, in the board file's order
        for item in self._board.get("encoders", ()):
            motor = self._carriage_of(item["motor"])
            self.encoders[item["motor"]] = Encoder(motor, item["pulses"], item["steps"], -1 if item["reversed"] else 1)
        self._in_order = list(self.encoders.values())
        self._indexes = [(item["index"], self.encoders[item["motor"]]) for item in self._board.get("encoders", ()) if item["index"]]
        self._rest_inputs()
        self.noise = {}  # {name: Noise injected on this input}
        self._solenoid = Solenoid(
            board["tool"].get("on_ms", 0) * TICKS_PER_MS, board["tool"].get("off_ms", 0) * TICKS_PER_MS
        )
        tachometer = board.get("tachometer")
        self.spindle = Spindle(tachometer["pulses"], board["spindle"]["max_rpm"]) if tachometer else None
        self._parts = list(self.barriers.values()) + [self._solenoid]
        self._faults = InputFaults(board["inputs"], self.barriers, faults or {}, self._random)
        self._parts += self._faults.moments
        for name, ticks in self._faults.bounces:
            self.inject_noise(name, ticks)
        self._plan_next()
        self._decoders = []
        self._tool_mask = 0

    def _build_carriages(self, start, play):
        """Build a carriage for each axis, at `start` (steps), else at random, or in the middle if it cannot home. Raises ValueError if `start` does
        not fit."""
        axes = self._board["axes"]
        if start is not None and len(start) != len(axes):
            raise ValueError(f"start: {len(axes)} positions are wanted, one an axis, not {len(start)}")
        homing = self._board.get("homing") or {}
        self.carriages = []
        for i, axis in enumerate(axes):
            low, high = hard_ends(self._board, axis)
            at = self._random.randint(low, high)
            if start is not None:
                at = start[i]
            elif axis["name"] not in homing.get("sensors", ()):
                at = (low + high) // 2  # it cannot home: give it room on both sides
            if not low <= at <= high:
                raise ValueError(f"start: {axis['name']} {at} is not between the hard ends {low} and {high}")
            self.carriages.append(Carriage(axis["name"], at, low, high, self.report, play.get(axis["name"], 0)))
            self.position[i] = at
        self._belt = Belt(self) if self._board.get("kinematics") == "corexy" else None
        self.slipping = None

    def _build_gantry(self, racked):
        """Build the second side of a gantry: a carriage of its own, as far as the frame lets it."""
        self.second = self._watching_second = None
        self._gantry = gantry = self._board.get("gantry")
        self._second_mask = 0
        if gantry:
            self._gantry_axis = [axis["name"] for axis in self._board["axes"]].index(gantry["axis"])
            first = self.carriages[self._gantry_axis]
            low, high = min(first.low, first.position + racked), max(first.high, first.position + racked)
            self.second = Carriage(first.name + "2", first.position + racked, low, high, self.report)

    def skew_steps(self):
        """Return the steps by which the second side of a gantry stands beyond the first."""
        return self.second.position - self.carriages[self._gantry_axis].position

    def _build_barriers(self, bounce_ms):
        """Build the sensors of homing, the gantry's second one, and the limit switches MARGIN_MM / 2 inside the hard ends."""
        homing = self._board.get("homing") or {}
        names = [axis["name"] for axis in self._board["axes"]]
        self.barriers = {}
        self._watching = [None] * len(names)  # the barrier of each axis
        self._others = {}  # of an axis with more of them
        for axis, sensor in homing.get("sensors", {}).items():
            if axis in getattr(self._board.get("additions"), "stalls", ""):
                continue  # its driver feels the hard end
            high = axis in homing.get("high_end", "")
            edge = pull_off_of(homing, axis)
            barrier = Barrier(
                sensor,
                edge if high else -edge,
                self.position[names.index(axis)],
                bounce_ms * TICKS_PER_MS,
                random.Random(self._random.random()),
                high,
            )
            self._add_barrier(sensor, names.index(axis), barrier)
            if self._gantry and self._gantry.get("sensor") and axis == self._gantry["axis"]:
                offset = self._gantry.get("offset_steps", 0)
                self._watching_second = Barrier(
                    self._gantry["sensor"], edge + offset if high else -edge - offset, self.second.position,
                    bounce_ms * TICKS_PER_MS,
                    random.Random(self._random.random()), high,
                )  # fmt: skip
                self.barriers[self._gantry["sensor"]] = self._watching_second
                self._levels[self._gantry["sensor"]] = self._barrier_level(self._watching_second, 0)
        margin = MARGIN_MM // 2
        for direction, limit in ((self._board.get("interlock") or {}).get("limits") or {}).items():
            if limit in self.barriers:
                continue  # home and limit on one switch
            number = names.index(direction[0])
            high = direction[1] == "+"
            carriage = self.carriages[number]
            beyond = self._board["axes"][number]["steps_per_m"] * margin // 1000
            edge = carriage.high - beyond if high else carriage.low + beyond
            barrier = Barrier(
                limit, edge, self.position[number], bounce_ms * TICKS_PER_MS,
                random.Random(self._random.random()), high,
            )  # fmt: skip
            self._add_barrier(limit, number, barrier)

    def _rest_inputs(self):
        """Activate the inputs that the machine's interlock needs at rest: a drive is good, the selector stands at this board."""
        section = self._board.get("interlock")
        if not section:
            return
        masks = self._board["additions"].masks
        for number, item in enumerate(self._board["inputs"]):
            if masks["fall"] >> number & 1 and not masks["rise"] >> number & 1:
                self._levels[item["name"]] = item["active"]

    # --- wired to the pins: see passo.ports.virtual for these methods' meaning

    def attach(self, tick, names, levels):
        """Wire the drives to the player's pins by their names. Nothing moves before the first edge."""
        drive = self._board["drive"]
        kind = drive["kind"]
        mode = drive.get("mode", "half")
        bit = {name: number for number, name in enumerate(names)}
        inverted = 0 if drive.get("step_active", 1) else sum(1 << bit[name] for name in names if name.endswith("_step"))
        self._decoders = []
        for axis in self._board["axes"]:
            name = axis["name"]
            if kind == "step_dir":
                step, direction = bit[name + "_step"], bit[name + "_dir"]
                polarity = inverted | (1 << direction if axis.get("reversed") else 0)
                times = drive.get("pulse_us", 2), drive.get("setup_us", 5)
                decoder = StepDir(step, direction, polarity, *times, self.report)
            else:
                decoder = make_decoder(kind, mode, name, bit, self.report)
            self._decoders.append(decoder)
        if self._gantry:
            self._attach_second(bit, inverted)
        # A coil motor mounted the other way round turns backward by the same sequence.
        mirrored = [kind != "step_dir" and axis.get("reversed", False) for axis in self._board["axes"]]
        self._signs = [-1 if turned else 1 for turned in mirrored]
        self._tool_mask = 1 << bit["tool"]
        self._tool_off = 0 if self._board["tool"].get("active", 1) else self._tool_mask
        self._axes = list(
            zip(
                range(len(self.position)),
                [decoder.mask for decoder in self._decoders],
                [decoder.decode for decoder in self._decoders],
                self._signs,
                self.carriages,
                self._watching,
            )
        )

    def _attach_second(self, bit, inverted):
        """Make the decoder of the gantry's second motor, from the pins of its step and direction."""
        name = self.second.name
        step, direction = bit[name + "_step"], bit[name + "_dir"]
        reversed_axis = self._board["axes"][self._gantry_axis].get("reversed", False)
        polarity = inverted | (1 << direction if reversed_axis != self._gantry.get("opposite", False) else 0)
        times = self._board["drive"].get("pulse_us", 2), self._board["drive"].get("setup_us", 5)
        self._second_decoder = StepDir(step, direction, polarity, *times, self.report)
        self._second_mask = self._second_decoder.mask

    def _move_second(self, tick, levels, changed):
        """Move the gantry's second side by the steps of an edge, and switch its sensor if it crosses it."""
        steps = self._second_decoder.decode(tick, levels, changed)
        barrier = self._watching_second
        if steps and self._move_carriage(tick, self.second, steps) and barrier is not None:
            if (self.second.position <= barrier.last) != barrier.below:
                barrier.cross_edge(tick)
                self._show_barrier(tick, barrier)

    def edges(self, tick, levels, changed):
        """Take new levels of the player's pins at `tick`; `changed`: a mask of the bits that are new. Called by the port."""
        if tick >= self._due:
            self.run(tick)
        moved = False
        for i, mask, decode, sign, carriage, barrier in self._axes:
            if changed & mask:
                steps = decode(tick, levels, changed)
                if self._belt and i in self._belt.motors and steps:
                    moved = self._belt.turn_motor(tick, i, steps * sign) or moved
                elif steps and self._move_carriage(tick, carriage, steps * sign):
                    moved = True
                    self.position[i] = at = carriage.position
                    if barrier is not None and (at <= barrier.last) != barrier.below:
                        barrier.cross_edge(tick)
                        self._show_barrier(tick, barrier)
                    if i in self._others:
                        self._cross_barriers(tick, self._others[i], at)
        for name, encoder in self._indexes:
            if encoder.index_passed():
                self.set_input(tick, name, True)
                self.set_input(tick, name, False)
        if changed & self._second_mask:
            self._move_second(tick, levels, changed)
        if moved and self.trace is not None:
            self.trace.add_row(tick, self.position, self.tool)
        if moved and self.stock is not None:
            self.set_input(tick, "probe", not self.tool and self.stock.touches(self.position))
        if changed & self._tool_mask:
            self._solenoid.switch_coil(tick, levels & self._tool_mask != self._tool_off)
            self._plan_next()

    def move_axis(self, tick, axis, steps):
        """Move the carriage of an axis by steps, and its barriers. Returns True if it moved."""
        carriage = self.carriages[axis]
        if not self._move_carriage(tick, carriage, steps):
            return False
        self.position[axis] = carriage.position
        self._cross_barriers(tick, [self._watching[axis]] + self._others.get(axis, []), carriage.position)
        return True

    def _cross_barriers(self, tick, barriers, at):
        """Switch the sensors whose edge the carriage has crossed on its way to position `at` (steps)."""
        for barrier in barriers:
            if barrier is not None and (at <= barrier.last) != barrier.below:
                barrier.cross_edge(tick)
                self._show_barrier(tick, barrier)

    def _add_barrier(self, name, axis, barrier):
        """Add a barrier that watches an axis, which may have one at either end."""
        self.barriers[name] = barrier
        if self._watching[axis] is None:
            self._watching[axis] = barrier
        else:
            self._others.setdefault(axis, []).append(barrier)
        self._levels[name] = self._barrier_level(barrier, 0)

    def encoder(self, number):
        """Counts of the board file's encoder `number`."""
        return self._in_order[number].count

    def power(self, tick, level):
        """The tool's analogue power, which counts while the tool is on."""
        self._power = level
        if self._solenoid.value:
            self._apply_tool(tick)

    def servo(self, tick, us):
        """Move the servo's arm to the height of pulses of `us` microseconds."""
        up, down = self._board["servo"]["up_us"], self._board["servo"]["down_us"]
        self.tool = 1000 * (us - up) // (down - up)
        if self.trace is not None:
            self.trace.add_row(tick, self.position, self.tool)

    def pulses(self, tick):
        """Pulses of the spindle's tachometer so far: (count, tick of the last)."""
        return self.spindle.count_pulses(tick)

    def output(self, tick, name, level):
        """Take a new level of an output: enables and relays matter to the machine."""
        if name in self._enables:
            (self._without.discard if level == self._enables[name] else self._without.add)(name)
            self.enabled = not self._without
        if name in self._relays:
            (self._open_relays.discard if level == self._relays[name] else self._open_relays.add)(name)

    def input(self, tick, name):
        """Return the electrical level of an input; one that watches no axis rests inactive."""
        if tick >= self._due:
            self.run(tick)
        barrier = self.barriers.get(name)
        level = self._levels[name] if barrier is None else self._barrier_level(barrier, tick)
        level = self._faults.faulty_level(name, level, tick)
        return level ^ self.noise[name].flipped if name in self.noise else level

    def run(self, tick):
        """Carry out the barriers' chatter and the solenoid's arrival, in their order, up to `tick`."""
        while self._due <= tick:
            due = self._due
            for part in self._parts:
                if part.due == due:
                    part.run()
                    if part is self._solenoid:
                        self._apply_tool(due)
                    elif isinstance(part, (Noise, Moments)):
                        self._report_input(due, part.name)
                    else:
                        self._show_barrier(due, part)
            self._plan_next()

    def next_event(self):
        """Return the tick of the next event by itself; None: there is none."""
        return None if self._due is NEVER else self._due

    # --- the machine

    def set_input(self, tick, name, active):
        """Hold an input that is no barrier (a button, a limit switch) active or not."""
        level = self._active_level(name) if active else 1 - self._active_level(name)
        if level != self._levels[name]:
            self._levels[name] = level
            self._report_input(tick, name)

    def listen(self, callback):
        """Call callback(tick, name, level) at each change of an input."""
        self._listeners.append(callback)

    def inject_noise(self, name, ticks):
        """Put noise on a wire: the level of an input is the other one from the first of `ticks` to the second, from the third to the fourth, and so
        on."""
        if name not in self.noise:
            self.noise[name] = Noise(name)
            self._parts.append(self.noise[name])
        self.noise[name].add_flips(ticks)
        self._plan_next()

    def _report_input(self, tick, name):
        """Report an input's level, with its faults and noise, to the record of pins and the listeners."""
        level = self._levels[name]
        level = self._faults.faulty_level(name, level, tick)
        if name in self.noise:
            level ^= self.noise[name].flipped
        if self.pins is not None:
            self.pins.note_input(tick, name, level)
        for callback in self._listeners:
            callback(tick, name, level)

    def report(self, tick, text):
        """Record something that a real machine could not have followed."""
        self.error_count += 1
        if len(self.errors) < MAX_ERRORS:
            self.errors.append((tick, text))

    def decoder_of(self, axis):
        """Return the decoder of an axis, for its electrical position, current and release."""
        return self._decoders[axis]

    def _move_carriage(self, tick, carriage, steps):
        """Move a carriage by steps, if the drivers are enabled and listen to this board; return True if it moved."""
        if not self.enabled:
            self.report(tick, f"{carriage.name} stepped while the drivers are disabled")
            return False
        if self._open_relays:
            self.report(tick, f"{carriage.name} stepped while its driver listens to another controller")
            return False
        return carriage.move(tick, steps)

    def _apply_tool(self, tick):
        """Note the tool's new state in the trace, and drive the spindle."""
        if self._board.get("servo"):
            return  # which sees to the pen
        self.tool = self._solenoid.value * self._power // 1000
        if self.spindle is not None:
            self.spindle.set_level(tick, self.tool if self._board["spindle"]["pwm"] else self._solenoid.value)
        if self.trace is not None:
            self.trace.add_row(tick, self.position, self.tool)

    def _active_level(self, name):
        if name not in self._actives:
            raise ValueError(f"the board file has no input {name!r}; its inputs are {', '.join(self._actives) or 'none'}")
        return self._actives[name]

    def _barrier_level(self, barrier, tick):
        """Return the electrical level of a barrier's output at `tick`."""
        return self._actives[barrier.name] ^ (not barrier.is_active(tick))

    def _show_barrier(self, tick, barrier):
        """Report a sensor's level if it has changed, and plan the next event."""
        level = self._barrier_level(barrier, tick)
        if level != self._levels[barrier.name]:
            self._levels[barrier.name] = level
            self._report_input(tick, barrier.name)
        self._plan_next()

    def _plan_next(self):
        self._due = min([part.due for part in self._parts])

    # --- what a motor and its encoder may do, by the motor's name

    def stall_motor(self, motor, steps):
        """Lose the next `steps` for which a motor is asked."""
        self._carriage_of(motor).stall += steps

    def mend_inputs(self):
        """End all faults of the inputs; levels that a bounce still has to change excepted."""
        self._faults = InputFaults(self._board["inputs"], self.barriers, {}, self._random)

    def slip_motor(self, motor, steps):
        """Turn a motor by `steps` that nobody asked for."""
        carriage = self._carriage_of(motor)
        carriage.position += steps
        watching = [self._watching_second]
        if carriage in self.carriages:
            number = self.carriages.index(carriage)
            self.position[number] = carriage.position
            watching = [self._watching[number]] + self._others.get(number, [])
        for barrier in watching:
            if barrier is not None and (carriage.position <= barrier.last) != barrier.below:
                barrier.pass_by()

    def lose_counts(self, motor, counts):
        """Have an encoder miss `counts` counts forward."""
        self.encoders[motor].lost += counts

    def _carriage_of(self, motor):
        return next(carriage for carriage in self.carriages + [self.second] if carriage and carriage.name == motor)

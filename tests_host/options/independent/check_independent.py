"""Axes that run on their own: exact counts, each axis's own intervals, live changes, limits, stops; relays."""

from free_machine import FreeMachine
from passo import errors
from passo.commands import RUN, STATUS, Command
from passo.options.independent.commands import AS_JOG, AT_REST, FOREVER, LIVE, ZERO, Rest
from passo.options.independent.errors import ZERO_IS_HOMED

SHARING = 51  # ticks
CASES = {
    "check_two_axes": (
        ("kind", "choice", "step_dir", "unipolar"),
        ("x", -200, 200), ("x_rate", 30, 20_000), ("y", -200, 200), ("y_rate", 30, 20_000),
    ),
    "check_stop_anywhere": (
        ("kind", "choice", "step_dir", "unipolar"), ("ticks", 1, 5_000_000), ("x_rate", 50, 20_000), ("y_rate", 50, 20_000),
    ),
    "check_live": (
        ("kind", "choice", "step_dir", "unipolar"),
        ("asks", "list", 12, ("axis", 0, 1), ("what", 0, 4), ("rate", 40, 8000), ("ticks", 1, 600_000)),
    ),
    "check_ramps": (("steps", 1, 2000), ("rate", 150, 40_000), ("accel", 10, 5000)),
    "check_ramps_live": (
        ("accel", 50, 3000), ("asks", "list", 8, ("what", 0, 4), ("rate", 20, 9000), ("ticks", 1, 3_000_000)),
    ),
}
RUNS = {
    "check_two_axes": 30, "check_stop_anywhere": 25, "check_live": 25, "check_ramps": 20, "check_ramps_live": 20,
}  # fmt: skip


def intervals_hold(machine, axis, each_over, first=0, last=None):
    """Every interval of an axis is the one asked for, within the shortest word; the mean exactly."""
    each, over = each_over
    ticks = [tick for tick, _ in machine.steps[axis][first:last]]
    for i in range(1, len(ticks)):
        assert abs((ticks[i] - ticks[0]) * over - i * each) <= (machine.least + 1) * over, (axis, i)


def check_two_axes(kind, x, x_rate, y, y_rate):
    """Each at its own rate to its own target, whatever the other does; FINISHED once, when both stand."""
    machine = FreeMachine(kind)
    result = machine.run((x, y), ((x_rate, 1000), (y_rate, 700)))
    if 2 * machine.least * y_rate * 10 > 125_000_000 * 7 // 10 and result:
        return
    assert result == 0
    machine.settle()
    assert machine.made() == [x, y] == machine.part.steps_made() == machine.controller.position()
    assert list(machine.controller.queue.target) == [x, y]
    intervals_hold(machine, 0, (12_500_000, x_rate))
    intervals_hold(machine, 1, (700 * 12_500, y_rate))
    assert machine.world.shortest_setup is None or machine.world.shortest_setup >= 62


def check_stop_anywhere(kind, ticks, x_rate, y_rate):
    """Not a step more after the stop; the count is exact, and the next run goes from there."""
    machine = FreeMachine(kind)
    assert machine.run((FOREVER, -FOREVER), ((x_rate, 1000), (y_rate, 1000))) == 0
    machine.poll(ticks)
    before = machine.made()
    assert machine.controller.position() == before
    assert machine.stop() == 0
    machine.settle()
    assert machine.made() == before == machine.part.steps_made()
    assert machine.run((7, 9), ((100, 1000), (100, 1000))) == 0
    machine.settle()
    assert machine.made() == [before[0] + 7, before[1] + 9] and machine.part.steps_made() == [7, 9]


def check_live(kind, asks):
    """One axis sets out, turns, changes its rate and rests by commands; the other keeps its rate."""
    machine = FreeMachine(kind)
    rate = 333
    axis = asks[0][0] if asks else 0
    other = 1 - axis
    assert machine.run([FOREVER if i == other else None for i in range(2)], [(rate, 1000)] * 2) == 0
    place = 0
    for _, what, speed, ticks in asks:
        steps = (FOREVER, -FOREVER, 40, 0, 0)[what]
        command = Rest(1 << axis)
        if what < 4:
            steps = [steps if i == axis else None for i in range(2)]
            assert machine.run(steps, [(speed, 1000)] * 2, LIVE) == 0
        else:
            assert machine.accept(command) == 0
        machine.poll(ticks)
        place = machine.made()
        assert machine.controller.position() == place
    machine.poll(500_000)
    intervals_hold(machine, other, (12_500_000, rate))
    assert machine.accept(Rest(3)) == 0
    machine.settle()
    assert machine.controller.position() == machine.made() == list(machine.controller.queue.target)
    assert machine.controller.state == "idle"


def speeds(ticks):
    """Steps/s between neighbours."""
    return [12_500_000 / (after - before) for before, after in zip(ticks, ticks[1:])]


def within_acceleration(ticks, accel, fastest):
    """Between the middles of neighbouring intervals the speed never changes by more than the acceleration allows."""
    pace = speeds(ticks)
    for i in range(1, len(pace)):
        between = (ticks[i + 1] - ticks[i - 1]) / 2 / 12_500_000
        shared = pace[i] * 2 * SHARING / (ticks[i + 1] - ticks[i])  # a step shares a word with one of the other axis
        assert abs(pace[i] - pace[i - 1]) <= 1.1 * accel * between + 0.02 * pace[i] + 1 + shared
        assert pace[i] <= fastest * 1.01 + shared


def ramped(accel):
    machine = FreeMachine(planning={"independent_ramps": True})
    axes = machine.app.board["axes"]
    for number in range(2):
        assert machine.controller.machine.settings.change(120 + number, accel * 1000) == 0
    return machine, [accel * axis["steps_per_m"] / 1000 for axis in axes]


def check_ramps(steps, rate, accel):
    """Speed up and slow down within the axis's limit; the count is exact, full speed has the rate asked for."""
    machine, accels = ramped(accel)
    assert machine.run((steps, -steps), ((rate, 1000), (max(rate // 3, 1), 1000))) == 0
    machine.settle()
    assert machine.made() == [steps, -steps]
    for axis in range(2):
        ticks = [tick for tick, _ in machine.steps[axis]]
        within_acceleration(ticks, accels[axis], (rate, max(rate // 3, 1))[axis])
        asked = (rate, max(rate // 3, 1))[axis]
        reached = steps * accels[axis] / 2 > 1.2 * asked * asked + 2 * accels[axis]
        if reached and steps > 20:
            middle = speeds(ticks)[len(ticks) // 2]
            assert abs(middle / asked - 1) < 0.001 or abs(12_500_000 / middle - 12_500_000 / asked) < machine.least


def check_ramps_live(accel, asks):
    """Whatever is asked while it runs, the axis keeps its limit, and ends at rest where it says."""
    machine, accels = ramped(accel)
    fastest = 500
    assert machine.run((FOREVER, None), ((500, 1000), None)) == 0
    for what, rate, ticks in asks:
        steps = (FOREVER, -FOREVER, 400, 0, 0)[what]
        if what < 4:
            assert machine.run((steps, None), ((rate, 1000), None), LIVE) == 0
            fastest = max(fastest, rate)
        else:
            assert machine.accept(Rest(1)) == 0
        machine.poll(ticks)
        assert machine.controller.position() == machine.made()
    assert machine.accept(Rest(1)) == 0
    machine.settle()
    assert machine.controller.position() == machine.made()
    signed = machine.steps[0]
    runs = [signed[:1]]
    for step in signed[1:]:
        if step[1] != runs[-1][-1][1]:
            runs.append([])
        runs[-1].append(step)
    for run in runs:
        within_acceleration([tick for tick, _ in run], accels[0], fastest)
        if len(run) > 3:  # begins and ends slowly
            slow = 2.2 * (accels[0] ** 0.5) + 5
            pace = speeds([tick for tick, _ in run])
            assert pace[0] <= slow and pace[-1] <= slow


def check_jogs_extend_without_a_gap():
    machine = FreeMachine(jog={"ahead_ms": 1000})  # each of them whole
    jog = ((48, None), ((480, 1000), None), AS_JOG)
    assert machine.run(*jog) == 0
    for _ in range(9):
        machine.poll(900_000)
        assert machine.controller.state == "jog"
        assert machine.run(*jog) == 0
    for refused in (((-48, None), AS_JOG), ((None, 48), AS_JOG), ((48, None), AT_REST), ((None, 5), AT_REST)):
        assert machine.run(refused[0], ((480, 1000), (480, 1000)), refused[1]) == errors.BUSY
    machine.settle()
    assert machine.made() == [480, 0] == machine.part.steps_made()
    intervals_hold(machine, 0, (12_500_000, 480))
    assert machine.controller.machine.log.entries[-1][1] == errors.BUSY


def check_a_jog_that_comes_as_the_last_step_plays():
    for late in range(0, 40):
        machine = FreeMachine()
        assert machine.run((5, None), ((200, 1000), None), AS_JOG) == 0
        machine.poll(4 * 62_500 + 1 + late * 1500)
        assert machine.run((5, None), ((200, 1000), None), AS_JOG) == 0
        machine.settle()
        assert machine.made() == [10, 0]
        intervals_hold(machine, 0, (12_500_000, 200))


def check_refusals_move_nothing():
    machine = FreeMachine()
    for steps, rates in (
        ((10, 10), ((0, 1000), (480, 1000))), ((10, 10), ((480, 1000), (1_000_000, 1000))),
        ((1 << 28, 0), ((480, 1000), (480, 1000))), ((10, 10), ((1, 44_000), (480, 1000))),
        ((10, 10), ((480, 1000), (83_001 * 1000 // 1000, 1000))),
    ):
        assert machine.run(steps, rates) in (errors.SPEED_RANGE, errors.TRAVEL)
    machine.settle()
    assert machine.steps == [[], []]


def check_limits_and_zero():
    """Soft limits hold where the machine is homed; zero is set only where it was not."""
    machine = FreeMachine()
    controller = machine.controller
    assert machine.run((100, 50), ((4800, 1000), (4800, 1000))) == 0
    machine.settle()
    assert machine.accept(Command(ZERO)) == 0
    assert controller.position() == [0, 0] and machine.part.steps_made() == [100, 50]
    controller.machine.homed = True
    controller.machine.settings._table[20] = ("soft_limits", 0, 1, 0, 1)
    assert machine.accept(Command(ZERO)) == ZERO_IS_HOMED
    for steps in ((-1, None), (48_001, None), (FOREVER, None)):
        assert machine.run(steps, ((480, 1000), None)) == errors.TRAVEL
    assert machine.run((48_000, None), ((20_000, 1000), None), AS_JOG) == 0
    machine.poll(1_000_000)
    assert machine.run((1, None), ((480, 1000), None), LIVE) == errors.TRAVEL
    assert machine.run((-10, None), ((480, 1000), None), LIVE) == errors.TRAVEL
    machine.settle()
    assert controller.position() == [48_000, 0]
    controller.machine.alarm = errors.ALARM_HARD_LIMIT
    assert machine.run((-1, None), ((480, 1000), None)) == errors.LOCKED

"""Stops an emulated machine at speed: how soon after the input's edge do the steps end, and is the firmware's position exact?

    rig = Rig(router(3, inputs=INPUTS))
    set_out(rig, (4000, 3000, -2000), steps_s=100_000, after_us=2000)
    for reaction_us, reported, counted, in_hand in try_halts(rig, PLAYER_PIN, waits_us): …

Each trial is made on a copy of the same motion, so it costs milliseconds.
"""

from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.rig import ticks_of

PLAYER_PIN, INTERRUPT_PIN = 16, 17  # the first halting input also stops the player's own wait
INPUTS = [
    {"name": "stop", "pin": PLAYER_PIN, "active": 1, "pull": "down", "halt": True},
    {"name": "limit", "pin": INTERRUPT_PIN, "active": 1, "pull": "down", "halt": True},
]
_MOVE = """
planner.line({deltas!r}, {ticks}, False)
planner.flush()
controller.machine.awake = True
while not controller.machine.alarm:
    app.cycle()
    {loop}
print(feeder.position(player.words_played()))
"""
_RESUME = """
from passo.motion.limits import Limits
planner.load()
feeder.ramp = planner.ramp
planner.limits(Limits([400000] * {axes}, [400_000_000] * {axes}, [{acceleration}] * {axes}, 10_000))
feeder.open = True
planner.line({deltas!r}, {each} * {total}, False)
planner.flush()
while port._trip is None:
    port.wait(True)
feeder.open = False
stood = feeder.cancel(player.words_played())
sleep_ms(2)
port.halting_input()
planner.clear()
rest = [whole - made for whole, made in zip({deltas!r}, stood)]
planner.line(rest, max(map(abs, rest)) * {each}, False)
planner.flush()
feeder.open = True
while not planner.empty() or player.busy():
    port.wait(True)
print((stood, max(map(abs, stood)), feeder.position(player.words_played())))
"""


def set_out(rig, deltas, steps_s, after_us, loop="pass"):
    """Start a line and let it run for `after_us`, under a main loop that also does what `loop` says."""
    _start_line(rig, deltas, steps_s, loop)
    while not any(rig.step_edges):
        rig.pico.run(200)
    rig.pico.run(after_us)


def try_halt(rig, pin, wait_us):
    """Halt the machine; return (µs from the edge of `pin` to the last step, 0 if none came after it; position reported; steps counted; whether the
    player stood still between its `pull` and its `out`, a word in its hand that has not been played)."""
    rig.pico.run(wait_us)
    edge = _press_pin(rig, pin)
    in_hand = _in_hand(rig)
    rig.pico.run(140)
    rig.pico.drive_pin(pin, 0)
    reported = _answer_of(rig, 500_000)
    last = max(cycle for log in rig.step_edges for cycle, state in log if state == 1)
    return max(0, last - edge) / CYCLES_PER_US, reported, rig.count_steps(), in_hand


def try_halts(rig, pin, waits_us):
    """Try a halt for each wait from now (µs), in ascending order, each on a copy of the running rig. The rig itself runs on."""
    found, now_us = [], 0
    for wait_us in sorted(waits_us):
        rig.pico.run(wait_us - now_us)
        now_us = wait_us
        found.append(on_a_copy(lambda: try_halt(rig, pin, 0)))
    return found


def amid_start(rig, pin, deltas, steps_s, before_us):
    """Press `pin` at each of `before_us` microseconds before the first step would come; yield (that number, cycles from then to each step that comes
    all the same, position reported)."""

    def first_step_cycle():
        set_out(rig, deltas, steps_s, 0)
        return min(cycle for log in rig.step_edges for cycle, _ in log)

    def press_at(cycle):
        """Press the input at a cycle while a line starts. Returns ([cycles from the press to each step edge], the board's answer)."""
        rig.pico.call_at(cycle, lambda: rig.pico.drive_pin(pin, 1))
        _start_line(rig, deltas, steps_s)
        rig.pico.run((cycle - rig.pico.cycle) / CYCLES_PER_US + 20_000)
        return [edge - cycle for log in rig.step_edges for edge, _ in log], _answer_of(rig, 500_000)

    begins = on_a_copy(first_step_cycle)
    for us in before_us:
        yield us, *on_a_copy(lambda: press_at(begins - us * CYCLES_PER_US))


def try_in_hand(rig, pin, tries):
    """Try a halt whose freeze falls between the player's `pull` and its `out`; return None if none of the `tries` waits (µs) meets that cycle."""

    def freeze_after(wait_us):
        rig.pico.run(wait_us)
        _press_pin(rig, pin)
        return _in_hand(rig)

    for wait_us in tries:
        if on_a_copy(lambda: freeze_after(wait_us)):
            return on_a_copy(lambda: try_halt(rig, pin, wait_us))
    return None


def _start_line(rig, deltas, steps_s, loop="pass"):
    rig.clear_edges()
    rig.pico.console.start(_MOVE.format(deltas=deltas, ticks=ticks_of(deltas, steps_s), loop=loop))


def _press_pin(rig, pin):
    """Press `pin`, and let pass enough time for every interrupt that halts. Returns the cycle of the edge."""
    rig.pico.drive_pin(pin, 1)
    edge = rig.pico.cycle
    rig.pico.run(60)
    return edge


def _in_hand(rig):
    machine = rig.pico.chip.pio[0].machines[0]
    return machine.pc == machine.wrap_bottom + 1 and not machine.enabled


def resume_line(rig, pin, deltas, steps_s, acceleration_mm_s2, wait_us):
    """Halt an accelerating line, and resume it where it stood. Returns (position at the stand, dominant steps made, position at the end, cycles of
    the edge of `pin`)."""
    rig.clear_edges()
    rig.pico.console.start(
        _RESUME.format(
            axes=rig.axes, deltas=deltas, total=max(map(abs, deltas)), each=ticks_of((1,), steps_s),
            acceleration=acceleration_mm_s2 * 1_000_000,
        )
    )
    while not any(rig.step_edges):
        rig.pico.run(200)
    rig.pico.run(wait_us)
    rig.pico.drive_pin(pin, 1)
    edge = rig.pico.cycle
    rig.pico.run(200)
    rig.pico.drive_pin(pin, 0)
    return *_answer_of(rig, 2_000_000), edge


def _answer_of(rig, limit_us):
    """Wait up to `limit_us` for the answer of the raw REPL and return it as a Python value. Raises TimeoutError, or AssertionError with the board's
    error."""
    if not rig.pico.run_until(lambda: rig.pico.console.text.count(b"\x04") >= 2, limit_us, 200):
        raise TimeoutError(f"no answer within {limit_us} µs: {rig.pico.console.take_output()!r}")
    said, error = rig.pico.console.take_output().split(b"\x04")[:2]
    if error:
        raise AssertionError(error.decode())
    return eval(said.decode())

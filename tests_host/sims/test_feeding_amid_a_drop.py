"""On a chip an interrupt makes words whenever few lie ahead, also between two lines of the main loop: a job that is being dropped must not begin anew."""

import sys

import pytest
from router import Machine

from passo.steps.word import TICKS_PER_MS


def drops_with_interrupts(machine):
    """Let the interrupt that feeds come at each line that Queue.drop() and what it calls run. Returns the list of how often, one number a drop."""
    queue, app = machine.controller.queue, machine.app
    drop, counts = queue.drop, []

    def interrupt(frame, event, _):
        if frame.f_code.co_name in ("drop", "cancel", "clear", "_reset"):
            if event == "line":
                counts[-1] += 1
                sys.settrace(None)
                app.feeder.fill(app.player.words_played(), 100 * TICKS_PER_MS)
                app.player.start()
                sys.settrace(interrupt)
            return interrupt
        return None

    def drop_interrupted():
        counts.append(0)
        before = sys.gettrace()
        sys.settrace(interrupt)
        try:
            drop()
        finally:
            sys.settrace(before)

    queue.drop = drop_interrupted
    return counts


def touch(machine):
    machine.world.floor = machine.world.place[2] - 40
    machine.do("G91", "G38.2 Z-5 F140")


def cancel_a_jog(machine):
    machine.put("$J=G91 X-50 F600\n")
    machine.cycles(200)
    machine.put(b"\x85")


def hold_and_reset(machine):
    machine.put("G91 G1 X-50 F600\n")
    machine.cycles(200)
    machine.put("!")
    machine.cycles(200)
    machine.put(b"\x18")


@pytest.mark.parametrize("stop", [touch, cancel_a_jog, hold_and_reset])
def test_nothing_begins_anew_while_it_is_dropped(stop):
    machine = Machine().ready()
    counts = drops_with_interrupts(machine)
    stop(machine)
    machine.settle()
    assert counts and min(counts) > 5, counts  # else no drop was interrupted, and nothing is shown
    steps, place = machine.world.steps, list(machine.controller.position())
    machine.cycles(3000)
    assert (machine.world.steps, list(machine.controller.position())) == (steps, place)
    if machine.controller.machine.alarm:
        machine.do("$X")
    machine.do("G91", "G1 X1 Z1 F600")
    machine.settle()
    assert [to - at for to, at in zip(machine.controller.position(), place)] == [320, 0, 400]

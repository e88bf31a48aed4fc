"""S-curves on integers as narrow as a board's."""

from check_s_curve import Smooth, drawn
from draws import Random
from small_int import Small, SmallRows


def test_no_integer_outgrows_a_board():
    """Ramp and jerk on Small integers, from very low jerk to very high, with overrides and holds."""
    for seed in range(15):
        random = Random(seed)
        machine = Smooth(seed, ("mixed", "tiny", "arcs", "lines", "reversals")[seed % 5], drawn(random, 10, 1_000_000), 4)
        rig = machine.rig
        ramp = rig.feeder.ramp
        ramp.state = SmallRows(ramp.state)
        cut, load = ramp.accelerated, ramp.s_curve

        def cut_small(rows, at, state, walker, left, percent, hold, cut=cut):
            cut(SmallRows(rows), Small(at), state, walker, Small(left), Small(percent), hold)

        ramp.accelerated = cut_small
        ramp.s_curve = lambda rows, at, state, load=load: load(SmallRows(rows), at, state)

        def each(machine, random=random):
            if random.between(0, 3) == 0:
                machine.rig.planner.override(random.choice((10, 100, 200)))
            elif random.between(0, 5) == 0:
                machine.rig.feeder.hold = not machine.rig.feeder.hold

        machine.run(each if seed % 2 else None)

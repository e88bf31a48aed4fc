"""check_smooth under CPython, by hypothesis."""

import check_smooth
from check_smooth import Smooth, drawn
from draws import Random
from properties import make_tests
from small_int import Small, SmallRows

globals().update(make_tests(check_smooth))

NUMBERS = "ticks ticks_rest top limit gain span time time_shift leave start".split()


def test_no_integer_outgrows_a_board():
    """Ramp and jerk on Small integers, from very low jerk to very high, with overrides and holds."""
    for seed in range(15):
        random = Random(seed)
        machine = Smooth(seed, ("mixed", "tiny", "arcs", "lines", "reversals")[seed % 5], drawn(random, 10, 1_000_000), 4)
        rig = machine.rig
        ramp = rig.feeder.ramp
        smooth = rig.planner._under_way.smooth
        smooth._root = Small(smooth._root)
        begin, load = ramp.begin, smooth.load

        def begin_small(block, begin=begin):
            for name in NUMBERS:
                setattr(block, name, Small(getattr(block, name)))
            begin(block)

        ramp.begin = begin_small
        smooth.load = lambda rows, at, behind, load=load: load(SmallRows(rows), at, behind)

        def each(machine, random=random):
            if random.between(0, 3) == 0:
                machine.rig.planner.override(random.choice((10, 100, 200)))
            elif random.between(0, 5) == 0:
                machine.rig.feeder.hold = not machine.rig.feeder.hold

        machine.run(each if seed % 2 else None)

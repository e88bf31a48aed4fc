"""The ramp on integers as narrow as a board's."""


def test_no_integer_outgrows_a_board():
    """The ramp on Small integers, over programs of every kind, with overrides."""
    from check_motion import Machine
    from draws import Random
    from small_int import Small, SmallRows

    for seed in range(60):
        machine = Machine(seed, ("mixed", "tiny", "arcs", "lines", "reversals")[seed % 5], 6)
        ramp = machine.rig.feeder.ramp
        begin = ramp.begin
        circle = machine.rig.planner._circle
        circle.state = SmallRows(circle.state)

        def begin_small(block, begin=begin):
            block.start = Small(block.start)
            if not isinstance(block.rows, SmallRows):
                block.rows = SmallRows(block.rows)
            begin(block)

        ramp.begin = begin_small
        random = Random(seed)

        def each(machine, random=random):
            if random.between(0, 3) == 0:
                machine.rig.planner.override(random.choice((10, 100, 200)))

        machine.run(each if seed % 2 else None)

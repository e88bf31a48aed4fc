"""The circle walker on integers as narrow as a board's."""


def test_no_integer_outgrows_a_board():
    """The walker on plans of Small integers: radii to 2²⁰, helices as steep as they may be."""
    from array import array

    from check_circle import about
    from draws import Random
    from passo.motion.arc import plan
    from passo.motion.arc import MAX_RADIUS
    from passo.motion.circle import Circle
    from passo.records import ARC_FIELDS
    from small_int import Small, SmallRows

    random = Random(1)
    out = array("I", bytearray(4 * 255))
    for radius in list(range(1, 60)) + [1 << bits for bits in range(6, 20)] + [MAX_RADIUS - 1, 4095, 4097, 65537]:
        start = about(radius, random.between(0, 6283) / 1000)
        for rise in (0, radius // 2, 2 * radius, 100 * radius):
            into = array("i", [0] * ARC_FIELDS)
            plan(into, (0, 1, 2), (-start[0], -start[1]), (0, 0, rise))
            circle = Circle(3)
            circle.state = SmallRows(circle.state)
            circle.load([Small(value) for value in into])
            for _ in range(40):
                if circle.left:
                    circle.walk(out, 0, min(int(circle.left), 255))

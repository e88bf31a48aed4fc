"""Orders of all kinds for a machine that speaks G-code, as a test of its memory sends them: moves, arcs, jogs, questions, settings.

    stands, lines = mixed(random)       # `stands`: the machine must stand before the first of `lines`

Moves come back, so that the machine stays where it is. `random`: a draws.Random.
"""

QUESTIONS = b"$$", b"$#", b"$I", b"$G", b"$N", b"$LOG", b"$JR", b"$F", b"$110", b"$10=511"
KEPT = b"$110=%d", b"$120=%d", b"$N0=G4P0.0%d", b"G10L2P1X%d", b"G10L20P2Y%d", b"G92Z%d", b"$JR=%d"
MOVES = (b"X",), (b"Y",), (b"X", b"Y")


def mixed(random):
    number = random.between(1, 9)
    chosen = random.between(0, 9)
    if chosen < 5:
        axes = random.choice(MOVES)
        return False, [b"G91G1%sF3000" % b"".join([b"%s%s0.0%d" % (axis, sign, number) for axis in axes]) for sign in (b"", b"-")]
    if chosen == 5:
        return False, [b"G91G2X0I0.%dF2000" % number]
    if chosen == 6:
        return True, [b"$J=G91X%s0.%dF1000" % (sign, number) for sign in (b"", b"-")]
    if chosen < 9:
        return True, [random.choice(QUESTIONS)]
    line = random.choice(KEPT)
    return True, [line % (number + 500 if line[:2] == b"$1" else number)]


def job(random):
    """The lines of a job that moves to and fro."""
    lines = [b"G1X0.%d" % n + b"F%d\nG1X-0.%d" % (1000 + 7 * n, n) for n in range(1, random.between(20, 60))]
    return b"G91\n" + b"\n".join(lines) + b"\nM30\n"

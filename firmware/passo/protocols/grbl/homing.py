"""The grbl language's lines on how well homing repeats: a board that does not latch edges does not load this."""

from micropython import const

_GOOD = const(1)  # steps of range


def homing_lines(found):
    """Return a line a sensor: axis (2: the second side of an axis with two motors), runs, range and σ in steps, and advice."""
    lines = []
    for axis, side, runs, wide, sigma, drift in found:
        name = "xyza"[axis] + ("2" if side else "")
        lines.append("[HOM:%s,%d,%d,%d.%02d,%s]\r\n" % (name, runs, wide, sigma // 100, sigma % 100, _advice_on(wide, drift)))
    return "".join(lines)


def _advice_on(wide, drift):
    """Return advice for a range and a drift, in steps."""
    if wide <= _GOOD:
        return "good"
    if 2 * abs(drift) > wide:
        return "drifts %+d: steps are lost: lower $25, or acceleration" % drift
    return "scatters: lower $24, raise $26, or clean the switch"

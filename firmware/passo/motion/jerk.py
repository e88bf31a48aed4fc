"""Loads S-curves (smooth.py), which a board that has run for a while may have no memory in one piece for.

    load()                                  # early, where a jerk has been set before
    set_jerk(ramp, limits, stride, size)
"""

import gc
import sys

from passo.motion.ramp_viper import cut


def set_jerk(ramp, limits, stride, size):
    """Have `ramp` keep to the jerk of `limits`, 0: any. False where there is no memory for it: with the next start there is.

    `stride` and `size`: of a row of the planner, and all."""
    ramp.cut_short = cut
    ramp.smooth = None
    if not limits.jerk:
        return True
    gc.collect()
    try:
        load()
        from passo.motion.smooth import limit
    except MemoryError:
        _forget()
        return False
    gc.collect()
    limit(ramp, limits, stride, size)
    return True


def load():
    """What arcs need, too: it would find no room afterwards. One by one: the file's buffer goes in between, and what stays
    lies close together. Raises MemoryError."""
    import passo.motion.smooth_way

    gc.collect()
    import passo.motion.smooth_units

    gc.collect()
    import passo.motion.smooth

    gc.collect()
    import passo.motion.cordic

    gc.collect()
    import passo.motion.arc

    gc.collect()
    import passo.motion.arc_speed

    gc.collect()


def _forget():
    package = sys.modules["passo.motion"]
    for name in ("smooth", "smooth_units", "smooth_way"):
        if sys.modules.pop("passo.motion." + name, None):
            delattr(package, name)
    gc.collect()

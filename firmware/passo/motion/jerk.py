"""Loads S-curves (smooth.py), which a board that has run for a while may have no memory in one piece for.

    block.smooth = smooth(limits)
"""

import gc
import sys


def smooth(limits):
    """A Smooth for `limits`, which have a jerk; None where it finds no memory. It will with the next start.

    What arcs need is loaded too: they would find less room afterwards."""
    gc.collect()
    try:
        import passo.motion.arc_speed
        import passo.motion.arc
        from passo.motion.smooth import Smooth

        return Smooth(limits)
    except MemoryError:
        package = sys.modules["passo.motion"]
        for name in ("smooth", "smooth_way", "smooth_units"):
            if sys.modules.pop("passo.motion." + name, None):
                delattr(package, name)
        return None

"""Limits of wall time, for a machine that has more to do than this test.

    assert seconds < patience(2.0)      # 2 s on an idle machine
"""

import os


def patience(seconds):
    """Return twice the seconds, as CI's machine may be slow, times the load per processor, if that is above 1."""
    return seconds * 2 * max(1, os.getloadavg()[0] / os.cpu_count())

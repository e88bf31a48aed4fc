"""Limits of wall time, for a machine that has more to do than this test.

    assert seconds < patience(2.0)      # 2 s on an idle machine
"""

import os


def patience(seconds):
    """Twice as long, as CI's machine may be slow, and more by what others want of the processors."""
    return seconds * 2 * max(1, os.getloadavg()[0] / os.cpu_count())

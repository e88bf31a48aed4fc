"""The feeds that a program asks for, and whether they look like another unit's.

    text = slow_feeds(program.rows(), seconds)      # "every feed is 2.5 mm/min or less: …", or ""

Some programs write F in mm/s (FreeCAD's post fablin): the job then runs, sixty times too slowly.
"""

import re

from host_tools.language import _

_WORD = re.compile(rb"([GF])\s*([-+]?\d*\.?\d+)")
_SLOW_MM_MIN = 100.0
_LONG_S = 300.0  # a short job is seen to be slow, and stopped
_MOTIONS = 0, 1, 2, 3
_FEEDS = 1, 2, 3
_INCH = 25.4


def slow_feeds(rows, seconds):
    """Return a hint about units if a job takes over five minutes and every feed is 100 mm/min or less; else "". `rows`: [(number, line)]."""
    fastest = fastest_feed(rows, _SLOW_MM_MIN) if seconds > _LONG_S else 0.0
    if not 0 < fastest <= _SLOW_MM_MIN:
        return ""
    return _(
        "every feed is {:.4g} mm/min or less, and the job takes long: F is in mm/min; if the program means mm/s, as FreeCAD's post fablin does, "
        "choose another post, or write F{:.4g} in place of F{:.4g}", fastest, 60 * fastest, fastest,
    )  # fmt: skip


def fastest_feed(rows, enough):
    """Return the highest feed of G1, G2 and G3 in mm/min; as soon as one is more than `enough`, that one. 0: the program has no feed, or G93."""
    motion, feed, unit, fastest = 0, 0.0, 1.0, 0.0
    for _number, line in rows:
        for letter, text in _WORD.findall(line.upper()):
            value = float(text)
            if letter == b"F":
                feed = value * unit
            elif value in _MOTIONS:
                motion = value
            elif value in (20, 21):
                unit = _INCH if value == 20 else 1.0
            elif value == 93:
                return 0.0
        if motion in _FEEDS:
            fastest = max(fastest, feed)
            if fastest > enough:
                return fastest
    return fastest

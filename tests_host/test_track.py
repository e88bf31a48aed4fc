"""check_track under CPython, by hypothesis."""

import check_track
from properties import make_tests

globals().update(make_tests(check_track))

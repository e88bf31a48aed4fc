"""check_chords under CPython, by hypothesis."""

import check_chords
from properties import make_tests

globals().update(make_tests(check_chords))

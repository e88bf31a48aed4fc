"""check_pulses under CPython, by hypothesis."""

import check_pulses
from properties import make_tests

globals().update(make_tests(check_pulses))

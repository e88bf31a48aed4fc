"""check_cordic under CPython, by hypothesis."""

import check_cordic
from properties import make_tests

globals().update(make_tests(check_cordic))

"""check_laser under CPython, by hypothesis."""

import check_laser
from properties import make_tests

globals().update(make_tests(check_laser))

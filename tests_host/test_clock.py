"""check_clock under CPython, by hypothesis."""

import check_clock
from properties import make_tests

globals().update(make_tests(check_clock))

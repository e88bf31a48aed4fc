"""check_hold under CPython, by hypothesis."""

import check_hold
from properties import make_tests

globals().update(make_tests(check_hold))

"""check_steps under CPython, by hypothesis."""

import check_steps
from properties import make_tests

globals().update(make_tests(check_steps))

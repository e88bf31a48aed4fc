"""check_line under CPython, by hypothesis."""

import check_line
from properties import make_tests

globals().update(make_tests(check_line))

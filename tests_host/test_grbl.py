"""check_grbl under CPython, by hypothesis."""

import check_grbl
from properties import make_tests

globals().update(make_tests(check_grbl))

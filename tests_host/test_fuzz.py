"""check_fuzz under CPython, by hypothesis."""

import check_fuzz
from properties import make_tests

globals().update(make_tests(check_fuzz))

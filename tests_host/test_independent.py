"""check_independent under CPython, by hypothesis."""

import check_independent
from properties import make_tests

globals().update(make_tests(check_independent))

"""check_measure under CPython, by hypothesis."""

import check_measure
from properties import make_tests

globals().update(make_tests(check_measure))

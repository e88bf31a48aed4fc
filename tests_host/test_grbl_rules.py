"""check_grbl_rules under CPython, by hypothesis."""

import check_grbl_rules
from properties import make_tests

globals().update(make_tests(check_grbl_rules))

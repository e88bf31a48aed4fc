"""check_grbl_inputs under CPython, by hypothesis."""

import check_grbl_inputs
from properties import make_tests

globals().update(make_tests(check_grbl_inputs))

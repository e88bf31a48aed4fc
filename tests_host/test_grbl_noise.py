"""check_grbl_noise under CPython, by hypothesis."""

import check_grbl_noise
from properties import make_tests

globals().update(make_tests(check_grbl_noise))

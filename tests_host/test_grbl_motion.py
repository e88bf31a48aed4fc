"""check_grbl_motion under CPython, by hypothesis."""

import check_grbl_motion
from properties import make_tests

globals().update(make_tests(check_grbl_motion))

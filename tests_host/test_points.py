"""check_points under CPython, by hypothesis."""

import check_points
from properties import make_tests

globals().update(make_tests(check_points))

"""check_plotter under CPython, by hypothesis."""

import check_plotter
from properties import make_tests

globals().update(make_tests(check_plotter))

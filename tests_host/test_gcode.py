"""check_gcode under CPython, by hypothesis."""

import check_gcode
from properties import make_tests

globals().update(make_tests(check_gcode))

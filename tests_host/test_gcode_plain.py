"""check_gcode_plain under CPython, by hypothesis."""

import check_gcode_plain
from properties import make_tests

globals().update(make_tests(check_gcode_plain))

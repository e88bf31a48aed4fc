"""check_control under CPython, by hypothesis."""

import check_control
from properties import make_tests

globals().update(make_tests(check_control))

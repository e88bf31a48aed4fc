"""check_drives under CPython, by hypothesis."""

import check_drives
from properties import make_tests

globals().update(make_tests(check_drives))

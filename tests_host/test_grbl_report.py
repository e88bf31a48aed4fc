"""check_grbl_report under CPython, by hypothesis."""

import check_grbl_report
from properties import make_tests

globals().update(make_tests(check_grbl_report))

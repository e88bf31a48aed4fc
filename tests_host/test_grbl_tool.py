"""check_grbl_tool under CPython, by hypothesis."""

import check_grbl_tool
from properties import make_tests

globals().update(make_tests(check_grbl_tool))

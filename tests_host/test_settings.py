"""check_settings under CPython, by hypothesis."""

import check_settings
from properties import make_tests

globals().update(make_tests(check_settings))

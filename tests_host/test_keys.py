"""check_keys under CPython, by hypothesis."""

import check_keys
from properties import make_tests

globals().update(make_tests(check_keys))

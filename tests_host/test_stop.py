"""check_stop under CPython, by hypothesis."""

import check_stop
from properties import make_tests

globals().update(make_tests(check_stop))

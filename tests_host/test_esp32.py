"""check_esp32 under CPython, by hypothesis."""

import check_esp32
from properties import make_tests

globals().update(make_tests(check_esp32))

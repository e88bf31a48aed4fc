"""check_feed under CPython, by hypothesis."""

import check_feed
from properties import make_tests

globals().update(make_tests(check_feed))

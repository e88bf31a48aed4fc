"""check_links under CPython, by hypothesis."""

import check_links
from properties import make_tests

globals().update(make_tests(check_links))

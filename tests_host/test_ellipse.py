"""check_ellipse under CPython, by hypothesis."""

import check_ellipse
from properties import make_tests

globals().update(make_tests(check_ellipse))

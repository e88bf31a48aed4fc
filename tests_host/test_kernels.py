"""check_kernels under CPython, by hypothesis."""

import check_kernels
from properties import make_tests

globals().update(make_tests(check_kernels))

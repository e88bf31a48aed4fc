import check_draws
from properties import make_tests

globals().update(make_tests(check_draws))

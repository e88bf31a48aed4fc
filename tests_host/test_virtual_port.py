import check_virtual_port
from properties import make_tests

globals().update(make_tests(check_virtual_port))

"""`python -m host_tools.bench`: see main.py."""

from host_tools.bench.main import run

run()

"""A little of fuzz_grbl.py; `make bench ARGS=fuzz` has a million lines."""

from fuzz_grbl import Fuzz

CASES = {"check_fuzz": (("seed", "seed"),)}
RUNS = {"check_fuzz": 12}


def check_fuzz(seed):
    Fuzz(seed).run(60)

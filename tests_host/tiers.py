"""How much of the tests runs: `pytest --tier check|test|all`, which `make check`, `make test` and `make test-all` give.

    check   what is marked `quick`, and FEW examples of each property: within 90 s
    test    all but what is marked `slow`: what guards a commit
    all     everything; also what pytest runs if nobody asks for less

    examples(60, tier="check")      # how many of 60 examples of a property are tried

Coverage is measured in part: a loop of the firmware that runs for the thousandth time is four times slower under its
tracer, and nothing new. So it sees MEASURED examples of each property, and no test marked `unmeasured`.
"""

import sys

TIERS = ("check", "test", "all")
FEW = 4
MEASURED = 8
current = "all"


def examples(count, tier=None):
    return min(count, FEW) if (tier or current) == "check" else count


def runs(slow, quick, tier=None):
    """Whether a test with these marks runs."""
    tier = tier or current
    return tier == "all" or not slow and (tier == "test" or quick)


def stop_measuring():
    """Until the end of the test no coverage is measured."""
    sys.settrace(None)

"""Makes hypothesis tests of a check module's functions; conftest.py collects them under the functions' own names.

    make_tests(check_line)      # {"check_line_ends": a test, …}

A check module is plain Python that also runs under MicroPython: `check_*` functions, with `CASES` giving the
parameters of those that have any (see draws.py), `RUNS`, where it is there, how many examples each takes, `EXAMPLES` those
that are tried every time, and `SLOW` the names of those that only `make test-all` runs, `NOT_QUICK`
of those that `make check` leaves out.
"""

import functools
import inspect

import pytest
import tiers
from hypothesis import example, given, settings
from hypothesis import strategies as st

from draws import SEED_MAX

DEFAULT_RUNS = 100


def strategy(spec):
    """The hypothesis strategy of one specification (see draws.py)."""
    kind = spec[1]
    if kind == "bytes":
        return st.binary(max_size=spec[2])
    if kind == "choice":
        return st.sampled_from(spec[2:])
    if kind == "seed":
        return st.integers(0, SEED_MAX)
    if kind == "list":
        items = [strategy(item) for item in spec[3:]]
        return st.lists(items[0] if len(items) == 1 else st.tuples(*items), max_size=spec[2])
    return st.integers(kind, spec[2])


def make_tests(module):
    """A test for each `check_*` function, by its name. Raises ValueError if the module declares what is not there."""
    cases = getattr(module, "CASES", {})
    runs = getattr(module, "RUNS", {})
    examples = getattr(module, "EXAMPLES", {})
    slow, long = getattr(module, "SLOW", ()), getattr(module, "NOT_QUICK", ())
    checks = {name: check for name, check in vars(module).items() if name.startswith("check_") and callable(check)}
    unknown = (set(cases) | set(runs) | set(examples) | set(slow) | set(long)) - set(checks)
    if unknown:
        names = ", ".join(sorted(unknown))
        raise ValueError(f"{module.__name__}: CASES, RUNS, EXAMPLES, SLOW or NOT_QUICK name what is not there: {names}")
    tests = {}
    for name, check in checks.items():
        test = make_test(check, cases.get(name, ()), runs.get(name, DEFAULT_RUNS), examples.get(name, ()))
        tests[name] = pytest.mark.slow(test) if name in slow else test if name in long else pytest.mark.quick(test)
    return tests


def make_test(check, specs, runs=DEFAULT_RUNS, examples=()):
    wanted = list(inspect.signature(check).parameters)
    given_names = [spec[0] for spec in specs]
    if wanted != given_names:
        raise ValueError(f"{check.__module__}.{check.__name__}{tuple(wanted)}: CASES gives {tuple(given_names)}")
    if not specs:
        return functools.wraps(check)(lambda: check())  # one that can be marked, and the check stays as it is
    test = given(**{spec[0]: strategy(spec) for spec in specs})(check)
    for values in examples:
        test = example(*values)(test)
    return settings(max_examples=tiers.examples(runs))(test)

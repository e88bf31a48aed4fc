"""Turns a check module into hypothesis tests.

    import check_line
    from properties import make_tests

    globals().update(make_tests(check_line))

A check module is plain Python that also runs under MicroPython: `check_*` functions, with `CASES` giving the
parameters of those that have any (see draws.py), `RUNS`, where it is there, how many examples each takes, and `EXAMPLES`
those that are tried every time.
"""

import inspect

from hypothesis import example, given, settings
from hypothesis import strategies as st

from draws import SEED_MAX


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
    """Test functions by name: `check_line` becomes `test_line`."""
    cases = getattr(module, "CASES", {})
    runs = getattr(module, "RUNS", {})
    examples = getattr(module, "EXAMPLES", {})
    checks = {name: check for name, check in vars(module).items() if name.startswith("check_") and callable(check)}
    unknown = (set(cases) | set(runs) | set(examples)) - set(checks)
    if unknown:
        raise ValueError(f"{module.__name__}: CASES, RUNS or EXAMPLES name what is not there: {', '.join(sorted(unknown))}")
    return {
        "test_" + name[6:]: make_test(check, cases.get(name, ()), runs.get(name), examples.get(name, ()))
        for name, check in checks.items()
    }


def make_test(check, specs, runs, examples=()):
    wanted = list(inspect.signature(check).parameters)
    given_names = [spec[0] for spec in specs]
    if wanted != given_names:
        raise ValueError(f"{check.__module__}.{check.__name__}{tuple(wanted)}: CASES gives {tuple(given_names)}")
    if not specs:
        return check
    test = given(**{spec[0]: strategy(spec) for spec in specs})(check)
    for values in examples:
        test = example(*values)(test)
    return settings(max_examples=runs)(test) if runs else test

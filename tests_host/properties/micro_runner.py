"""Runs check modules without pytest: under MicroPython, and under CPython for comparison.

MICROPYPATH=build/unix/STATE:tests_host/properties:tests_host/sims:. micropython tests_host/properties/micro_runner.py [--few] [--short] [--most=N] [--part=N]
[--slow] check_line

Each `check_*` function of each module named in `CASES` runs `RUNS[name]` times (default 100) with values from a generator seeded by its name, after the values
of `EXAMPLES[name]`; one without parameters runs once. With --few only those with parameters run, except those in `NOT_QUICK`; with --short all except those;
with --most=N each at most N times; with --part=N an Nth of its RUNS, but three at least; those in `SLOW` run with --slow only. Prints every failure with its
arguments and a closing count; the exit status is 1 if
anything failed.
"""

import sys

from draws import Random, draw

DEFAULT_RUNS = 100
LEAST = 3


def report(label, error):
    print("FAILED", label)
    if hasattr(sys, "print_exception"):
        sys.print_exception(error, sys.stdout)
    else:
        sys.excepthook(type(error), error, error.__traceback__)


def seed_of(name):
    seed = 0
    for character in name:
        seed = (seed * 31 + ord(character)) & 0x3FFFFFFF
    return seed


def run_check(name, check, specs, runs, examples=()):
    """Run one check; returns (runs made, failed). The first failure ends it."""
    random = Random(seed_of(name))
    runs += len(examples)
    for run in range(runs):
        values = examples[run] if run < len(examples) else [draw(random, spec) for spec in specs]
        try:
            check(*values)
        except Exception as error:
            arguments = ", ".join(["%s=%r" % (spec[0], value) for spec, value in zip(specs, values)])
            report("%s(%s), run %d" % (name, arguments, run + 1), error)
            return run + 1, True
    return runs, False


def run_module(module_name, few=False, slow=True, most=1_000_000, part=1, short=False):
    """Run the checks of a module; returns (checks, runs, failures)."""
    module = __import__(module_name)
    cases = getattr(module, "CASES", {})
    counts = getattr(module, "RUNS", {})
    examples = getattr(module, "EXAMPLES", {})
    left_out = (() if slow else getattr(module, "SLOW", ())) + (getattr(module, "NOT_QUICK", ()) if few or short else ())
    names = [name for name in dir(module) if name.startswith("check_") and callable(getattr(module, name))]
    names = sorted([name for name in names if name not in left_out and (not few or name in cases)])
    total = failures = 0
    for name in names:
        specs = cases.get(name, ())
        runs = counts.get(name, DEFAULT_RUNS)
        runs = min(runs, max(runs // part, LEAST), most) if specs else 1
        made, failed = run_check(name, getattr(module, name), specs, runs, examples.get(name, ()))
        total += made
        failures += failed
    return len(names), total, failures


def main(arguments):
    checks = runs = failures = 0
    few, slow, most, part = "--few" in arguments, "--slow" in arguments, 1_000_000, 1
    short = "--short" in arguments
    for argument in arguments:
        if argument.startswith("--most="):
            most = int(argument[7:])
        elif argument.startswith("--part="):
            part = int(argument[7:])
    for module_name in arguments:
        if module_name.startswith("--"):
            continue
        counted = run_module(module_name, few, slow, most, part, short)
        checks += counted[0]
        runs += counted[1]
        failures += counted[2]
    print("%d checks, %d runs, %d failed" % (checks, runs, failures))
    return 1 if failures or not checks and not few else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""The limits over thousands of random programs.

    python tests_host/properties/soak_motion.py 0 1000              # programs 0 … 999, the kinds in turn
    python tests_host/properties/soak_motion.py 0 1000 corexy       # on one belt: the limits of motors and axes
    python tests_host/properties/soak_motion.py 0 1000 backlash     # with lost motion: those, and where carriages end that have it
    python tests_host/properties/soak_motion.py 0 1000 four         # four axes

Prints every program that fails, and last, for all: programs, blocks, segments, the worst change of speed as a part of its limit, the most steps an axis made in
20 ms beyond its speed × 1.01, less its share of the dominant axis's, the
worst time as a part of that of the planner in floats, and how many failed.
"""

import sys

import check_motion

KINDS = check_motion.CASES["check_limits"][1][2:]
MACHINES = {"cartesian": "check_motion", "corexy": "check_corexy", "backlash": "check_backlash", "four": "check_four_axes"}


def soak(first, last, machine="cartesian"):
    hold_limits = __import__(MACHINES[machine]).hold_limits
    blocks = segments = failed = 0
    change = over = slower = 0.0
    for seed in range(first, last):
        kind = KINDS[seed % len(KINDS)]
        try:
            figures = hold_limits(seed, kind)
        except AssertionError as error:
            print("FAILED %s hold_limits(%d, %r): %s" % (machine, seed, kind, error))
            failed += 1
            continue
        blocks += figures[0]
        segments += figures[1]
        change = max(change, figures[2])
        over = max(over, figures[3])
        if figures[5]:
            slower = max(slower, (figures[4] - 0.0005) / figures[5])
    print(last - first, blocks, segments, "%.3f %.2f %.4f" % (change, over, slower), failed)
    return failed


if __name__ == "__main__":
    sys.exit(1 if soak(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:]) else 0)

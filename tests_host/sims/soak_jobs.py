"""Virtual days of programs that are interrupted: by the power, with the flash torn at any byte, by resets, by lost PCs.

    python tests_host/sims/soak_jobs.py [SECONDS [SEED]]        # make soak

Each round takes one of the programs of test_job_journal.py, interrupts it at a moment of its own, resumes it as `passo resume` does, and
holds what was cut against the whole program. Stops at the first violation, with the seed that brings it about again.
"""

import sys
import tempfile
import time
from pathlib import Path

import test_job_journal as rounds


def soak(seconds, seed):
    """(rounds, steps of the machines) in so many seconds of the wall clock."""
    end = time.monotonic() + seconds
    steps = count = 0
    with tempfile.TemporaryDirectory() as folder:
        wanted = {name: rounds.whole(rounds.program(name, Path(folder))) for name in rounds.JOBS}
        while time.monotonic() < end:
            name = list(rounds.JOBS)[count % len(rounds.JOBS)]
            try:
                steps += rounds.interrupt(name, seed + count, Path(folder), *wanted[name])
            except Exception:
                print(f"violated: program {name}, seed {seed + count}", file=sys.stderr)
                raise
            count += 1
            if count % 10 == 0:
                print(f"{count} interruptions, {steps} steps", flush=True)
    return count, steps


if __name__ == "__main__":
    numbers = [int(argument) for argument in sys.argv[1:]] + [None, None]
    print("%d interruptions, %d steps: 0 violations" % soak(numbers[0] or 3600, numbers[1] or 1000))

"""Machines for virtual days, at random from a seed, while everything fails: `make soak`.

    make soak                                   # an hour, two processes
    make soak ARGS="--seed 7 --minutes 5"
    make soak ARGS="--machine feeds --minutes 600 --actions 100000"    # over both links
    make soak ARGS="--machine router --life 70012"      # one life again, as a violation has named it
    make soak ARGS="--lives 1000 --dask tcp://192.168.1.20:8786 --table lives.csv"     # on many computers: docs/use/many.md

A *life* is a machine from its seed on: rounds of work and faults. soak_router.py, soak_plotter.py, soak_mill.py and soak_pulses.py describe the machines and
the rules that must hold. Each process takes one life after the other, of the machine that has had the least of its share of
processor time. A violation ends the run: seed, machine, its last events, and the command that brings it about again.
"""

import argparse
import multiprocessing
import queue
import sys
import time
import traceback
from collections import Counter
from pathlib import Path

from soak_bench import EVENTS
from soak_mill import Mill
from soak_plotter import Plotter
from soak_pulses import Pulses
from soak_router import Feeds, Router

from host_tools import workers

MACHINES = {made.NAME: made for made in (Router, Feeds, Plotter, Mill, Pulses)}
SHARES = {"router": 0.2, "feeds": 0.2, "plotter": 0.2, "mill": 0.2, "pulses": 0.2}  # of processor time
ROUNDS = {"router": 45, "feeds": 45, "plotter": 45, "mill": 4, "pulses": 45}  # of a life
COLUMNS = ("machine", "life", "rounds", "steps", "actions", "faults", "virtual_s", "cpu_s", "violation")  # of the table of --lives
LIVES = 10_000  # seeds of lives between two seeds of a run


class Violation(Exception):
    """`args`: the text."""


def live(name, seed, rounds=None, told=None):
    """One life. Returns its machine, closed. Raises Violation. `told(machine)`: called after each round; True ends it."""
    machine = None
    try:
        machine = MACHINES[name](seed)
        for _ in range(rounds or ROUNDS[name]):
            machine.round()
            if told and told(machine):
                break
    except Exception as error:
        where = [f"{frame.name}, line {frame.lineno}" for frame in traceback.extract_tb(error.__traceback__)][-3:]
        events = "\n".join(machine.events) if machine else ""
        raise Violation(
            f"VIOLATION: {name}, life {seed}, round {machine.rounds if machine else 0}: {type(error).__name__}: {error}\n"
            f"in {'; '.join(where)}\nthe last {EVENTS} events:\n{events}\n"
            f'again: make soak ARGS="--machine {name} --life {seed}"'
        ) from error
    finally:
        if machine:
            machine.close()
    return machine


def work(number, processes, seed, end, names, out):
    """A process: lives until `end`, of the monotonic clock. Puts (machine, new lives, steps, virtual ms, faults, CPU s, actions), all
    since the last time, or the text of a violation."""
    spent = dict.fromkeys(names, 0.0)
    life = seed * LIVES + number
    while time.monotonic() < end and multiprocessing.parent_process().is_alive():
        name = min(names, key=lambda each: spent[each] / SHARES[each])
        last = [0, 0.0, Counter(), time.process_time(), 0, 1]

        def tell(machine, name=name, last=last):
            now = [machine.steps, machine.now_ms(), Counter(machine.faults), time.process_time(), machine.actions, 0]
            out.put((name, last[5], *(new - old for new, old in zip(now[:5], last))))
            spent[name] += now[3] - last[3]
            last[:] = now
            return time.monotonic() >= end or not multiprocessing.parent_process().is_alive()

        try:
            live(name, life, told=tell)
        except KeyboardInterrupt:
            return
        except Violation as violation:
            out.put(str(violation))
            return
        life += processes


def lived(item):
    """A row of the table, of (machine, seed): rounds, steps, actions, faults, virtual seconds, seconds of CPU, the text of a violation or ""."""
    begun = time.process_time()
    try:
        machine = live(*item)
    except Violation as violation:
        return 0, 0, 0, 0, 0.0, round(time.process_time() - begun, 1), str(violation)
    spent = round(time.process_time() - begun, 1)
    return machine.rounds, machine.steps, machine.actions, sum(machine.faults.values()), round(machine.now_ms() / 1000, 1), spent, ""


def run_lives(seed, count, processes, names, cluster, path):
    """Run `count` whole lives, by processes or a Dask cluster, and write one table, by machine and seed. Return 0, or 1 if a rule was violated.
    """
    import soak  # the workers get a function of a module, not of the program that was started

    items = [(names[number % len(names)], seed * LIVES + number) for number in range(count)]
    begun = time.monotonic()
    with workers.open_table(path, COLUMNS) as write:
        rows = {}
        for item, row in workers.run_items(soak.lived, items, processes, cluster):
            rows[item] = row if row != workers.DIED else (0, 0, 0, 0, 0.0, 0.0, f"its worker died {workers.TRIES} times")
            if rows[item][-1]:
                print(*item, rows[item][-1], file=sys.stderr)
        for item in items:
            write((*item, *rows[item]))
    bad = sum(bool(row[-1]) for row in rows.values())
    print(f"{len(rows)} lives, {sum(row[1] for row in rows.values())} steps, {sum(row[3] for row in rows.values())} faults, {time.monotonic() - begun:.0f} s: {bad} violations")
    return 1 if bad else 0


class Sum:
    def __init__(self, seed):
        self.seed = seed
        self.steps, self.actions, self.virtual_ms, self.cpu_s, self.lives = 0, 0, 0.0, 0.0, Counter()
        self.faults = Counter()
        self.begun = time.monotonic()

    def add(self, name, lives, steps, virtual_ms, faults, cpu_s, actions):
        self.steps += steps
        self.actions += actions
        self.virtual_ms += virtual_ms
        self.faults += faults
        self.cpu_s += cpu_s
        self.lives[name] += lives

    def __str__(self):
        wall_s = time.monotonic() - self.begun
        lives = ", ".join(f"{count} {name}" for name, count in sorted(self.lives.items()))
        return (
            f"{wall_s / 60:5.1f} min, {self.cpu_s:.0f} s of CPU: {self.steps} steps, {self.actions} actions, {sum(self.faults.values())} faults, "
            f"{self.virtual_ms / 86_400_000:.2f} virtual days, lives: {lives or 0}, seed {self.seed}"
        )


def run(seed, minutes, processes, names, actions=None, every_s=60):
    """0, or 1 if something has been violated. It ends after `minutes`, or after `actions` in all."""
    total = Sum(seed)
    out = multiprocessing.Queue()
    end = time.monotonic() + 60 * minutes
    workers = [multiprocessing.Process(target=work, args=(number, processes, seed, end, names, out)) for number in range(processes)]
    for worker in workers:
        worker.start()
    said = time.monotonic()
    violation, stopped = None, False
    try:
        while violation is None and (any(worker.is_alive() for worker in workers) or not out.empty()):
            if actions and total.actions >= actions:
                break
            try:
                what = out.get(timeout=0.5)
            except queue.Empty:
                what = None
            if isinstance(what, str):
                violation = what
            elif what:
                total.add(*what)
            if time.monotonic() - said >= every_s:
                said = time.monotonic()
                print(total, flush=True)
    except KeyboardInterrupt:
        stopped = True
    finally:
        for worker in workers:
            worker.terminate()
            worker.join()
    print(total)
    for kind, count in sorted(total.faults.items()):
        print(f"    {count:9}  {kind}")
    if violation:
        print(violation, file=sys.stderr)
        return 1
    dead = [] if stopped or actions and total.actions >= actions else [worker.exitcode for worker in workers if worker.exitcode]
    print(("stopped: " if stopped else "") + "0 violations" if not dead else f"a process has died: {dead}")
    return 1 if dead else 0


def main(arguments=None):
    parser = argparse.ArgumentParser(
        prog="make soak ARGS=…", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Machines for virtual days, at random from a seed, while wires, power and inputs fail.",
        epilog='examples:\n    make soak\n    make soak ARGS="--seed 7 --minutes 5"\n    make soak ARGS="--machine router --life 70012"',
    )  # fmt: skip
    parser.add_argument("--seed", type=int, default=1, help="of the run (1)")
    parser.add_argument("--minutes", type=float, default=60, help="of the wall clock (60)")
    parser.add_argument("--actions", type=int, help="end after so many, if the minutes last: lines, real-time bytes, faults")
    parser.add_argument("--processes", type=int, default=2, help="in parallel (2)")
    parser.add_argument("--machine", choices=MACHINES, action="append", help="only this one; may be given more than once")
    parser.add_argument("--life", type=int, help="one life of --machine again, by its seed")
    parser.add_argument("--lives", type=int, help="so many whole lives, whatever they take, instead of --minutes")
    parser.add_argument("--dask", help="of --lives: the scheduler of a Dask cluster whose workers have this checkout, tcp://HOST:PORT")
    parser.add_argument("--table", type=Path, help="of --lives: write a line for each, FILE.csv")
    chosen = parser.parse_args(arguments)
    if chosen.minutes <= 0 or chosen.processes < 1:
        parser.error("--minutes and --processes are positive")
    names = chosen.machine or list(MACHINES)
    if (chosen.dask or chosen.table) and not chosen.lives:
        parser.error("--dask and --table want --lives")
    if chosen.lives:
        return run_lives(chosen.seed, chosen.lives, chosen.processes, names, chosen.dask, chosen.table)
    if chosen.life is None:
        return run(chosen.seed, chosen.minutes, chosen.processes, names, chosen.actions)
    if len(names) != 1:
        parser.error("--life wants one --machine")
    try:
        machine = live(names[0], chosen.life)
    except Violation as violation:
        print(violation, file=sys.stderr)
        return 1
    print(f"{names[0]}, life {chosen.life}: {machine.rounds} rounds, {machine.steps} steps, {sum(machine.faults.values())} faults, 0 violations")
    return 0


if __name__ == "__main__":
    sys.exit(main())

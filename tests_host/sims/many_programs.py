"""Programs checked by two processes and by a Dask cluster of two workers, of which one is killed twice: all of them, once each, and in what time.

    python tests_host/sims/many_programs.py 10000

The cluster is started as docs/use/many.md says. Prints the seconds of both and the processor's seconds, and how many times as long the cluster takes.
"""

import csv
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import psutil
from shop_load import free_port

from host_tools import interpreter

ROOT = Path(__file__).parents[2]
WORKERS = 2
STARTS_S = 15


def program(number):
    """20 to 41 lines on a router; each number another one."""
    draw = random.Random(number)
    lines = ["G21 G90", "G0 Z1", f"G1 X{number % 100 / 10} Y{number // 100 / 10} F1500"]
    lines += [f"G1 X{draw.randint(0, 100) / 10} Y{draw.randint(0, 100) / 10}" for _line in range(draw.randint(16, 37))]
    return "\n".join([*lines, "G0 Z2", ""])


def checked(folder, out, *words):
    """(table's rows, seconds) of `passo check`."""
    begun = time.monotonic()
    done = subprocess.run([*interpreter.passo(), "check", str(folder), "-o", str(out), *words], stdout=subprocess.DEVNULL, cwd=ROOT)
    assert done.returncode == 0
    with open(out, newline="") as file:
        return list(csv.DictReader(file)), time.monotonic() - begun


def dask(*words):
    environment = dict(os.environ, DASK_CONFIG=str(ROOT / "docs" / "use" / "dask.yaml"))
    return subprocess.Popen([str(Path(sys.executable).parent / "dask"), *words], env=environment, cwd=ROOT, stderr=subprocess.PIPE, text=True)


def worker_of(nanny):
    """The process that works, of a nanny: the other child is Python's resource tracker."""
    return next((child.pid for child in psutil.Process(nanny).children() if "spawn_main" in " ".join(child.cmdline())), None)


class Cluster:
    def __init__(self):
        self.address = f"tcp://127.0.0.1:{free_port()}"
        self.killed = []
        self.scheduler = dask("scheduler", "--host", "127.0.0.1", "--port", self.address.rpartition(":")[2], "--no-dashboard")
        self.workers = [dask("worker", "--nthreads", "1", "--no-dashboard", self.address) for _number in range(WORKERS)]
        self._logs = [threading.Thread(target=self._drain, args=(each,)) for each in (self.scheduler, *self.workers)]
        for each in self._logs:
            each.start()

    @staticmethod
    def _drain(process):
        for line in process.stderr:
            if re.search(r"Error|Traceback", line):
                print(line, end="", file=sys.stderr)

    def kill_later(self, seconds):
        """Kill the first nanny's worker, at each of `seconds` from now. A nanny gives up if its worker dies as it starts."""
        begun = time.monotonic()
        for due in seconds:
            time.sleep(max(0, begun + due - time.monotonic()))
            while (pid := worker_of(self.workers[0].pid)) is None or time.time() - psutil.Process(pid).create_time() < STARTS_S:
                time.sleep(0.1)
            os.kill(pid, signal.SIGKILL)
            self.killed.append(pid)

    def close(self):
        for process in (*self.workers, self.scheduler):
            process.send_signal(signal.SIGINT)
        for process in (*self.workers, self.scheduler):
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        for each in self._logs:
            each.join(10)


def spent():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    count = int(sys.argv[1])
    folder = Path(tempfile.mkdtemp(prefix="programs-"))
    try:
        programs = folder / "programs"
        programs.mkdir()
        for number in range(count):
            (programs / f"p{number:05}.nc").write_text(program(number))
        before = spent()
        here, here_s = checked(programs, folder / "here.csv", "--workers", str(WORKERS))
        here_cpu = spent() - before
        print(f"--workers {WORKERS}: {here_s:.0f} s, {here_cpu:.0f} s of processor time", flush=True)
        before = spent()
        cluster = Cluster()
        try:
            killer = threading.Thread(target=cluster.kill_later, args=((here_s * 0.3, here_s * 0.6),), daemon=True)
            killer.start()
            there, there_s = checked(programs, folder / "there.csv", "--dask", cluster.address)
        finally:
            cluster.close()
        there_cpu = spent() - before
        assert len(cluster.killed) == 2, cluster.killed
        names = [f"p{number:05}.nc" for number in range(count)]
        assert [row["file"] for row in here] == names and [row["file"] for row in there] == names
        assert here == there and not any(row["fault"] for row in there)
        print(json.dumps({
            "programs": count, "workers killed": len(cluster.killed), "--workers 2, s": round(here_s), "--dask, s": round(there_s), "times as long": round(there_s / here_s, 3),
            "processor, s": [round(here_cpu), round(there_cpu)], "times as much": round(there_cpu / here_cpu, 3),
        }))  # fmt: skip
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()

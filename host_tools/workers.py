"""The same work on many items: by processes of this PC, or on a Dask cluster.

    for item, result in in_processes(work, items, 4): …             # as they end, each item once
    for item, result in on_cluster(work, items, "tcp://host:8786"): …
    with table(Path("results.csv"), ("item", "result")) as write: write(cells)

`work(item)`: a function of a module, which another process imports; so items and results are pickled. If a worker
dies, the item it had is tried again, TRIES times in all; then its result is DIED. An exception of `work` ends all work.

A task costs a cluster 4 ms, so small items go there several a task, as many as take _TASK_S. They are tried again together; those of a task
that has used up its tries are then tried each by itself.
"""

import collections
import contextlib
import csv
import itertools
import multiprocessing
import os
import signal
import time
from multiprocessing import connection

from host_tools import interpreter
from host_tools.failure import Failure, reason
from host_tools.resources import version

TRIES = 3
DIED = "died"
_AHEAD = 4  # tasks that a thread of a cluster has waiting
_TASK_S = 1.0
_MOST_TOGETHER = 16  # items of a task
_ANSWER_S = 10


class _Worker:
    """A process that works on one item after another."""

    def __init__(self, work):
        """Start a process that calls `work`."""
        interpreter.isolate_process()  # the other process begins by looking for Python's own modules
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve_items, args=(work, theirs), daemon=True)
        self._process.start()
        theirs.close()

    def end(self):
        """Kill the process."""
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _serve_items(work, pipe):
    """Work on the items that come by `pipe` until it closes; send (result, None) or (None, error) of each. Runs in the other process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent process ends it
    while True:
        try:
            pipe.send((work(pipe.recv()), None))
        except (EOFError, BrokenPipeError):
            return
        except Exception as error:
            pipe.send((None, error))


def run_items(work, items, count, cluster):
    """Yield (item, result) by the workers of a Dask cluster, if there is an address; else by `count` processes. Raises Failure."""
    return on_cluster(work, items, cluster) if cluster else in_processes(work, items, count)


@contextlib.contextmanager
def open_table(path, columns):
    """Give write(cells) of a .csv file, which is there once it is whole; of no file if `path` is None. Raises Failure."""
    if path is None:
        yield lambda cells: None
        return
    if path.suffix.lower() != ".csv":
        raise Failure("-o writes a table, FILE.csv, not {}", path)
    new = path.with_name(path.name + ".new")
    try:
        with open(new, "w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(columns)
            yield writer.writerow
        os.replace(new, path)
    except OSError as error:
        raise Failure("cannot write {}: {}", path, reason(error)) from error
    finally:
        new.unlink(missing_ok=True)


def in_processes(work, items, count):
    """Yield (item, result) by `count` processes, as they end. Items are taken as there is a process for them. Raises the error of `work`."""
    items = iter(items)
    again = collections.deque()  # (item, which try) whose worker has died
    busy = {}  # pipe: (worker, item, which try)

    def begin(worker):
        """Give a worker the next item, one to be tried again first; end the worker if there is none."""
        item, tried = again.popleft() if again else (next(items, busy), 1)
        if item is busy:  # there are no more
            worker.end()
            return
        worker.pipe.send(item)
        busy[worker.pipe] = worker, item, tried

    try:
        for _number in range(count):
            begin(_Worker(work))
        while busy:
            for pipe in connection.wait(list(busy)):
                worker, item, tried = busy.pop(pipe)
                try:
                    result, error = pipe.recv()
                except (EOFError, OSError):
                    worker.end()
                    if tried < TRIES:
                        again.append((item, tried + 1))
                    else:
                        yield item, DIED
                    begin(_Worker(work))
                    continue
                if error:
                    raise error
                yield item, result
                begin(worker)
    finally:
        for worker, _item, _tried in busy.values():
            worker.end()


def on_cluster(work, items, address):
    """Yield (item, result) by the workers of the Dask scheduler at `address`. Raises Failure if none answers, or one has another Passo."""
    import distributed

    try:
        client = distributed.Client(address, timeout=_ANSWER_S, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        raise Failure("no Dask scheduler answers at {}: {}", address, reason(error)) from error
    with client:
        _look_at_workers(client, address)
        items = iter(items)
        found = distributed.as_completed(loop=client.loop)
        asked = {}  # key of a task: its items

        def submit_items(some):
            """Send some items to the cluster as one task."""
            if some:
                future = client.submit(_run_several, work, some, pure=False)
                asked[future.key] = some
                found.add(future)

        for _number in range(_AHEAD * sum(client.nthreads().values())):
            submit_items(list(itertools.islice(items, 1)))
        for future in found:
            some = asked.pop(future.key)
            try:
                results, seconds = future.result()
            except distributed.KilledWorker:
                if len(some) > 1:  # one of them may have killed it
                    for item in some:
                        submit_items([item])
                    continue
                results, seconds = [DIED], _TASK_S
            yield from zip(some, results, strict=True)
            future.release()
            together = int(_TASK_S * len(some) / max(seconds, 1e-6))
            submit_items(list(itertools.islice(items, min(max(together, 1), _MOST_TOGETHER))))


def _run_several(work, items):
    """Return ([work(item) of each item], the seconds they took): a task of a cluster."""
    begun = time.monotonic()
    return [work(item) for item in items], time.monotonic() - begun


def _look_at_workers(client, address):
    """Raise Failure if there are no workers, or their Passo is not this one."""
    try:
        client.wait_for_workers(1, timeout=_ANSWER_S)
        versions = client.run(version)
    except TimeoutError:
        raise Failure("the Dask scheduler at {} has no workers: dask worker {}", address, address) from None
    except ModuleNotFoundError:
        raise Failure("the workers of {} have no Passo: install it there, with the extra cluster", address) from None
    others = sorted(set(versions.values()) - {version()})
    if others:
        raise Failure("the workers of {} have Passo {}, and this is {}", address, ", ".join(others), version())

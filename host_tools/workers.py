"""The same work on many items: by processes of this PC, or on a Dask cluster.

    for item, result in in_processes(work, items, 4): …             # as they end, each item once
    for item, result in on_cluster(work, items, "tcp://host:8786"): …

`work(item)`: a function of a module, which another process imports; so items and results are pickled. A worker that dies costs its item
only: that is tried again, TRIES times in all, then its result is DIED. What `work` raises ends it all.
"""

import collections
import multiprocessing
import signal
from multiprocessing import connection

from host_tools.failure import Failure, reason
from host_tools.resources import version

TRIES = 3
DIED = "died"
_AHEAD = 4  # items that a thread of a cluster has waiting
_ANSWER_S = 10


class _Worker:
    """A process that works on one item after another."""

    def __init__(self, work):
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(work, theirs), daemon=True)
        self._process.start()
        theirs.close()

    def end(self):
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _serve(work, pipe):
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever started this ends it
    while True:
        try:
            pipe.send((work(pipe.recv()), None))
        except (EOFError, BrokenPipeError):
            return
        except Exception as error:
            pipe.send((None, error))


def in_processes(work, items, count):
    """Yields (item, result) by `count` processes. Items are taken as there is a process for them."""
    items = iter(items)
    again = collections.deque()  # (item, which try) whose worker has died
    busy = {}  # pipe: (worker, item, which try)

    def begin(worker):
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
    """Yields (item, result) by the workers of the Dask scheduler at `address`. Raises Failure if none answers, or one has another Passo."""
    import distributed

    try:
        client = distributed.Client(address, timeout=_ANSWER_S, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        raise Failure("no Dask scheduler answers at {}: {}", address, reason(error)) from error
    with client:
        _look_at_workers(client, address)
        items = iter(items)
        found = distributed.as_completed(loop=client.loop)
        asked = {}

        def ask():
            for item in items:
                future = client.submit(work, item, pure=False)
                asked[future.key] = item
                found.add(future)
                return

        for _number in range(_AHEAD * sum(client.nthreads().values())):
            ask()
        for future in found:
            item = asked.pop(future.key)
            try:
                yield item, future.result()
            except distributed.KilledWorker:
                yield item, DIED
            future.release()
            ask()


def _look_at_workers(client, address):
    """Raises Failure if there are no workers, or their Passo is not this one."""
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

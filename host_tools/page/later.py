"""An order that takes longer than the machine may wait: it reads a file, makes a drawing, or estimates a job.

    return Later(lambda: store.lines(name), lambda lines: machine.run(name, lines))     # an order's answer

`work()` touches neither the machine nor the pages: a panel has it done beside its loop (server.py), which goes on meanwhile: STOP, leases
of jogs, lines of a job. Where nothing runs beside, in a browser's tab, it is done at once. `then(result)` returns the answer:
0, the number of an error, or a dict. Meanwhile the machine may have begun something else, so `then` checks again whether the order may be carried out.
"""


class Later:
    def __init__(self, work, then=lambda result: result):
        self.work = work
        self.then = then


def at_once(work, then):
    """As `beside` of a machine (cabled.py): where nothing runs beside."""
    then(work())

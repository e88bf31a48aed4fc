"""An order that takes longer than the machine may wait: it reads a file, makes a drawing, or estimates a job.

    return SlowOrder(lambda: store.lines(name), lambda lines: machine.run(name, lines))     # an order's answer

`work()` touches neither the machine nor the pages: a panel has it done beside its loop (server.py), which goes on meanwhile: STOP, leases
of jogs, lines of a job. A browser's tab has no thread for it, so there it is done at once. `then(result)` returns the answer:
0, the number of an error, or a dict. Meanwhile the machine may have begun something else, so `then` checks again whether the order may be carried out.
"""


def is_refusal(found):
    """True if `found` says why there is nothing: the number of an error, or a dict with it and a text."""
    return isinstance(found, (int, dict))


class SlowOrder:
    def __init__(self, work, then=lambda result: result, job="", slow=False):
        """`job`: the name of the job that work() reads, or makes; `slow`: it may take minutes, so others do not wait for it, except those of
        the same job."""
        self.work = work
        self.then = then
        self.job = job
        self.slow = slow

    def waits_for(self, name):
        """True if this reads what a slow work makes of the file `name`: a drawing's job is called by it, with a suffix."""
        return bool(name) and (self.job == name or self.job.startswith(name + "."))


def run_at_once(work, then):
    """Do `work` now and call then(its result): a machine's `beside` (cable_page.py) without a thread."""
    then(work())

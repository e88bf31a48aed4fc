"""Drawing a list of objects through a client, with progress, a journal and a clean way to break off.

    job = Job(client, objects, journal)
    job.run(lambda number, drawn: ...)      # Broken if the client was cancelled
"""

import time

from host_tools.failure import Failure
from host_tools.plotter_client import POLL_S, Cancelled
from host_tools.wire import LinkError


class Broken(Exception):
    """The drawing was broken off and the machine stopped, pen up; the journal says where."""


class Job:
    """`objects` are lists of (pen_down, x, y) in steps, each begun by a MOVE; `journal` may be None. `warn(text)` is told
    once if the journal cannot be written any more; the drawing goes on, for half of it on the paper is lost too."""

    def __init__(self, client, objects, journal=None, warn=None):
        self.client = client
        self.objects = objects
        self.journal = journal
        self.begun = False
        self._warn = warn
        self._warned = False
        self._at = (0, 0)  # objects drawn, and points of the next one

    def run(self, progress=None):
        """Draw what the journal leaves to draw. `progress(number, drawn)`: points drawn of object `number`.

        Raises Broken after client.cancel(), LinkError when the link or the machine fails; in both cases the machine
        has been stopped if it could be reached, and the journal is written; it is about once a second too.
        """
        first, drawn = (self.journal.object, self.journal.drawn) if self.journal else (0, 0)
        self.begun = True
        for number in range(first, len(self.objects)):
            self._save(number, drawn)
            self._draw(number, drawn, progress)
            drawn = 0
        self._save(len(self.objects), 0)

    def _draw(self, number, skip, progress):
        """Draw object `number` from its point `skip` on."""
        points, lead = remaining(self.objects[number], skip)
        if not points:
            return
        client = self.client
        stored = 0

        def counted(status):
            """Points of the whole object drawn for certain. Before its first point is stored, the controller still
            counts those of the object before."""
            sure = min(status["drawn"] - client.repeated_points, stored) - lead
            return skip + max(sure, 0)

        def report(status):
            drawn = counted(status)
            if (number, drawn) > self._at:
                self._save(number, drawn)
            if progress:
                progress(number, drawn)

        client.repeated_points = 0
        asked = time.monotonic()
        try:
            for point in points:
                client.point(*point)
                stored += 1
                if time.monotonic() - asked > POLL_S:  # what does not fit into the board's store is drawn as it comes
                    report(client.status())
                    asked = time.monotonic()
            client.end(len(points), report)
        except (Cancelled, LinkError) as reason:
            try:
                self._save(number, counted(client.stop()))
            except LinkError:
                pass  # out of reach: the journal says what was drawn when the machine was heard last
            if isinstance(reason, Cancelled):
                raise Broken(f"stopped at object {number + 1} of {len(self.objects)}") from reason
            raise
        if progress:
            progress(number + 1, 0)

    def reached(self):
        """How far it has come, in words."""
        number, drawn = self._at
        points = sum(len(points) for points in self.objects[:number]) + drawn
        return f"{points} of {sum(map(len, self.objects))} points"

    def _save(self, number, drawn):
        self._at = (number, drawn)
        if self.journal is None:
            return
        try:
            self.journal.save(number, drawn)
        except Failure as failure:
            if self._warn is None:
                raise
            if not self._warned:
                self._warn(f"{failure}. The drawing goes on; broken off, it could not be continued from here")
            self._warned = True


def remaining(points, drawn):
    """What is left of an object of which the first `drawn` points are drawn, and how many points lead up to it.

    Where a line was being drawn it is drawn again from its start: a MOVE leads to the last point drawn.
    """
    rest = points[drawn:]
    if drawn and rest and rest[0][0]:
        return [(False, *points[drawn - 1][1:]), *rest], 1
    return rest, 0

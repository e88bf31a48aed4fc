"""Drawing a list of objects through a client, with progress, a journal and a clean way to break off.

    job = Job(client, objects, journal)
    job.run(lambda number, drawn: ...)      # Broken if the client was cancelled
"""

from host_tools.plotter_client import Cancelled
from host_tools.wire import LinkError


class Broken(Exception):
    """The drawing was broken off and the machine stopped, pen up; the journal says where."""


class Job:
    """`objects` are lists of (pen_down, x, y) in steps, each begun by a MOVE; `journal` may be None."""

    def __init__(self, client, objects, journal=None):
        self.client = client
        self.objects = objects
        self.journal = journal

    def run(self, progress=None):
        """Draw what the journal leaves to draw. `progress(number, drawn)`: points drawn of object `number`.

        Raises Broken after client.cancel(), LinkError when the link or the machine fails; in both cases the machine
        has been stopped if it could be reached, and the journal is written.
        """
        first, drawn = (self.journal.object, self.journal.drawn) if self.journal else (0, 0)
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
            if progress:
                progress(number, counted(status))

        client.repeated_points = 0
        try:
            for point in points:
                client.point(*point)
                stored += 1
            client.end(len(points), report)
        except (Cancelled, LinkError) as reason:
            try:
                self._save(number, counted(client.stop()))
            except LinkError:
                pass  # out of reach: the journal still says where this object was begun
            if isinstance(reason, Cancelled):
                raise Broken(f"stopped at object {number + 1} of {len(self.objects)}") from reason
            raise
        if progress:
            progress(number + 1, 0)

    def _save(self, number, drawn):
        if self.journal:
            self.journal.save(number, drawn)


def remaining(points, drawn):
    """What is left of an object of which the first `drawn` points are drawn, and how many points lead up to it.

    Where a line was being drawn it is drawn again from its start: a MOVE leads to the last point drawn.
    """
    rest = points[drawn:]
    if drawn and rest and rest[0][0]:
        return [(False, *points[drawn - 1][1:]), *rest], 1
    return rest, 0

"""Draws a list of objects through a client, with progress and a journal; may be interrupted and continued.

    job = Job(client, objects, journal)
    job.run(lambda number, drawn: ...)      # Broken if the client was cancelled
"""

import time

from host_tools.clients.plotter import POLL_S, Cancelled
from host_tools.clients.serial_port import LinkError
from host_tools.failure import Failure
from host_tools.language import _


class Broken(Failure):
    """The drawing was interrupted and the machine stopped, pen up; the journal says where."""


class Job:
    """`objects` are lists of (pen_down, x, y) in steps, each begins with a MOVE; `journal` may be None. Calls `warn(text)` once if
    the journal can no longer be written; the drawing goes on, because half a drawing is lost too."""

    def __init__(self, client, objects, journal=None, warn=None):
        self.client = client
        self.objects = objects
        self.journal = journal
        self.begun = False
        self._warn = warn
        self._warned = False
        self._at = (0, 0)  # objects drawn, and points of the next one
        self._led = False  # the pen is where the next point's line goes on

    @property
    def start(self):
        """The (object, points of it drawn) at which to begin."""
        return (self.journal.object, self.journal.drawn) if self.journal else self._at

    def begin(self, spot):
        """Go on at a Spot of drawing_progress.py, where the pen is."""
        self._at = spot.number, spot.drawn
        self._led = spot.done > 0
        if self.journal:
            self.journal.object, self.journal.drawn = self._at

    def run(self, progress=None, change=None):
        """Draw what is not drawn yet by the journal. Calls `progress(number, drawn)`: points drawn of object `number`, and before an object
        `change(number)`, which may raise Cancelled.

        Writes the journal about once a second. Raises Broken after client.cancel(), LinkError if the link or the machine
        fails; in both cases it stops the machine, if it can be reached, and writes the journal.
        """
        first, drawn = self.start
        self.begun = True
        for number in range(first, len(self.objects)):
            self._save_progress(number, drawn)
            self._ask_change(number, drawn, change)
            self._draw_object(number, drawn, progress)
            drawn = 0
        self._save_progress(len(self.objects), 0)

    def _ask_change(self, number, drawn, change):
        """Call `change(number)` before an object of which nothing is drawn. Raises Broken, the machine stopped, if that is cancelled."""
        if change is None or drawn:
            return
        try:
            change(number)
        except Cancelled as reason:
            self.client.stop()
            raise Broken("stopped at object {} of {}", number + 1, len(self.objects)) from reason

    def _draw_object(self, number, skip, progress):
        """Draw object `number` from its point `skip` on."""
        points, lead = (self.objects[number][skip:], 0) if self._led else remaining_points(self.objects[number], skip)
        self._led = False
        if not points:
            return
        client = self.client
        stored = 0

        def count_drawn(status):
            """Return the points of this object that are drawn for certain. Until its first point is stored, the controller still counts the previous
            object."""
            sure = min(status["drawn"] - client.repeated_points, stored) - lead
            return skip + max(sure, 0)

        def report_status(status):
            """Save the points drawn by a status of the controller, if they are more than before, and call `progress(number, drawn)`."""
            drawn = count_drawn(status)
            if (number, drawn) > self._at:
                self._save_progress(number, drawn)
            if progress:
                progress(number, drawn)

        client.repeated_points = 0
        asked = time.monotonic()
        try:
            for point in points:
                client.point(*point)
                stored += 1
                if time.monotonic() - asked > POLL_S:  # an object larger than the board's memory is drawn while it is sent
                    report_status(client.status())
                    asked = time.monotonic()
            client.end(len(points), report_status)
        except (Cancelled, LinkError) as reason:
            try:
                self._save_progress(number, count_drawn(client.stop()))
            except LinkError:
                pass  # out of reach: the journal has what was drawn at the last status
            if isinstance(reason, Cancelled):
                raise Broken("stopped at object {} of {}", number + 1, len(self.objects)) from reason
            raise
        if progress:
            progress(number + 1, 0)

    def progress_text(self):
        """Return the progress as text: points drawn, of how many."""
        number, drawn = self._at
        points = sum(len(points) for points in self.objects[:number]) + drawn
        return _("{} of {} points", points, sum(map(len, self.objects)))

    def _save_progress(self, number, drawn):
        """Save in the journal that `drawn` points of object `number` are drawn. If that fails, warn once; without `warn` raises Failure."""
        self._at = (number, drawn)
        if self.journal is None:
            return
        try:
            self.journal.save_progress(number, drawn)
        except Failure as failure:
            if self._warn is None:
                raise
            if not self._warned:
                self._warn(_("{}. The drawing goes on; if interrupted, it cannot be continued from here", failure.message()))
            self._warned = True


def remaining_points(points, drawn):
    """Return the rest of an object whose first `drawn` points are drawn, and how many points were put before it. An interrupted line is drawn again
    from its start: a MOVE leads to the last point drawn."""
    rest = points[drawn:]
    if drawn and rest and rest[0][0]:
        return [(False, *points[drawn - 1][1:]), *rest], 1
    return rest, 0

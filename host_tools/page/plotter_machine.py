"""The page of a plotter on a cable that speaks packets.

    machine = PlotterMachine(write, tell, board)    # a checked board file: steps/mm, which way UP goes
    machine.job.run("square.txt", [(1, b"MOVE 200 150"), (2, b"LINE 200 550"), (3, b"END")], 1, False)

A job (plotter_job.py) is in the words of `passo send`: MOVE and LINE with a place in steps, SPEED, and END, which draws what has been
sent. The pen's state follows from the lines sent and from the number of points drawn, which STATUS tells.
"""

from host_tools.clients.plotter_wire import PlotterWire
from host_tools.page.cable_settings import with_settings
from host_tools.page.cable_page import on_cable
from host_tools.page.jobs import with_jobs
from host_tools.page.plotter_job import PlotterJob
from passo.protocols.page.plotter import PlotterPage

_Cabled = with_settings(with_jobs(on_cable(PlotterPage)))


class PlotterMachine(_Cabled):
    ask_ms = 60
    silent_ms = 5000  # a torn packet keeps the board silent for two seconds
    again_ms = 250
    can = PlotterPage.can + ("jobs", "single")

    def __init__(self, write, tell, board):
        self.job = PlotterJob(self)
        _Cabled.__init__(self, tell, PlotterWire(write, board, self), board)

    def _show_fields(self, report):
        """Show the STATUS, and the pen up or down as the job's lines say."""
        known = self.state.get("pen", "")
        self.job.report(report["drawn"])
        PlotterPage._show_fields(self, report)
        down = self.job.pen_is_down()
        if report["state"] == "hold":
            self.state["pen"] = known
        elif report["state"] == "run" and down is not None:
            self.state["pen"] = "down" if down else "up"

    def stands_at(self, line):
        """True if the last STATUS has the position of a job's line, (name, x, y) in steps."""
        return self._steps == [line[1], line[2]]

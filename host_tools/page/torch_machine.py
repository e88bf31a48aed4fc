"""The page of a torch on a cable that speaks frames. The board has to know Passo's own frames: they tell state and position.

    machine = TorchMachine(write, tell, board)      # a checked board file: steps/mm, jogs, default speeds

The language does not answer orders. The board counts the frames it drops and keeps the reason: its next report brings both.
"""

from host_tools.clients.torch_wire import TorchWire
from host_tools.page.cable_settings import with_settings
from host_tools.page.cable_page import on_cable
from passo import errors
from passo.protocols.page.torch import TorchPage

_Cabled = with_settings(on_cable(TorchPage))


class TorchMachine(_Cabled):
    again_ms = 300

    def __init__(self, write, tell, board):
        _Cabled.__init__(self, tell, TorchWire(write, self), board)
        self._dropped = None  # as the board has counted
        if board.get("weaving"):
            from passo.options.weaving.language_page import Seams  # here: other boards are without

            Seams(self)

    def _show_fields(self, report):
        """Show a report; log a refusal if the board has dropped a frame, and end the jog."""
        known, self._dropped = self._dropped, report["dropped"]
        if known not in (None, self._dropped):
            report["error"] = report["error"] or errors.BUSY
        TorchPage._show_fields(self, report)
        if report["error"] and self.jog.active:
            self.end_jog()

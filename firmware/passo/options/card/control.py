"""Stored jobs on a memory card."""

from passo.options.card.config import CardStore
from passo.options.jobs import control


class Jobs(control.Jobs):
    def _make_store(self, board, port, folder):
        """Return the store on the card; it is mounted when it is asked for first."""
        self._card = port.make("card", board["card"])
        return CardStore(self._card.path + folder)

"""Stored jobs on a memory card."""

from passo.control import jobs
from passo.options.card.config import CardStore


class Jobs(jobs.Jobs):
    def _make_store(self, board, port, folder):
        self._card = port.make("card", board["card"])
        return CardStore(self._card.path + folder)

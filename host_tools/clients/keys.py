"""A client of the two-motor kit's board for its settings, which have lines; keys need no client.

    with KeysClient("/dev/ttyUSB0") as client:
        client.ask("$100")                  # ["$100=1.111"]
"""

import time

from host_tools.clients.client import Client
from host_tools.clients.answers import is_complete
from host_tools.clients.refusal import lines_before_ok
from host_tools.clients.serial_port import LinkError, open_port
from passo.protocols.typed_words import line_of

_ANSWER_S = 3.0


class KeysClient(Client):
    def __init__(self, port, baud=9600, log=None):
        super().__init__(port, open_port(port, baud), log)
        self._serial.timeout = 0.02

    def ask(self, line):
        """Send a line about settings; returns the lines before its ok. Raises Refused, and LinkError if nothing answers: a kit of the
        document takes no notice of such a line."""
        self._read_bytes()
        self._write_bytes(line_of(line))
        text = ""
        deadline = time.monotonic() + _ANSWER_S
        while not is_complete(text):
            if time.monotonic() > deadline:
                raise LinkError("{}: no answer to {}; is it a board of Passo, and its speed?", self.port, line)
            text += self._read_bytes().decode("ascii", "replace")
        return lines_before_ok(line, text)

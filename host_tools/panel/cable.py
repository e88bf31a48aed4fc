"""The machines that a board on a cable may become: board files of the project for its chip, and the user's own.

    cable = Cable("/dev/ttyACM0", "/dev/ttyACM0", "router_3axis", own_folder, ("grbl", "pulses"), become)
    cable.machine_names()                   # ["router_3axis", "laser_xy", …, "mine.py"]: the present one first
    port, link, table = cable.change_machine("mine.py")     # builds, copies, restarts: up to a minute. Raises Failure

MicroPython's prompt may be at another port than the link that the panel speaks on: a board whose link is its UART.
"""

from pathlib import Path

from host_tools import board_files, boards
from host_tools.failure import Failure, reason
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.records import NETWORK_PORTS

USB = "usb"


class Cable:
    def __init__(self, port, prompt, present, own, speaking, become):
        """`prompt`: MicroPython's port; `present`: the board file in use, "" if nobody has said; `own`: folder of the user's; `speaking`:
        languages of the panel; `become(board, port)`: stores a board file and restarts the board with it."""
        self._port = port
        self._prompt = prompt
        self._present = Path(present).name  # of a file in another folder
        self._become = become
        self.files = {self._present: present} if present else {}  # name: board file, as boards.load() takes it
        self.wrong = []  # sentences: which of the user's own files cannot be used, and why
        chip = boards.load(present)["chip"] if present else None
        for shown, file in board_files.available_files(own).items():
            try:
                table = check(boards.load(file))
            except (Failure, BoardError) as error:
                self.wrong.append(f"{shown}: {error.message() if isinstance(error, Failure) else reason(error)}")
                continue
            if chip in (None, table["chip"]) and self._usable_link(table, speaking):
                self.files.setdefault(shown, file)
        self._speaking = speaking

    def machine_names(self):
        """Names of the board files to choose from, the present one first."""
        return [self._present] + [name for name in self.files if name != self._present]

    def change_machine(self, name):
        """Make the board another machine. Returns (port, link, board file's table). Raises Failure; the board is as it was then."""
        file = self.files[name]
        table = boards.load(file)
        link = self._usable_link(table, self._speaking)
        port = self._prompt if link["port"] == USB else self._port
        if link["port"] != USB and self._port == self._prompt:
            raise Failure(
                "{} speaks on {}, not on USB: start the panel with that cable's --port, and --prompt {}", name, link["port"], self._prompt
            )
        self._become(file, self._prompt)
        self._present = name
        return port, link, table

    def _usable_link(self, table, speaking):
        """The link of a board file's table that the panel can use, a dict: one on USB if the panel has no other cable; None: there is none."""
        links = [link for link in table["links"] if link["protocol"] in speaking and link["port"] not in NETWORK_PORTS]
        usb = [link for link in links if link["port"] == USB]
        return (usb or links or [None])[0] if self._port == self._prompt else (links or [None])[0]

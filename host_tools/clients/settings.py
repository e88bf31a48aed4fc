"""The settings of a running board, whatever its link speaks.

    with open_settings("torch", "/dev/ttyUSB0") as board:
        board.numbers()             # [0, 1, 2 …]
        board.get(100)              # "48.000"
        board.set(100, "48.5")      # "48.500", as the board has kept it. Raises Refused

    number_of("x_steps_mm")         # 100; also of "100" and "$100"
    value_of("x_steps_mm", "48.5")  # "48.5". Raises Failure if it is no number
"""

import re
from functools import cache
from importlib import import_module

from host_tools import boards
from host_tools.clients.grbl import GrblClient
from host_tools.failure import Failure
from passo.config.boardfile import check

BAUD = {"torch": 115_200, "plotter": 57_600, "pulses": 115_200, "keys": 9600, "grbl": 115_200}
_BOARDS = ("router_4axis", "torch_manipulator", "plotter_2014", "lpt_router")  # which have all names but those of rare keys


@cache
def setting_numbers():
    """{name: number} of the settings."""
    return {rule[0]: number for name in _BOARDS if name in boards.names() for number, rule in boards.settings_of(check(boards.load(name))).items()}


def client_class(language):
    """Return the class of the clients of a language."""
    return getattr(import_module("host_tools.clients." + language), language.capitalize() + "Client")


def number_of(text):
    """The number of a setting given by name or number. Raises Failure."""
    digits = text[1:] if text[:1] == "$" else text
    if digits.isascii() and digits.isdigit():
        return int(digits)
    if text not in setting_numbers():
        raise Failure("there is no setting {}; known are {}", text, ", ".join(sorted(setting_numbers(), key=setting_numbers().get)))
    return setting_numbers()[text]


def value_of(name, text):
    """Return `text` if it is a number as a board reads it (digits, a point, a sign), or "" for the board file's value. Raises Failure if not."""
    if text and not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)", text, re.ASCII):
        raise Failure("{}={}: no number as a board reads it: digits and a point, as in 48.5", name, text)
    return text


def open_settings(language, port, baud=None):
    """Open the settings of the board at a link that speaks `language`, for a with statement. `baud` None: the language's own. Raises Failure."""
    if language == "grbl":
        return _Lines(GrblClient(port, baud or BAUD["grbl"]))
    return Asked(client_class(language)(port, baud or BAUD[language]))


class Asked:
    """Settings read and set by a client whose ask(line) returns the lines of the answer."""

    of_lines = False  # G-code's: masks, offsets, start-up lines

    def __init__(self, client):
        self.client = client

    def __enter__(self):
        self.client.__enter__()
        return self

    def __exit__(self, *_):
        self.client.__exit__()

    def numbers(self):
        (told,) = self.client.ask("$")
        return [int(number) for number in told[3:-1].split(",")]

    def get(self, number):
        return self._ask_value(f"${number}")

    def set(self, number, value):
        """Set a setting. `value`: a number as text, "": the board file's. Returns the value that the board has kept. Raises Refused."""
        return self._ask_value(f"${number}={value}")

    def _ask_value(self, line):
        (told,) = self.client.ask(line)
        return told.partition("=")[2]

    def command(self, line):
        """Return the lines of the answer to a grbl line, for back-ups; [] if this language does not have the line. Raises Refused."""
        if line == "$$":
            return [f"${number}={self.get(number)}" for number in self.numbers()]
        return self.client.ask(line) if line.startswith("$") and "=" in line else []


class _Lines(Asked):
    """grbl, which tells all at once."""

    of_lines = True

    def __enter__(self):
        self.client.__enter__()
        self.client.be_sure_it_stands()
        return self

    def _read_all(self):
        return dict(line[1:].split("=", 1) for line in self.client.command("$$") if line.startswith("$"))

    def numbers(self):
        return [int(number) for number in self._read_all()]

    def get(self, number):
        """The value of setting `number`, as text. Raises Failure if the board has none."""
        found = self._read_all()
        if str(number) not in found:
            raise Failure("this board has no setting ${}", number)
        return found[str(number)]

    def set(self, number, value):
        """Set a setting to a number as text; returns the value that the board has kept. Raises Failure for "", Refused for a wrong value."""
        if not value:
            raise Failure("grbl's lines have no word for the board file's value of one setting; $RST=$ is for all of them")
        self.client.command(f"${number}={value}")
        return self.get(number)

    def command(self, line):
        return [told for told in self.client.command(line) if line != "$$" or told.startswith("$")]

"""The rows of `passo prove`, each measured on the board, one after the other.

    for row in Proof(EmulatedBoard("router_3axis"), boards.load("router_3axis"), drive_pins=True).rows():
        row.what, row.found, row.verdict, row.advice

Whatever goes wrong in a row ends it with a sentence. The motors' current is off from the first line on: every session on the board begins by
making its outputs inactive, and no session's machine has any outputs.
"""

from host_tools.failure import Failure
from host_tools.language import _
from host_tools.prove import digests, facts, link, pins
from host_tools.prove.connection import Silent
from host_tools.prove.promises import PROMISES, WORSE, verdict
from host_tools.prove.row import LEFT_OUT, Row, number_text, program_text

# The machine is measured alone: nothing that is wired to it, nothing that writes to the flash.
WITHOUT = ("outputs", "homing", "journal", "servo", "encoders", "gantry", "interlock", "inverter", "card", "jobs", "network", "changeover", "power_fail")
# Title, the rows' function, whether it drives pins.
PARTS = (
    ("what it is", facts.facts, False), ("clock and memory", facts.memory, False), ("golden jobs", digests.digests, False), ("link", link.link, False),
    ("edges on the pins", pins.edges_of, True), ("three axes at their fastest", pins.fastest, True), ("emergency input and position", pins.stops, True),
    ("watchdog", facts.watchdog, False),
)  # fmt: skip


class Proof:
    def __init__(self, board, raw, drive_pins):
        """`board`: a connection; `raw`: the board file's table; `drive_pins` False: rows that need pins are left out."""
        self.board = board
        self.raw = raw
        self.drive_pins = drive_pins
        self.frozen = False
        self._silent = False  # a row found the board silent: ask it no more
        self.timings = {}  # {name: values for the picture}

    def rows(self):
        """Yield every row, as it is measured."""
        for _title, rows in self.parts():
            yield from rows

    def parts(self):
        """Yield (title, its rows as they are measured), one after the other."""
        for title, part, pins_wanted in PARTS:
            yield _(title), self._part(title, part, pins_wanted)

    def _part(self, title, part, pins_wanted):
        """Yield the rows of one part, or one row if it is left out or fails. A silent board leaves out all parts behind."""
        if pins_wanted and not self.drive_pins:
            yield Row(part.__name__, _(title), _("no pins are driven"), verdict=LEFT_OUT)
            return
        if self._silent:
            yield Row(part.__name__, _(title), _("the board is silent"), verdict=LEFT_OUT)
            return
        try:
            yield from part(self)
        except Silent as silent:
            self._silent = True
            yield Row(part.__name__, _(title), silent.message(), verdict=WORSE, advice=_("begin anew: what was not asked is left out"))
        except (Failure, TimeoutError, ValueError) as error:
            said = error.message() if isinstance(error, Failure) else str(error)
            advice = _("something else takes memory: flash the board anew, leave out a link or a language") if "memory" in said else _("flash the board again, and report this")
            yield Row(part.__name__, _(title), said, verdict=WORSE, advice=advice)

    def judge(self, key, value, whole=1, found=None, **figures):
        """Return a row of PROMISES[key]: `value` against the promise, of which `whole` is a factor. `found`: the text shown; `figures`: more values
        for JSON."""
        promise = PROMISES[key]
        bound = promise.bound * whole
        judged = verdict(promise, value, whole)
        unit = f" {_(promise.unit)}" if promise.unit else ""
        limit = _("none") if not bound else _("{} or more", number_text(bound) + unit) if promise.least else _("{} or less", number_text(bound) + unit)
        return Row(key, _(promise.what), found or number_text(value) + unit, limit, judged, _(promise.advice) if judged == WORSE else "", {key: value, **figures})

    def begin(self, order, changes=None, more=()):
        """Restart the interpreter with the board's machine. `order`: make or words; `more`: programs that come first."""
        self.board.restart_interpreter()
        self.load(*more, "board_session.py")
        self.board.exec(f"{order}({ {'inputs': [], **(changes or {})}!r}, {WITHOUT!r})")

    def load(self, *programs):
        """Run programs on the board: files of this folder (NAME.py), or code."""
        for name in programs:
            self.board.exec(program_text(name) if name.endswith(".py") else name)
            self.board.exec("import gc\ngc.collect()")  # long-lived objects lie close together

    def machine(self, changes=None):
        """Return the checked board file of the machine that runs on the board, on the PC."""
        from passo.config.boardfile import check

        return check({**{key: value for key, value in self.raw.items() if key not in WITHOUT}, "inputs": [], **(changes or {})})

"""Errors of programs that `passo compile` reads, by number: from 300 on, behind those of the firmware (passo/errors.py).

    raise ProgramError(DIVISION, "[1/0]")       # the interpreter adds file and line
"""

from host_tools.failure import Failure
from host_tools.language import _

SYNTAX = 300
BRACKETS = 301
UNKNOWN_NAME = 302
DIVISION = 303
DOMAIN = 304
PARAMETER = 305
MACHINE_ONLY = 306
NOT_IN_DIALECT = 310
NOT_ON_BOARD = 311
SAME_GROUP = 312
REPEATED = 313
MISSING = 314
UNUSED = 315
RANGE = 316
WHOLE = 317
TWO_COMMANDS = 318
NO_FEED = 319
UNKNOWN_PLACE = 320
ARC = 321
NO_SPINDLE = 322
NOT_KEPT = 323
LABEL = 330
NO_END = 331
NO_PROGRAM = 332
DEPTH = 333
ENDLESS = 334
NO_BLOCK = 335
TOOL = 340
ENTRY = 341
ENTRY_GOUGES = 342
DOES_NOT_FIT = 343
GOUGES = 344
EXIT_GOUGES = 345
PLANE = 346
COMPENSATED = 347
POCKET = 348

TEXTS = {
    SYNTAX: "a word, number or expression is expected here",
    BRACKETS: "a bracket is not closed, or closed too often",
    UNKNOWN_NAME: "no function, operator or keyword of this name",
    DIVISION: "division by zero",
    DOMAIN: "the function has no value there",
    PARAMETER: "no such parameter or variable, or it has no value yet",
    MACHINE_ONLY: "only the machine knows this value, while it runs",
    NOT_IN_DIALECT: "the dialect has no such word",
    NOT_ON_BOARD: "the machine cannot do this",
    SAME_GROUP: "two commands of the same modal group: write them in two lines",
    REPEATED: "a word stands twice: leave one out",
    MISSING: "the command needs a further word",
    UNUSED: "no command uses the line's words: leave them out, or give one",
    RANGE: "a value is out of its range",
    WHOLE: "a value must be a whole number",
    TWO_COMMANDS: "two commands want the axis words: write them in two lines",
    NO_FEED: "no feed rate: give F",
    UNKNOWN_PLACE: "where the axis stands is not known: move it by G90 first, or give --start",
    ARC: "there is no such arc",
    NO_SPINDLE: "the spindle must turn",
    NOT_KEPT: "no modal state has been kept here: M70 or M73 first",
    LABEL: "the label has no partner, or stands twice",
    NO_END: "the block has no end",
    NO_PROGRAM: "there is no such subprogram",
    DEPTH: "too many calls or values inside each other",
    ENDLESS: "the program does not end: see --bound",
    NO_BLOCK: "there is no such block number",
    TOOL: "the tool's radius or length is not known: see --tools",
    ENTRY: "radius compensation is left by a straight move, and entered by one, or by an arc greater than the tool",
    ENTRY_GOUGES: "the contour cannot be entered: the tool would cut into it on its way",
    DOES_NOT_FIT: "the tool does not fit: an inside corner or arc is too small",
    GOUGES: "the tool would cut into another part of the contour",
    EXIT_GOUGES: "the contour cannot be left: the tool would cut into it on its way",
    PLANE: "this needs the plane XY (G17)",
    COMPENSATED: "not while the tool's radius is compensated: G40 first",
    POCKET: "there is no such pocket",
}


class ProgramError(Failure):
    """A program is refused. `number` is of this table; `detail`, a text with `values` for its fields, says what exactly; file and line
    may come later."""

    def __init__(self, number, detail="", *values, place=None):
        super().__init__(detail, *values)
        self.number = number
        self.place = place

    def name_place(self, place):
        """Name the place (a listing.Source), unless it is known already."""
        self.place = self.place or place
        return self

    def __str__(self):
        return self._whole_text(f"error {self.number}: {TEXTS[self.number]}", super().__str__())

    def message(self):
        return self._whole_text(_("error {}: {}", self.number, _(TEXTS[self.number])), super().message())

    def _whole_text(self, error, detail):
        where = f"{self.place}: " if self.place else ""
        return f"{where}{error}: {detail}" if detail else f"{where}{error}"

"""The order in which the lines of an NGC program are carried out: subroutines, loops and conditions by O words; subprograms of M98.

    flow = Flow(name, text, values, saved, state, bound)
    for line in flow: …         # a Line to carry out; flow.end() ends the program

Labels are matched before anything runs, each within its file. `values` has enter(arguments) and leave(value) for calls of subroutines, `saved`
enter() and leave() for all calls; `state()` returns all else on which the program depends, in plain values.
"""

import re
from typing import NamedTuple

from host_tools.programs.listing import Source
from host_tools.programs.ngc.blocks import clean_line
from host_tools.programs.ngc.endless import Passes, plain_value
from host_tools.programs.ngc.expressions import Cursor, half_away
from host_tools.programs.program_errors import (
    DEPTH, ENDLESS, LABEL, NO_END, NO_PROGRAM, SYNTAX, UNKNOWN_NAME, ProgramError,
)  # fmt: skip

DEEPEST = 10  # calls
_DIGITS = 9  # of a label that is a number
KEYWORDS = (
    "endsub", "sub", "call", "return", "endif", "elseif", "else", "if", "endwhile", "while", "do", "endrepeat", "repeat", "break", "continue",
)  # fmt: skip
_LABEL = re.compile(r"(?:n\d+)?o(<[^<>]+>|\d+|(?=[\[#]))")
_OPENERS = {"endsub": ("sub",), "endif": ("if",), "endwhile": ("while",), "endrepeat": ("repeat",)}
_LOOPS = ("while", "do", "repeat")


class Line(NamedTuple):
    """A line that is not empty; `label` and `keyword` of an O word, `rest` behind it, or all of the line."""

    source: Source
    rest: str
    label: str
    keyword: str


class _Part:
    """A block of lines between O words: numbers of its lines in the program."""

    def __init__(self, kind, label, begin):
        self.kind, self.label, self.begin = kind, label, begin
        self.branches = []  # elseif and else
        self.end = None


class Flow:
    def __init__(self, name, text, values, saved, state, bound, find=None, skip=False):
        """`find(label)`: (name, text) of the file with a subroutine, or None; `skip`: leave out lines that begin with /."""
        self._values, self._saved = values, saved
        self._bound = bound
        self._find = find or (lambda label: None)
        self._skip = skip
        self.texts = {}  # of files
        self._lines = []
        self._ends = []  # for each line, where its file ends
        self._parts = {}  # number of a line: its _Part
        self._subs = {}
        self._programs = {}  # number: its first line, for M98
        self._load_file(name, text)
        self._at = 0
        self._calls = []  # [number of the line behind the call, counts of its loops, first line of a subprogram of M98 or None, runs left]
        self._counts = {}  # of repeat, by the number of its line
        self._passes = Passes(lambda: (state(), plain_value(self._calls), plain_value(self._counts)))
        self._done = 0

    # --- reading

    def _load_file(self, name, text):
        """Append the lines of a file, up to its second %, and match their labels. Raises ProgramError, which names file and line."""
        self.texts[name] = rows = text.splitlines()
        begin = len(self._lines)
        percent = False
        for number, row in enumerate(rows, 1):
            source = Source(name, number)
            try:
                words, slash = clean_line(row)
                if words == "%":
                    if percent:
                        break
                    percent = True
                elif words and not (slash and self._skip):
                    self._lines.append(self._parse_line(source, words))
            except ProgramError as error:
                raise error.name_place(source) from None
        self._ends += [len(self._lines)] * (len(self._lines) - begin)
        self._match_labels(begin)

    def _parse_line(self, source, words):
        """Return the Line of a line's words. O and only a number or name is an empty line; the number is noted for M98. Raises ProgramError if there
        is an O word without a keyword that is known."""
        found = _LABEL.match(words)
        if not found:
            return Line(source, words, "", "")
        label, rest = found[1], words[found.end() :]
        if not label:  # o[#1+2] call: worked out when it is called
            label, call, rest = rest.partition("call")
            if not call:
                raise ProgramError(LABEL, "only calls may work out their label")
            return Line(source, rest, label, call)
        if not rest and label.isascii() and label.isdigit() and len(label) <= _DIGITS:
            self._programs.setdefault(int(label), len(self._lines))
            return Line(source, "", "", "")  # a program's number
        if not rest and not label.startswith(("[", "#")):
            return Line(source, "", "", "")  # a program's name
        keyword = next((word for word in KEYWORDS if rest.startswith(word)), "")
        if not keyword:
            raise ProgramError(UNKNOWN_NAME, "{}", rest) if rest else ProgramError(UNKNOWN_NAME, "an O word without a keyword")
        return Line(source, rest[len(keyword) :], label, keyword)

    def _match_labels(self, begin):
        """Match the O words of the lines from index `begin` on. Raises ProgramError if a label does not fit, or a block has no end."""
        open_parts = []
        for number in range(begin, len(self._lines)):
            line = self._lines[number]
            if line.keyword:
                try:
                    self._match_line(number, line, open_parts)
                except ProgramError as error:
                    raise error.name_place(line.source) from None
        for part in open_parts:
            raise ProgramError(NO_END, "o{} {}", part.label, part.kind, place=self._lines[part.begin].source)

    def _match_line(self, number, line, open_parts):
        """Match one O word with `open_parts`, the blocks around it, the innermost last: open, divide or close a block. Raises ProgramError if its
        label does not fit."""
        keyword, label = line.keyword, line.label
        last = open_parts[-1] if open_parts else None
        fits = last is not None and last.label == label
        if keyword == "while" and fits and last.kind == "do":
            last.end = number
            self._parts[number] = open_parts.pop()
        elif keyword in ("sub", "if", "repeat", *_LOOPS):
            if any(part.label == label for part in open_parts) or keyword == "sub" and label in self._subs:
                raise ProgramError(LABEL, "o{}", label)
            if keyword == "sub" and any(part.kind == "sub" for part in open_parts):
                raise ProgramError(LABEL, "a subroutine inside another")
            open_parts.append(_Part(keyword, label, number))
            self._parts[number] = last = open_parts[-1]
            if keyword == "sub":
                self._subs[label] = last
        elif keyword in _OPENERS or keyword in ("else", "elseif"):
            if not fits or last.kind not in _OPENERS.get(keyword, ("if",)):
                raise ProgramError(LABEL, "o{} {}", label, keyword)
            self._parts[number] = last
            if keyword in _OPENERS:
                last.end = number
                open_parts.pop()
            else:
                last.branches.append(number)
        elif keyword in ("break", "continue", "return"):
            if keyword == "return":  # of the subroutine that it stands in, whatever its label
                part = next((part for part in open_parts if part.kind == "sub"), None)
            else:
                part = next((part for part in open_parts if part.label == label and part.kind in _LOOPS), None)
            if part is None:
                raise ProgramError(LABEL, "o{} {}", label, keyword)
            self._parts[number] = part

    # --- running

    def __iter__(self):
        first_end = self._ends[0] if self._ends else 0
        while self._at is not None and self._at < (len(self._lines) if self._calls else first_end):
            number = self._at
            line = self._lines[number]
            self._done += 1
            if self._done > self._bound:
                raise ProgramError(ENDLESS, "{} lines have been carried out", self._bound, place=line.source)
            self._at = number + 1
            if not line.keyword:
                yield line
                continue
            try:
                getattr(self, "_do_" + line.keyword)(number, line, self._parts.get(number))
            except ProgramError as error:
                raise error.name_place(line.source) from None

    def end(self):
        """End the program."""
        self._at = None

    def call_program(self, number, times):
        """M98: carry out the subprogram, its parameters those of the caller. Raises ProgramError."""
        if number not in self._programs:
            found = next(filter(None, (self._find(name) for name in (f"{number}", f"{number:04}", f"O{number:04}"))), None)
            if found and found[0] not in self.texts:
                self._load_file(*found)
        begin = self._programs.get(number)
        if begin is None:
            raise ProgramError(NO_PROGRAM, "O{}", number)
        if not any("m99" in line.rest for line in self._lines[begin : self._ends[begin]]):
            raise ProgramError(NO_END, "O{}: no M99", number)
        if times:
            self._enter_call(begin, times)

    def end_program(self):
        """M99: return to the caller, or begin once more; in the main program end it."""
        if not self._calls or self._calls[-1][2] is None:
            if self._calls:
                raise ProgramError(LABEL, "M99 in a subroutine of O words")
            return self.end()
        call = self._calls[-1]
        call[3] -= 1
        self._saved.leave_call()
        if call[3]:
            self._saved.enter_call()
            self._at, self._counts = call[2], {}
        else:
            self._at, self._counts, *_ = self._calls.pop()

    def _enter_call(self, begin, times=None):
        """Go on at line index `begin`, and note the way back. `times`: runs of a subprogram of M98; None: a subroutine of O words. Raises
        ProgramError if DEEPEST calls are under way."""
        if len(self._calls) >= DEEPEST:
            raise ProgramError(DEPTH, "{} at most", DEEPEST)
        self._calls.append([self._at, self._counts, begin if times else None, times])
        self._saved.enter_call()
        self._at, self._counts = begin, {}

    def _value_of_line(self, line):
        """Return the value behind an O word, a float. Raises ProgramError if there is none, or more than that."""
        cursor = Cursor(line.rest, self._values)
        value = cursor.read_value()
        if not cursor.at_end():
            raise ProgramError(SYNTAX, "{}", cursor.rest_text())
        return value

    def _do_sub(self, number, line, part):
        self._at = part.end + 1

    def _do_call(self, number, line, part):
        """Carry out a call: work out label and arguments, load the subroutine's file if it is not known yet, and go there. Raises ProgramError if
        there is no such subroutine."""
        label = line.label
        if label[0] in "[#":
            label = f"{half_away(Cursor(label, self._values).read_value()):d}"
        cursor = Cursor(line.rest, self._values)
        arguments = []
        while not cursor.at_end():
            arguments.append(cursor.read_expression())
        if label not in self._subs:
            found = self._find(label.strip("<>"))
            if found and found[0] not in self.texts:
                self._load_file(*found)
        if label not in self._subs:
            raise ProgramError(NO_PROGRAM, "o{}", label)
        self._enter_call(self._subs[label].begin + 1)
        self._values.enter_call(arguments)

    def _do_return(self, number, line, part):
        """Carry out return or endsub: go back to the caller, with the value behind it or None. Raises ProgramError if no subroutine is under way."""
        value = self._value_of_line(line) if line.rest else None
        if not self._calls or self._calls[-1][2] is not None:
            raise ProgramError(LABEL, "o{} {} and no call", line.label, line.keyword)
        self._at, self._counts, *_ = self._calls.pop()
        self._values.leave_call(value)
        self._saved.leave_call()

    _do_endsub = _do_return

    def _do_if(self, number, line, part):
        """Carry out an if: go to the first branch whose condition is not 0, or behind endif. Raises ProgramError with the place of the branch."""
        if self._value_of_line(line):
            return
        for branch in part.branches:
            other = self._lines[branch]
            try:
                if other.keyword == "else" or self._value_of_line(other):
                    self._at = branch + 1
                    return
            except ProgramError as error:
                raise error.name_place(other.source) from None
        self._at = part.end + 1

    def _do_else(self, number, line, part):
        self._at = part.end + 1

    _do_elseif = _do_else

    def _do_endif(self, number, line, part):
        pass

    _do_do = _do_endif

    def _do_while(self, number, line, part):
        """Carry out a while. At a loop's begin leave the loop if the condition is 0; at the end of a do loop go back unless it is. Raises
        ProgramError."""
        goes_on = self._value_of_line(line)
        if part.kind == "do":
            if goes_on:
                self._passes.count_pass(part.begin)
                self._at = part.begin + 1
        elif not goes_on:
            self._at = part.end + 1

    def _do_endwhile(self, number, line, part):
        self._passes.count_pass(part.begin)
        self._at = part.begin

    def _do_repeat(self, number, line, part):
        """Note how often the loop runs, rounded to a whole number; skip it if that is 0 or less. Raises ProgramError."""
        count = half_away(self._value_of_line(line))
        self._counts[number] = count
        if count <= 0:
            self._at = part.end + 1

    def _do_endrepeat(self, number, line, part):
        self._counts[part.begin] -= 1
        if self._counts[part.begin] > 0:
            self._at = part.begin + 1

    def _do_break(self, number, line, part):
        self._at = part.end + 1

    def _do_continue(self, number, line, part):
        self._at = part.begin if part.kind == "while" else part.end

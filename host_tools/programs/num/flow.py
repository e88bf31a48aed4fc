"""The order in which the blocks of a NUM program are carried out: subprograms and jumps.

    flow = Flow("part.num", text, bound)
    for source, block in flow: …        # flow.jump_to(…) and flow.call_program(…) change what comes next

A file has one program or several; `%100` begins the one that `G77 H100` calls. The first is carried out.
"""

from host_tools.programs.listing import Source
from host_tools.programs.num.blocks import clean_line, number_of, whole_number
from host_tools.programs.program_errors import (
    DEPTH, ENDLESS, LABEL, NO_BLOCK, NO_PROGRAM, SYNTAX, ProgramError,
)  # fmt: skip

DEEPEST = 8  # calls


class _Part:
    """A numbered program: its rows, and where its block numbers are."""

    def __init__(self):
        self.rows = []  # (source, text)
        self.numbers = {}


def _read_at(read, text, source):
    """Return read(text); an error gets the name of its line."""
    try:
        return read(text)
    except ProgramError as error:
        raise error.name_place(source)


class _Run:
    """A part under way, from `first` to `last`, `times` more times."""

    def __init__(self, part, first, last, times):
        self.part, self.first, self.last, self.left = part, first, last, times
        self.at = first


class Flow:
    def __init__(self, name, text, bound, skip=False):
        self._bound = bound
        self._done = 0
        self.texts = {name: text.splitlines()}
        self._parts = {}
        main = part = None
        for line, row in enumerate(self.texts[name], 1):
            source = Source(name, line)
            words = clean_line(row)
            if words.startswith("%"):
                part = self._parts[self._parse_label(words[1:] or "0", source)] = _Part()
            elif words and not (skip and words.startswith("/")):
                part = part or self._parts.setdefault(0, _Part())
                main = main or part
                number = _read_at(number_of, words, source)
                if number is not None:
                    if number in part.numbers:
                        raise ProgramError(LABEL, "N{}", number, place=source)
                    part.numbers[number] = len(part.rows)
                part.rows.append((source, words))
        self._runs = [_Run(main, 0, len(main.rows) - 1, 0)] if main else []

    def _parse_label(self, label, source):
        """Return the number behind a %. Raises ProgramError."""
        if not (label.isascii() and label.isdigit()):
            raise ProgramError(SYNTAX, "% and a number before {}", "%" + label, place=source)
        number = _read_at(whole_number, label, source)
        if number in self._parts and self._parts[number].rows:
            raise ProgramError(LABEL, "%{}", label, place=source)
        return number

    def __iter__(self):
        while self._runs:
            run = self._runs[-1]
            if run.at > run.last:
                run.left -= 1
                run.at = run.first
                if run.left <= 0:
                    self._runs.pop()
                continue
            source, text = run.part.rows[run.at]
            self._done += 1
            if self._done > self._bound:
                raise ProgramError(ENDLESS, "{} blocks have been carried out", self._bound, place=source)
            run.at += 1
            yield source, text

    def end(self):
        """End the program."""
        self._runs = []

    def jump_to(self, number):
        """G79: go on at block `number` of the program under way. A jump out of blocks that are repeated ends the repetition."""
        run = self._runs[-1]
        at = self._index_of(run.part, number)
        while not run.first <= at <= run.last:
            if len(self._runs) < 2 or self._runs[-2].part is not run.part:
                raise ProgramError(NO_BLOCK, "N{} is outside of the blocks that are called", number)
            self._runs.pop()
            run = self._runs[-1]
        run.at = at

    def call_program(self, program, numbers, times):
        """G77: carry out a program, or None: this one, as a whole or from one block to another, `times` times. Raises ProgramError."""
        part = self._runs[-1].part
        if program is not None:
            if program not in self._parts:
                raise ProgramError(NO_PROGRAM, "%{}", program)
            part = self._parts[program]
        places = [self._index_of(part, number) for number in numbers]
        first, last = (places + [places[-1]])[:2] if places else (0, len(part.rows) - 1)
        if last < first:
            raise ProgramError(NO_BLOCK, "N{} stands before N{}", numbers[1], numbers[0])
        if len(self._runs) > DEEPEST:
            raise ProgramError(DEPTH, "{} at most", DEEPEST)
        self._runs.append(_Run(part, first, last, times))

    @staticmethod
    def _index_of(part, number):
        if number not in part.numbers:
            raise ProgramError(NO_BLOCK, "N{}", number)
        return part.numbers[number]

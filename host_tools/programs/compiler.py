"""Programs of any dialect to plain G-code: finds out what a file is, compiles it, and reads it for a sender.

    program = compile_file("part.ngc", "ngc", tools="tools.tbl")
    program.lines, program.origin(number)

    program = read("part.gcode")        # as it is, or compiled if its words need that
"""

import re
import sys
import time
from pathlib import Path

from host_tools.failure import Failure, reason
from host_tools.language import _, count_text, line_text
from host_tools.programs import file_kinds, gcode_file, tool_table
from host_tools.programs.listing import Listing
from host_tools.programs.program_makers import advice_of
from host_tools.programs.program_lines import WrongLetter, plain_text, raw_lines_of

DIALECTS = ("num", "ngc")
BOUND = 1_000_000
_TELL_S = 0.2
_NO_LETTER = "\ufffd"  # in place of a line behind a closing %, which no dialect carries out
HEADER = "G21 G17 G90 G94 G40 G80"
_SUFFIXES = {".num": "num"}

_NAMES = re.compile(r"<[^<>]*>")
# Words that no controller of plain G-code understands. The first that is met decides.
_SIGNS = {
    "ngc": re.compile(r"#|\[|^(N\d+)?O\S*(SUB|CALL|IF|WHILE|DO|REPEAT)|G4[12](?![\d.]*\d)|G4[12]\.1|G(74|8[4-9])(?!\d)|G5(\.[123])?(?![.\d])|M(98|7[0-3])(?!\d)|[@^]"),
    "num": re.compile(r"G(77|79)(?!\d)|G45(?!\d)|^(N\d+)?L\d+=|[A-Z]L\d|(?<![A-Z])E[RHXYBPQIJ]-?[\d.]"),
}



class _Progress:
    """Prints on stderr how far a program has been carried out, if that takes long."""

    def __init__(self):
        self._done = 0
        self._told = time.monotonic()
        self._shown = False

    def __call__(self, source):
        self._done += 1
        if self._done % 1000 == 0 and time.monotonic() - self._told > _TELL_S:
            self._told = time.monotonic()
            self._shown = True
            text = _("compiling: {} lines carried out, at {}", self._done, source)
            print(f"\r{text}   ", end="", file=sys.stderr, flush=True)

    def end(self):
        if self._shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


class Program:
    """Lines for a sender. `dialect`: "plain" if it is the file as it is."""

    def __init__(self, path, dialect, listing=None, texts=None, reason=""):
        """`reason`: why the program is compiled, if nobody asked for that."""
        self.path, self.name = path, path.name
        self.dialect, self.reason = dialect, reason
        self.listing, self.texts = listing, texts
        self.flat = None  # takes rows, and gives them without Z
        self.behind = ""  # a note on lines behind the program's end, once rows() has come to it

    def rows(self):
        """Yield (number, bytes) of each line of the file, or of the listing. Raises Failure at the first wrong line."""
        rows = gcode_file.file_lines(self.path, self._note_end) if self.listing is None else iter(self.listing.lines())
        return self.flat(rows) if self.flat else rows

    def _note_end(self, number, behind):
        self.behind = _("{} ends at line {}; what stands behind it is no part of the program: {}", self.name, number, count_text(behind, "line"))

    def advice(self):
        """Return advice on the settings of the CAM program that made the file, for refused lines; "" if there is none."""
        return advice_of(self.path)

    def last_number(self):
        return gcode_file.last_number(self.path) if self.listing is None else len(self.listing.codes)

    def origin(self, number):
        """Return the origin of line `number`, as text: "line 12", of a compiled program "part.ngc:12, listing line 40"."""
        if self.listing is None:
            return line_text(number)
        return _("{}, listing line {}", self.listing.origin(number) or self.name, number)

    def place_text(self, number):
        """Return the origin of line `number` for the beginning of an error: "path/part.ngc:12"."""
        if self.listing is None:
            return f"{self.path}:{number}"
        return _("{}: listing line {}", self.path.parent / self.listing.origin(number), number)


def text_of(path):
    """Read the text of a program. Raises Failure if there is none."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error
    if b"\0" in data:
        raise Failure("{} is no text: there are zero bytes in it", path)
    lines, begun, ended = [], False, False
    for number, raw in enumerate(raw_lines_of(data), 1):
        try:
            lines.append(plain_text(raw))
        except WrongLetter as wrong:
            if not ended:
                raise gcode_file.wrong_letter(path, WrongLetter(wrong.letter, number)) from None
            lines.append(_NO_LETTER)
        words = lines[-1].strip()
        ended = ended or begun and words == "%"
        begun = begun or words not in ("", "%")
    return "\n".join(lines)


def detect_dialect(path):
    """Return (dialect, why): "plain" if no word needs a compiler. A suffix .num decides; else the first line that says more. Raises Failure if there
    are words of both dialects."""
    suffix = path.suffix.lower()
    if suffix in _SUFFIXES:
        return _SUFFIXES[suffix], _("its name ends in {}", path.suffix)
    found = {}
    for number, line in gcode_file.file_lines(path):
        if line.startswith(b"$"):
            continue
        words = line.decode("ascii").upper().partition("S=")[0]  # behind it are a row's powers
        for dialect, sign in _SIGNS.items():
            match = dialect not in found and sign.search(words if dialect == "ngc" else _NAMES.sub("", words))
            if match:
                found[dialect] = _("line {} has {}", number, match[0])
    if len(found) > 1:
        raise Failure("{}: words of two dialects, num ({}) and ngc ({}): give --dialect num or ngc", path, found["num"], found["ngc"])
    return next(iter(found.items()), ("plain", ""))


def compile_file(path, dialect, tools=None, start=None, bound=BOUND, skip=False, linear=False):
    """Compile a file into a Program. `dialect`: one of DIALECTS, or None: by the file; `tools`: a table's path; `start`: where X, Y, Z and A stand
    at first, mm and degrees of the program; `bound`: the most lines to carry out, and to make; `skip`: leave out lines that begin with /;
    `linear`: A of an ngc program is no rotary axis. Raises Failure."""
    path = Path(path)
    more = {}
    if dialect is None:
        dialect = detect_dialect(path)[0]
        if dialect == "plain":
            raise Failure("{} has no word of num or ngc: it can be sent as it is; --dialect compiles it all the same", path)
    if dialect not in DIALECTS:
        raise Failure("--dialect is num or ngc, not {!r}", dialect)
    text = text_of(path)
    table = tool_table.read(tools) if tools else {}
    listing = Listing(bound)
    listing.progress = _Progress() if sys.stderr.isatty() else None
    if dialect == "ngc":
        from host_tools.programs.ngc.interpreter import compile_program

        more = {"linear": linear}
    else:
        from host_tools.programs.num.interpreter import compile_program

    def find_subroutine(label):
        """Return (name, text) of a subroutine's file, looked for in the program's folder and in `subs` there; None if there is none."""
        names = dict.fromkeys(f"{each}.ngc" for each in (label, label.lower()))
        for other in (folder / name for folder in (path.parent, path.parent / "subs") for name in names):
            if other.is_file():
                return other.name, text_of(other)
        return None

    try:
        texts = compile_program(path.name, text, listing, table, start or (), bound, find_subroutine, skip, **more)
    finally:
        if listing.progress:
            listing.progress.end()
    if not listing.codes:
        raise Failure("{} does nothing", path)
    listing.begin(HEADER)
    return Program(path, dialect, listing, texts)


def read(path, dialect=None, tools=None, linear=False):
    """Read a Program for a sender, no HPGL. It is compiled if `dialect` says so, or its words need it, or a tool table is given; "plain" keeps it as
    it is. `linear`: the machine's A is no rotary axis. Raises Failure."""
    path = Path(path)
    why = ""
    if path.is_file():
        gcode_file.refuse_others_at(path)
    if dialect is None:
        dialect, why = detect_dialect(path)
        if dialect == "plain" and tools:
            dialect, why = "ngc", _("there is a tool table")
    if dialect == "plain":
        return Program(path, dialect)
    program = compile_file(path, dialect, tools, linear=linear)
    program.reason = why
    return program


def fit_to_machine(program, about, tools=None):
    """Return the program for a machine that answers `about` to `$I`: compiled anew if it has A in G20 and the machine's A is linear."""
    if program.listing is None or not program.listing.turns_in_inches or "[AXS:4" not in "".join(about) or "[ROTARY:" in "".join(about):
        return program
    fitted = read(program.path, program.dialect, tools, True)
    fitted.flat = program.flat
    return fitted


def print_notes(program):
    """Print on stderr that a program was compiled, if nobody asked for it, the compiler's warnings, and, once its rows have been read, what follows
    its end."""
    if program.reason:
        text = _("{}: compiled as {}, because {}: {}; --dialect plain sends it as it is")
        print(text.format(program.name, program.dialect, program.reason, count_text(program.last_number(), "line")), file=sys.stderr)
    if program.behind:
        print(program.behind, file=sys.stderr)
    for warning in program.listing.warnings if program.listing else ():
        print(_("warning: {}", warning), file=sys.stderr)

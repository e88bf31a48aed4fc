"""A program of plain G-code as the lines that a controller gets: the one reader of its bytes, for all that check, send, store or queue it.

    for number, line in program_lines(raw_lines): …     # number: of the file's line; `line`: bytes without comments, blanks and N word
    job_error(line)                                     # 0, or why a job of the panel, the shop or the board may not have it

A program ends with its first line that has M2 or M30, or at a `%` alone in a line behind its first line. A file is UTF-8, else Latin-1. Blanks of all
kinds are dropped, and `/`, as the controller drops them; any other letter beyond ASCII, and a real-time command, refuses the line unless it stands in a
comment. N words give way to the numbers of the file's lines, which senders put there, so that reports name a line of the file. An N word stays if the
controller refuses it, or if what stands left and right of it would become one word.

It runs under MicroPython, too, in the tab of the site. The board's own page has the same rules in web/page/program.js.
"""

try:
    import unicodedata
except ImportError:  # MicroPython
    unicodedata = None

from passo import errors

_REAL_TIME = b"?!~\x18"
_BLANKS = "\xa0\u1680\u2000\u2001\u2002\u2003\u2004\u2005\u2006\u2007\u2008\u2009\u200a\u200b\u202f\u205f\u2060\u3000\ufeff"
_MOST_NUMBER = 9_999_999  # of an N word
_DROPPED = bytes([byte for byte in range(33) if byte not in _REAL_TIME] + [47, 127])
_PLAIN = bytes([byte for byte in range(33, 127) if byte not in _REAL_TIME + b"/"])


class WrongLetter(Exception):
    """`letter` stands outside of a comment; `number`: of the file's line."""

    def __init__(self, letter, number=0):
        super().__init__(letter)
        self.letter, self.number = letter, number


if hasattr(b"", "translate"):

    def _drop_bytes(line, bytes_):
        return line.translate(None, bytes_)
else:  # MicroPython

    def _drop_bytes(line, bytes_):
        return bytes([byte for byte in line if byte not in bytes_])


def raw_lines_of(data):
    """Return the raw lines of a whole file's bytes."""
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n").split(b"\n")


def program_lines(raw_lines, ended=None):
    """Yield (number, line) of a file's raw lines. Calls `ended(number, behind)` if lines that say something follow the last one, `number`. Raises
    WrongLetter."""
    raw_lines = iter(raw_lines)
    number, begun, last = 0, False, 0
    for raw in raw_lines:
        number += 1
        try:
            line = strip_line(raw)
        except WrongLetter as wrong:
            raise WrongLetter(wrong.letter, number)
        if line == b"%" and begun:
            last = number
            break
        if not line or line == b"%" or _names_program(line):
            continue
        begun = True
        end = ends_program(line)
        line = _without_number(line)
        if line:
            yield number, line
        if end:
            last = number
            break
    behind = len([None for raw in raw_lines if raw.strip(b" \t\r\n%\x1a")]) if last else 0
    if behind and ended:
        ended(last, behind)


def strip_line(raw):
    """Return a raw line as the controller sees it: without comments, blanks and control characters. Raises WrongLetter."""
    if b"(" in raw or b";" in raw:
        raw = _without_comments(raw)
    line = _drop_bytes(raw, _DROPPED)
    return line if not _drop_bytes(line, _PLAIN) else _without_blanks(raw)


def _without_comments(raw):
    """Return a raw line's bytes without comments in brackets, and without the rest behind a ; or a bracket that is not closed."""
    kept = b""
    while raw:
        at = len(raw)
        for begin in (raw.find(b"("), raw.find(b";")):
            if 0 <= begin < at:
                at = begin
        kept += raw[:at]
        end = raw.find(b")", at) if raw[at : at + 1] == b"(" else -1
        raw = raw[end + 1 :] if end >= 0 else b""
    return kept


def _without_blanks(raw):
    """Return a line without blanks, also without those that are no ASCII. Raises WrongLetter."""
    text = "".join([letter for letter in text_of(raw) if letter not in _BLANKS])
    for letter in text:
        if ord(letter) > 127 or ord(letter) in _REAL_TIME:
            raise WrongLetter(letter)
    return _drop_bytes(text.encode(), _DROPPED)


def plain_text(raw):
    """Return a raw line as text, comments and all, with common blanks, for a compiler. Raises WrongLetter."""
    text = text_of(raw)
    if not _drop_bytes(raw, _PLAIN + _DROPPED + _REAL_TIME):
        return text
    strip_line(raw)
    return "".join([" " if letter in _BLANKS else letter for letter in text])


def text_of(raw):
    """Decode bytes that are UTF-8, or Latin-1 as older programs write it."""
    try:
        return raw.decode()
    except UnicodeError:
        return "".join([chr(byte) for byte in raw])


def latin_bytes(text):
    """Encode a file's text as Latin-1, one byte a letter, for readers that count letters. Other letters become a blank if they are blanks, else ?."""
    return "".join([" " if letter in _BLANKS else letter for letter in text]).encode("latin-1", "replace")


def name_letter(letter):
    """Return a letter's name in Unicode: “U+2212 MINUS SIGN”."""
    code = "U+%04X" % ord(letter)
    if unicodedata and "\x80" <= letter <= "\x9f":  # Windows has letters there
        letter = letter.encode("latin-1").decode("cp1252", "ignore") or letter
    name = unicodedata.name(letter, "") if unicodedata else ""
    return code + " " + name if name else code


def _names_program(line):
    """True of a program's number, which CAM programs begin with: O100, :100."""
    return line[:1] in (b"O", b"o", b":") and line[1:].isdigit()


def _words_of(line):
    """Return the words of a line in capitals, without the packed powers behind =; b"" of a $ line."""
    return b"" if line[:1] == b"$" else line.partition(b"=")[0].upper()


def ends_program(line):
    """True of a line with M2 or M30."""
    rest = _words_of(line)
    while True:
        _, found, rest = rest.partition(b"M")
        if not found:
            return False
        size = 1 if rest[:1] == b"+" else 0
        while rest[size : size + 1] and rest[size : size + 1] in b"0123456789.":
            size += 1
        try:
            if float(rest[:size]) in (2, 30):
                return True
        except ValueError:
            pass  # the controller refuses it


def _without_number(line):
    """Return `line` without its N word. A line that the controller refuses stays as it is."""
    words = _words_of(line)
    at = words.find(b"N")
    if at < 0 or words.count(b"N") > 1:
        return line
    end = at + 1
    while words[end : end + 1] and words[end : end + 1] in b"+-.0123456789":
        end += 1
    if not _is_line_number(words[at + 1 : end]) or line[end:] and not b"A" <= words[end : end + 1] <= b"Z":
        return line
    left = line[:at] + line[end:]
    return line if left[:1] in (b"$", b"%") else left


def _is_line_number(digits):
    """True if bytes are a number of 0 to _MOST_NUMBER."""
    try:
        return 0 <= float(digits) <= _MOST_NUMBER
    except ValueError:
        return False


_KEPT = (b"N", b"RST", b"LINK", b"FD", b"FS", b"FE", b"F:", b"JR=")  # start-up lines, values, who commands, stored jobs, the job's journal


def changes_settings(line):
    """True of a $ line that changes the machine for good: a setting, a startup line, the board's name, the link that commands, a stored job."""
    text = bare_line(line)
    number = text[1:].partition(b"=")[0]
    return text[:1] == b"$" and (text[1:].startswith(_KEPT) or b"=" in text and (number == b"I" or number.isdigit()))


def bare_line(line):
    """Return a $ line as the firmware reads it: in capitals, without / and blanks."""
    return bytes([byte for byte in line if byte > 32 and byte != 47]).upper()


def job_error(line):
    """Return 0, or the number of an error if a job may not have this line, because it changes more than the job's own motion."""
    if b"$" in line.partition(b"=")[0] and bare_line(line) != b"$H":
        return errors.JOB_LINE
    for byte in line:
        if not 32 <= byte < 127 or byte in _REAL_TIME:
            return errors.JOB_LINE
    return 0


def first_job_error(lines):
    """Return (number, error) of the first of [(number, line)] that a job may not have; (0, 0) if all are right."""
    for number, line in lines:
        error = job_error(line)
        if error:
            return number, error
    return 0, 0

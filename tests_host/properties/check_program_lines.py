"""A program's bytes as lines to send, under CPython and MicroPython, where a browser's tab reads them."""

import pc_modules  # noqa: F401: before host_tools
from draws import Random
from host_tools.clients.grbl_wire import number_line
from host_tools.programs.program_lines import (
    WrongLetter, changes_settings, ends_program, first_job_error, job_error, program_lines, raw_lines_of, strip_line,
)  # fmt: skip
from passo import errors
from router import Machine, answers

CASES = {"check_no_byte_beyond_ascii_is_sent": (("seed", "seed"),), "check_what_is_sent_is_what_stands": (("seed", "seed"),)}
_WORDS = ("G1", "G0", "X", "X1", "Y2", "Y", "N5", "N", "N7.", "N+3", "N1.5", "-", "-3", "+2", ".5", "/", "4", "S", "S0:500", ":3", "=@@", "@", "%", "$H", "(a)", " ", ";x", "*71", "F900", "E3", "M3")
_COMMON = b"GMNXS=@123 ().;%\n$/?"
_MINUS = b"\xe2\x88\x92"
_DOT = b"\xc2\xb7"
_NO_BREAK = b"\xc2\xa0"
_THIN = b"\xe2\x80\xaf"


def _read(text):
    told = []
    lines = list(program_lines(raw_lines_of(text), lambda *ended: told.append(ended)))
    return lines, told


def _wrong(text):
    try:
        _read(text)
    except WrongLetter as wrong:
        return wrong.number, wrong.letter
    return None


def check_what_is_sent():
    """Comments, blanks, program numbers and N words of the file are not."""
    lines, told = _read(b"\xef\xbb\xbf%\r\nO1000\n(a; b) N10 G1 X1 (?!) Y2 ; M30\n\n N20 x3 ; (\n:7\n/G1(c\nN5 S=@N@M\n")
    assert lines == [(3, b"G1X1Y2"), (5, b"x3"), (7, b"G1"), (8, b"S=@N@M")] and not told


def check_n_words_the_controller_refuses_stay():
    for line in (b"NX1", b"N1N2X1", b"N-3X1", b"N99999999X1", b"N5$20=0", b"N5$X", b"N5$H", b"N5%"):
        assert _read(line)[0] == [(1, line)]


def check_an_n_word_joins_nothing():
    """Removing one would join its neighbours to another word: X-3, S0:500, S=@@, X12, M30. The line stays, and the board refuses it."""
    for line in (b"XN5-3", b"G1X1YN5+3", b"X1N5.5.5", b"S0:500N5:3", b"SN5=@@", b"N5=@@", b"X1N5@", b"N5*71", b"N5-3X1", b"X1N5%"):
        assert _read(line)[0] == [(1, line)]
    assert _read(b"X1N5/2Y1")[0] == [(1, b"X1Y1")]
    assert _read(b"XN5Y2\nN+5X1\nX2N5.\nG1N5X1\nn7y1")[0] == [(1, b"XY2"), (2, b"X1"), (3, b"X2"), (4, b"G1X1"), (5, b"y1")]
    assert _read(b"M3/0\nX1") == ([(1, b"M30")], [(1, 1)])


def check_what_is_sent_is_what_stands(seed):
    """A line as it stands and the line that is sent do the same on a board: both are refused, or both move it alike."""
    random = Random(seed)
    lines = ["".join([random.choice(_WORDS) for _ in range(random.between(1, 6))]) for _ in range(3)]
    as_they_stand, as_sent = Machine().ready(), Machine().ready()
    for line in lines:
        sent = [number_line(7, text).decode() for _, text in _read(line.encode())[0]]
        wanted = answers(as_they_stand.ask(line))
        got = answers(as_sent.ask(sent[0])) if sent else wanted  # a program's number, or nothing
        assert (wanted == ["ok"]) == (got == ["ok"]), (line, sent, wanted, got)
        as_they_stand.settle()
        as_sent.settle()
        assert as_they_stand.controller.position() == as_sent.controller.position(), (line, sent)


def check_letters_beyond_ascii():
    """A minus that is none moves the axis the other way; in a comment it costs nothing, and nothing of it is sent."""
    assert _wrong(b"G21\nG1X" + _MINUS + b"5") == (2, "\u2212")
    assert _wrong(b"G1X1" + _DOT + b"5") == _wrong(b"G1X1\xb75") == (1, "\xb7")
    assert _wrong(b"G1X1?") == (1, "?") and _wrong(b"G0\x18") == (1, "\x18")
    for blank in (_NO_BREAK, _THIN, b"\xa0", b"\xef\xbb\xbf", b"\xe2\x80\x8b", b"\t"):
        assert _read(b"G1" + blank + b"X1(\xd0\x97)" + blank + b";" + _MINUS)[0] == [(1, b"G1X1")]


def check_where_a_program_ends():
    for end in (b"M2", b"M30", b"m02", b"M 3 0", b"G0X0 M30", b"M2.0", b"N9M2", b"M5M30", b"M+2", b"m+30."):
        lines, told = _read(b"G0X1\n" + end + b"\n%\n\nG1 X9\nnotes: M\xc3\xbcller\n")
        assert lines[0] == (1, b"G0X1") and len(lines) == 2 and told == [(2, 2)]
    for goes_on in (b"M3", b"M20", b"M300", b"S=@@M2", b"$N0=M30", b"(M30)", b"M2.5", b"G2X30"):
        assert len(_read(goes_on + b"\nG0X1")[0]) == (1 if goes_on[:1] == b"(" else 2)
    assert _read(b"%\n\n(x)\n%\nG0X1\n%\nG0X2\n%\n") == ([(5, b"G0X1")], [(6, 1)])
    assert _read(b"G0X1\nM30\n%\n\x1a\n") == ([(1, b"G0X1"), (2, b"M30")], [])


def check_what_a_job_may_not_have():
    for line in (b"$20=0", b"$N0=G91G0X5", b"$J=G91X1F1", b"$", b"$$", b"/$20=0", b"$HX", b"$RST=*", b"$F=A", b"X1!", b"X1?", b"G0\x18", b"G0\x84", b"G0\nG1"):
        assert job_error(line) == errors.JOB_LINE
    for line in (b"N5$20=0", b"N5$H", b"%$X"):
        assert job_error(line) == errors.JOB_LINE
    for line in (b"$H", b"$h", b"N3G1X1", b"S=@@_@", b"(x)", b"G1 X1"):
        assert job_error(line) == 0
    assert first_job_error([(1, b"G0"), (7, b"$X")]) == (7, errors.JOB_LINE) and first_job_error([(1, b"$H")]) == (0, 0)


def check_what_is_asked_before_it_is_sent():
    for line in (b"$N", b"$N0=G0", b"$RST=$", b"$100=1", b"$I=me", b"$LINK", b"$LINK=0", b"$ 2 0=1", b"/$n1=", b"$FD=PART", b"$fs=A,GRBL,1,0,1", b"$F:AAAA", b"$FE", b"$JR=1"):
        assert changes_settings(line)
    for line in (b"$H", b"$X", b"$J=G91X1F1", b"$I", b"$$", b"$#", b"G10L2P1X0", b"$WEAVE=1", b"$F", b"$F=PART", b"$JR"):
        assert not changes_settings(line)


def check_no_byte_beyond_ascii_is_sent(seed):
    """Whatever a file holds: its lines are printable ASCII without real-time commands, or it is refused."""
    random = Random(seed)
    data = bytes([random.between(0, 255) if random.choice((0, 1, 2, 3)) == 0 else random.choice(_COMMON) for _ in range(random.between(1, 60))])
    try:
        lines = _read(data)[0]
    except WrongLetter as wrong:
        assert ord(wrong.letter) > 127 or wrong.letter in "?!~\x18"
        return
    for _number, line in lines:
        assert line and not [byte for byte in line if not 32 < byte < 127 or byte in b"?!~"]
        assert strip_line(line) == line or b"(" in line or b";" in line
    assert len([line for _, line in lines[:-1] if ends_program(line)]) == 0

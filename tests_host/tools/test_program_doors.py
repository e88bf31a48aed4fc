"""A program is read by one rule wherever it enters: letters beyond ASCII, its end, N words, lines that no job may have."""

import json
import random
import re
import shutil
import subprocess

import pytest
from running_router import Running

from host_tools import boards
from host_tools.cli import check, jobs, stream
from host_tools.clients.grbl import GrblClient, Refused
from host_tools.failure import Failure
from host_tools.page.job import Job
from host_tools.panel.drawing_jobs import gcode_of
from host_tools.panel.store import Store, gcode_lines
from host_tools.programs import compiler, gcode_file, stored_job
from host_tools.programs.program_lines import WrongLetter, program_lines, raw_lines_of
from host_tools.resources import FIRMWARE
from host_tools.shop import uploads
from host_tools.sim.tab_jobs import Jobs
from passo import errors
from passo.config.boardfile import check as checked

PAGE = FIRMWARE / "passo" / "web" / "page"
MINUS = "G21 G90\nG1 X20 F600\nG1 X−5\nM2\n"


class AsItIs:
    settings = {}


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "jobs", gcode_lines, gcode_of(checked(boards.load("router_3axis")), AsItIs))


@pytest.fixture
def part(tmp_path):
    return tmp_path / "part.nc"


def page_bytes(tmp_path, texts):
    """Return the output of the board's own page for files, by node: bytes, or a dict with the reason of the refusal."""
    if not shutil.which("node"):
        pytest.skip("there is no node: the page's scripts were NOT run")
    for name in ("pack.js", "program.js"):
        shutil.copy(PAGE / name, tmp_path)
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "files.json").write_text(json.dumps([list(text) for text in texts]))
    (tmp_path / "run.js").write_text("""
        import { readFileSync } from "node:fs";
        import { jobBytes } from "./pack.js";
        import { decode, programLines } from "./program.js";
        console.log(JSON.stringify(JSON.parse(readFileSync("files.json")).map((bytes) => {
          const data = Uint8Array.from(bytes), made = jobBytes("grbl", data), { last, behind } = programLines(decode(data));
          return { made: made instanceof Uint8Array ? Array.from(made) : made, last, behind };
        })));
    """)
    done = subprocess.run(["node", "run.js"], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60)
    return json.loads(done.stdout)


# --- letters beyond ASCII

DOORS = {
    "check": lambda path, store: check.check(path, "router_3axis", None, None),
    "check ngc": lambda path, store: check.check(path, "router_3axis", None, None, dialect="ngc"),
    "stream": lambda path, store: stream.stream(path, "/nowhere", 115200, "count", False, False, None, 5.0),
    "stored": lambda path, store: stored_job.gcode_job(path),
    "folder": lambda path, store: gcode_lines(path),
    "shop": lambda path, store: uploads.job_of(path.name, path.read_bytes(), "corexy_plotter"),
    "upload": lambda path, store: _told(store.put_job("a.nc", path.read_text(encoding="utf-8"))),
    "agent": lambda path, store: _agent(path),
}


def _told(answer):
    if answer:
        raise Failure("{}", answer["text"])


def _agent(path):
    from host_tools.shop.work import _lines_of

    return _lines_of(path.read_bytes())


@pytest.mark.parametrize("door", DOORS)
def test_a_minus_that_is_none_is_told(door, part, store):
    """The line, the letter and its name; in a comment it costs nothing."""
    part.write_text(MINUS, encoding="utf-8")
    with pytest.raises(Failure, match=r"line 3: “−” \(U\+2212 MINUS SIGN\) is no letter of G-code"):
        DOORS[door](part, store)


LETTERS = [(b"G1X1\xc2\xb75", "“·” (U+00B7 MIDDLE DOT)"), (b"G1X\x965", "(U+0096 EN DASH)"), (b"G1X1\xb75", "“·” (U+00B7 MIDDLE DOT)"),
           (b"G1X\xd9\xa3", "“٣” (U+0663 ARABIC-INDIC DIGIT THREE)"), (b"G1X1!", "“!” (U+0021 EXCLAMATION MARK)"), (b"G0\x18", "(U+0018)")]  # fmt: skip


@pytest.mark.parametrize("raw, name, dialect", [(*each, dialect) for each in LETTERS for dialect in ("plain", "ngc", "num") if dialect == "plain" or not each[0].isascii()])
def test_letters_have_names(raw, name, dialect, part):
    part.write_bytes(b"(a)\n" + raw + b"\n")
    with pytest.raises(Failure, match=re.escape(f"line 2: {name}")):
        list(compiler.read(part, dialect).rows())


def test_letters_in_comments_cost_nothing(part, store, tmp_path):
    text = "(Größe З −)\nG21\u00a0G91\u202f(ç)\nG1 X1 F600 ; − · 5\nM2\n"
    part.write_text(text, encoding="utf-8")
    check.check(part, "router_3axis", None, None)
    assert stored_job.gcode_job(part) == b"\nN2G21G91\nN3G1X1F600\nN4M2\n"
    assert store.put_job("a.nc", text) == 0 and store.lines_of("a.nc") == [(2, b"N2G21G91"), (3, b"N3G1X1F600"), (4, b"N4M2")]
    assert Jobs({"a.nc": text}, "grbl").lines_of("a.nc") == store.lines_of("a.nc")
    assert uploads.job_of("a.nc", text.encode(), "corexy_plotter")[1].decode() == text
    assert Jobs({"a.nc": MINUS}, "grbl").lines_of("a.nc") == {"error": errors.JOB_LINE, "line": 3, "text": ""}
    for line in (b"G1X1\xe2\x88\x92", "$I=Fräse".encode()):
        with pytest.raises(Refused, match="only ASCII"):
            GrblClient._send_line(None, line)


# --- the page's own reader

PIECES = ["G1", "X", "Y2", "-", ".5", "M2", "M30", "M3", "M 30", "N10", "N", "N7.", "-3", "+2", "*71", "3", "@", "E3", "%", "(", ")", ";", "$H", "$20=0", "/", "S=@@", "=", ":", "O12", " ", "\t", "\r", "\n", "\n", "\n", "\r\n",
          "−", "·", "\u00a0", "\ufeff", "\u2003", "?", "!", "\x18", "\x1a", "\x7f", "é", "З", "X1", "\u0085", "\u2028", "𝟑"]  # fmt: skip


def _python_says(data):
    told = {"last": 0, "behind": 0}
    try:
        lines = list(program_lines(raw_lines_of(data), lambda last, behind: told.update(last=last, behind=behind)))
    except WrongLetter as wrong:
        return {"made": {"line": wrong.number, "letter": wrong.letter}}
    return {"lines": lines, **told}


def test_the_page_reads_as_the_pc_does(tmp_path):
    """Bytes that are stored, what is refused, and how many lines follow the end: the same of 3000 random files."""
    draw = random.Random(57)
    texts = ["".join(draw.choice(PIECES) for _ in range(draw.randint(1, 25))).encode(draw.choice(["utf-8", "utf-8", "latin-1"]), "ignore") for _ in range(3000)]
    texts += [MINUS.encode(), b"G0X1\nM30\n\nG1X2\n", b"G1" + b"X" * 71, b"G1" + b"X" * 70, b"X" * 240, b"S=" + b"@" * 240]
    refused = ended = 0
    for data, page in zip(texts, page_bytes(tmp_path, texts)):
        pc = _python_says(data)
        if "made" in pc:
            refused += 1
            assert page["made"] == pc["made"], data
            continue
        lines = pc["lines"]
        if pc["behind"]:
            ended += 1
            assert (page["last"], page["behind"]) == (pc["last"], pc["behind"]), data
        try:
            list(gcode_file.jobs_only(lines))
        except Failure as failure:
            assert str(failure).startswith(f"line {page['made']['line']}, {page['made']['text']}: error 184"), data
        else:
            assert page["made"] == (list(stored_job.gcode_lines(lines)) if lines else None), data
    assert refused > 300 and ended > 100


# --- where a program ends

M30_AMID = b"G21 G90 G54\nG0 X5 Y5\nG1 X10 F600\nM30\nG1 X40\nG1 Y40\nM2\n"
BEHIND_PERCENT = b"%\nG21 G90\nG1 X12 F600\n%\nSetup sheet: clamp at left\nG1 X60 F600\n"


@pytest.mark.parametrize("text, end, behind, far", [(M30_AMID, 4, "3 lines", "10.000"), (BEHIND_PERCENT, 4, "2 lines", "12.000"), (b"G21 G91\nG1 X3 F600\nM2\nX1\n", 3, "1 line", "3.000")])
def test_a_program_ends(text, end, behind, far, part, capsys, store):
    part.write_bytes(text)
    check.check(part, "router_3axis", None, None)
    said = capsys.readouterr()
    assert re.search(rf"X +0\.000 … +{far} mm", said.out)
    assert f"part.nc ends at line {end}; what stands behind it is no part of the program: {behind}\n" in said.err
    assert stored_job.gcode_job(part).count(b"\n") <= end and store.put_job("a.nc", text.decode()) == 0 and store.lines_of("a.nc")[-1][0] <= end


def test_what_is_streamed_and_stored_ends(tmp_path, part, capsys):
    part.write_bytes(M30_AMID)
    board = Running("fast", jobs={"language": "grbl", "folder": str(tmp_path / "flash")})
    try:
        stream.stream(part, board.line.name, 115200, "count", False, True, None, 5.0)
        assert board.position()[0] == round(10 * 160) or board.position()[0] > 0
        stood = board.position()
        said = capsys.readouterr()
        assert "part.nc: 4 lines in" in said.out and "ends at line 4" in said.err
        jobs.store(part, "PART", "grbl", port=board.line.name)
        assert "ends at line 4" in capsys.readouterr().out
        jobs.run("PART", False, True, board.line.name, 115200)
        assert board.position() == stood
    finally:
        board.close()


def test_no_end_but_those(part, capsys):
    """A closing % and blank lines behind M30 are no news."""
    part.write_bytes(b"%\nG21\nG1 X1 F600\nM30\n%\n\n")
    check.check(part, "router_3axis", None, None)
    assert "ends at line" not in capsys.readouterr().err


# --- what changes a machine for good

SETTINGS = [b"$20=0", b"$110=9", b"$N0=G91G0X5", b"$RST=*", b"$I=mine", b"$LINK=0", b"$J=G91X1F100", b"$X", b"$", b"/ $20=0", b"(a) $ 1 = 2"]


@pytest.mark.parametrize("line", SETTINGS)
@pytest.mark.parametrize("door", ["stored", "folder", "shop", "agent", "upload"])
def test_a_job_changes_no_setting(line, door, part, store):
    part.write_bytes(b"G21\n" + line + b"\n")
    with pytest.raises(Failure, match="line 2, .*error 184"):
        DOORS[door](part, store)
    part.write_bytes(b"G21\n$h\nG91\n")
    if door != "shop":  # the virtual board of the shop has not homed
        DOORS[door](part, store)


class Machine:
    state = {"state": "Idle"}

    def busy_error(self):
        return 0


@pytest.mark.parametrize("line", [*SETTINGS, b"G0X1\x18", b"G0X1?", b"G1\x90"])
def test_a_job_is_looked_at_again_where_it_is_sent(line):
    machine = Machine()
    job = Job(machine)
    line = line.replace(b"(a) ", b"")
    assert job.run("a.nc", [(1, b"N1G21"), (7, line)], 1, False) == {"error": errors.JOB_LINE, "line": 7} and not job.is_running()


def test_stream_asks_before_it_changes_settings(part, monkeypatch):
    """Nobody is there: it says how. A user who agrees sends it."""
    part.write_bytes(b"G21\n$110=3000\nM2\n")
    with pytest.raises(Failure, match=r"line 2, \$110=3000: .*--allow-settings"):
        stream.stream(part, "/nowhere", 115200, "count", False, True, None, 5.0)
    with pytest.raises(Failure, match="cannot open"):
        stream.stream(part, "/nowhere", 115200, "count", False, True, None, 5.0, allow_settings=True)
    for answer, why in (("y\n", "cannot open"), ("\n", "not sent: line 2")):
        monkeypatch.setattr("sys.stdin", Terminal(answer))
        with pytest.raises(Failure, match=why):
            stream.stream(part, "/nowhere", 115200, "count", False, True, None, 5.0)


class Terminal:
    def __init__(self, answer):
        self.readline = lambda: answer

    def isatty(self):
        return True


# --- N words of the file's own

def test_n_words_do_not_hide_the_line(part, store, capsys):
    """Numbers in tens, twice the same, or falling: reports, errors and --from go by the file's line."""
    part.write_bytes(b"N10 G21 G91\n\nN30 G1 X1 F600\nN30 X1\nN5 X1 Q\nN6 M2\n")
    assert gcode_file.read(part)[2:4] == [(4, b"X1"), (5, b"X1Q")]
    assert stored_job.gcode_job(part).split(b"\n")[:4] == [b"N1G21G91", b"", b"N3G1X1F600", b"N4X1"]
    with pytest.raises(Failure, match="1 line would be refused; the first is line 5"):
        check.check(part, "router_3axis", None, None)
    store.put_job("a.nc", part.read_text())
    assert store.lines_of("a.nc")[3][1] == b"N5X1Q"


# --- lines that are too long

def test_a_line_too_long_for_the_board_is_error_11(tmp_path, part, capsys):
    """240 characters, and 81, in check and in the check before a job is stored; 80 are right."""
    board = Running("fast", jobs={"language": "grbl", "folder": str(tmp_path / "flash")})
    try:
        for size, wrong in ((240, True), (81, True), (80, False)):
            line = b"G1X1F600Y0." + b"0" * (size - 11)
            part.write_bytes(b"G21\n" + line + b"\nM2\n")
            if wrong:
                with pytest.raises(Failure, match="1 line would be refused; the first is line 2"):
                    check.check(part, "router_3axis", None, None)
                assert f"error 11, the line has {size} characters, and the board takes 80: shorten it" in capsys.readouterr().err
                with pytest.raises(Failure, match=f"line 2, .*error 11, the line has {size} characters"):
                    jobs.store(part, "LONG", "grbl", port=board.line.name)
            else:
                check.check(part, "router_3axis", None, None)
                jobs.store(part, "LONG", "grbl", port=board.line.name)
    finally:
        board.close()


# --- another program on the same port

class Extra:
    """A board's port on which another program's line is answered amid the job."""

    in_waiting = 1

    def __init__(self, at):
        self.at, self.count, self.out, self.sent = at, 0, b"", b""

    def write(self, data):
        self.sent += data
        for byte in data:
            if byte == 63:
                self.out += b"<Idle|MPos:0,0,0|FS:0,0>\r\n"
            elif byte == 24:
                self.out += b"Grbl 1.1h ['$' for help]\r\n"
            elif byte == 10:
                self.count += 1
                self.out += b"ok\r\n" * (1 + (self.count == self.at))

    def read(self, _count):
        data, self.out = self.out, b""
        return data

    def close(self):
        pass


@pytest.mark.parametrize("count", [True, False])
@pytest.mark.parametrize("at", [1, 20, 40])
def test_one_ok_too_many_stops_the_job(at, count):
    port = Extra(at)
    client = GrblClient("ttyX", opened=port)
    lines = [(number, b"G1X%d" % number) for number in range(1, 41)]
    with pytest.raises(Refused, match="one ok too many: another program sends lines to ttyX"):
        for _ in client.stream(lines, count):
            pass
        client.wait_idle()
    assert port.sent.endswith(b"\x18")


# --- files for another verb

FILES = {
    "photo.png": (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(60), "is a picture: passo engrave burns it"),
    "photo.jpg": (b"\xff\xd8\xff\xe0\0\x10JFIF\0" + bytes(60), "is a picture: passo engrave burns it"),
    "sign.svg": (b'<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm"/>', r"is a drawing \(SVG\): passo draw draws it"),
    "plate.dxf": (b"999\nmade by hand\n  0\nSECTION\n  2\nENTITIES\n  0\nENDSEC\n  0\nEOF\n", r"is a drawing \(DXF\): passo draw draws it"),
    "plot.plt": (b"IN;SP1;PU0,0;PD400,400;\n", "is HPGL.*passo draw draws it"),
    "holes.drl": (b"M48\n; a comment\nFMAT,2\nINCH,TZ\nT1C0.0315\n%\nG05\nT1\nX1.0Y2.0\nM30\n", r"is a drill file \(Excellon\), which no verb takes"),
    "top.gbr": (b"G04 Layer: top*\n%FSLAX46Y46*%\n%MOMM*%\nM02*\n", r"is a board's layer \(Gerber\), which no verb takes"),
    "part.stl": (b"solid part\nfacet normal 0 0 1\nouter loop\n", r"is a model \(STL\), which no verb takes"),
    "utf16.nc": ("G21\r\nG1 X5 F600\r\n".encode("utf-16"), "is text in UTF-16, which no verb takes: save it as UTF-8"),
    "be.nc": ("G21\nG1 X5 F600\n".encode("utf-16-be"), "is text in UTF-16, which no verb takes: save it as UTF-8"),
    "page.pdf": (b"%PDF-1.7\n", "is a PDF, which no verb takes"),
    "page.eps": (b"%!PS-Adobe-3.0 EPSF-3.0\n", "is PostScript, which no verb takes"),
}
OWN = {"draw": (".svg", ".dxf", ".plt"), "engrave": (".png", ".jpg")}


@pytest.mark.parametrize(
    "verb, name", [(verb, name) for verb in ("draw", "engrave", "check", "stream", "stored", "compile") for name in FILES if not name.endswith(OWN.get(verb, (" ",)))]
)
def test_a_file_for_another_verb_is_told_by_kind(verb, name, tmp_path):
    from host_tools.drawings import engraving, sources

    path = tmp_path / name
    content, text = FILES[name]
    path.write_bytes(content)
    with pytest.raises(Failure, match=text):
        {"draw": sources.open_drawing, "engrave": engraving.open_picture, "compile": lambda each: compiler.compile_file(each, None)}.get(verb, lambda each: DOORS[verb](each, None))(path)


@pytest.mark.parametrize("text", [b"M48\nG21\nG1 X1 F100\n", b"; solid\nG1X1F100\n", b"%\nO100\nG1X1F100\n%\n", b"(PDF)\nG1X1F100\n", b"N0 SECTION\n", b"IN X1\n", b"G4P1\nG1X1F1\n"])
def test_programs_are_no_other_kind(text, tmp_path):
    path = tmp_path / "part.nc"
    path.write_bytes(text)
    assert gcode_file.read(path)

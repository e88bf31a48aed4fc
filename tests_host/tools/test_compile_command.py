"""`passo compile`, and how `stream` and `check` compile by themselves."""

import re

import pytest
from typer.testing import CliRunner

from host_tools.cli import stream
from host_tools.cli.main import app
from host_tools.clients.grbl import GrblClient, Refused
from host_tools.failure import Failure
from host_tools.programs import compiler, tool_table
from host_tools.resources import ROOT
from running_router import Running

PROGRAM = """\
(two holes, then a square beside its contour)
#<deep>=2
g21 g90
g0 z5
o1 repeat [2]
  g98 g81 x[5+#5420*0] y10 z-#<deep> r1 f600
o1 endrepeat
g80
g0 x-10 y5
g42 d1 g1 x0 y5 f1200
y0
x20
y15
x0
y5
g40 g0 x-10
m2
"""


@pytest.fixture
def part(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text(PROGRAM.replace("[5+#5420*0]", "5"))
    (tmp_path / "tools.tbl").write_text("; the shop's\nT1 P1 D6 Z40 ;end mill\nT2 P2 D3.175 Z55\n")
    return path


def run(*arguments):
    return CliRunner().invoke(app, ["compile", *map(str, arguments)])


def test_listing_and_picture(part, tmp_path):
    out, picture = tmp_path / "part.gcode", tmp_path / "part.svg"
    done = run(part, "--tools", tmp_path / "tools.tbl", "-o", out, "--picture", picture)
    assert done.exit_code == 0, done.output
    rows = out.read_text().splitlines()
    assert rows[0].startswith("G21 G17 G90 G94 G40 G80") and "; 6: g98 g81 x5 y10" in out.read_text()
    assert re.fullmatch(r"G1 X-3 F1200 +; 10: g42 d1 g1 x0 y5 f1200", rows[-12]), rows[-12]
    assert all(";" in row for row in rows)
    labels = set(re.findall(r"<!-- (\d+) -->", picture.read_text()))
    assert {"10", "12", "13", "14"} <= labels
    again = run(out)
    assert again.exit_code and isinstance(again.exception, Failure) and "sent as it is" in str(again.exception)
    assert run(part, "--tools", tmp_path / "tools.tbl", "-o", part).exit_code, "the program is not overwritten"


def test_the_listing_can_be_compiled_again(part, tmp_path):
    """Plain G-code is a program too, and compiles to itself."""
    out = tmp_path / "part.gcode"
    run(part, "--tools", tmp_path / "tools.tbl", "-o", out)
    codes = [row.partition(" ;")[0].strip() for row in out.read_text().splitlines()]
    again = compiler.compile_file(out, "ngc").listing.codes
    assert again == codes


@pytest.mark.parametrize("name", ["flange.ngc", "plate.num"])
def test_the_documents_programs(name):
    """They compile, and the router takes every line."""
    examples = ROOT / "examples"
    done = CliRunner().invoke(app, ["check", str(examples / name), "--tools", str(examples / "tools.tbl")])
    assert done.exit_code == 0 and re.search(r"^Z +-?\d", done.output, re.MULTILINE), done.output


def test_errors_on_the_screen(part, tmp_path):
    for text, wanted in (("g0 x[1/0]", "part.ngc:1: error 303"), ("o1 while [1]\no1 endwhile", "part.ngc:[12]: error 334"), ("(none)", "no line")):
        part.write_text(text)
        done = run(part, "--dialect", "ngc", "--bound", "1000")
        assert done.exit_code
        assert re.search(wanted, str(done.exception)) or text == "(none)"
    part.write_bytes(b"g0 x1\n\0\0")
    assert "no text" in str(run(part).exception)
    assert "cannot read" in str(run(tmp_path / "nothing.ngc").exception)
    part.write_text(PROGRAM)
    (tmp_path / "tools.tbl").write_text("T1 D6\nT1 D7\n")
    assert "tools.tbl:2: tool 1 stands twice" in str(run(part, "--tools", tmp_path / "tools.tbl").exception)
    (tmp_path / "tools.tbl").write_text("D6\n")
    assert "tools.tbl:1: a tool is written like this" in str(run(part, "--tools", tmp_path / "tools.tbl").exception)
    assert "three numbers" in str(run(part, "--start", "1,2").exception)
    assert "num or ngc" in str(run(part, "--dialect", "fanuc").exception)


@pytest.mark.parametrize(
    "name, text, dialect",
    [
        ("a.ngc", "G0 X1\nG2 X5 I2 F100\nG43 H1\nG64 P0.1\nG83 X1 Z-3 R1 Q1 F100\n(O1 CALL #5 [)\n", "plain"),
        ("a.gcode", "G0 X[1]\n", "ngc"), ("a.gcode", "#1=5\n", "ngc"), ("a.gcode", "O1 SUB\nO1 ENDSUB\n", "ngc"),
        ("a.gcode", "G41 D1 X5\n", "ngc"), ("a.gcode", "G40 G42.1 D3\n", "ngc"), ("a.gcode", "G85 X1 Z-1 R1 F5\n", "ngc"),
        ("a.gcode", "M98 P1\n", "ngc"), ("a.gcode", "G5 X1 I1 J1 P1 Q1\n", "ngc"), ("a.gcode", "G5.2 X1\n", "ngc"),
        ("a.gcode", "G54 G0 X1\nG53 G0 X2\nM9\nG50 X1\n", "plain"), ("a.gcode", "G410 X5\nG0 X1\n", "plain"), ("a.gcode", "#<VAL2>=4\n", "ngc"),
        ("a.num", "G0 X5\n", "num"), ("a.nc", "N10 G79 N30\n", "num"), ("a.nc", "L1=5\nXL1\n", "num"), ("a.nc", "G77 H10\n", "num"),
        ("a.nc", "G81 X5 Z-3 ER2\n", "num"),
    ],
)  # fmt: skip
def test_detection(tmp_path, name, text, dialect):
    path = tmp_path / name
    path.write_text(text)
    assert compiler.detect_dialect(path)[0] == dialect


@pytest.mark.parametrize("text", ["IN;SP1;PU100,100;PD200,200;", "IN;\nSP1;", "\n  PA;PU0,0", "\x1b.@;1:IN;", "pu10,10;", "DF;", "SP1;PD"])
def test_hpgl_is_no_g_code(tmp_path, text):
    path = tmp_path / "a.plt"
    path.write_text(text)
    with pytest.raises(Failure, match="is HPGL"):
        compiler.read(path)
    for other in ("; IN;SP1\nG0 X1", "(PU)\nS1000 M3", "P1 G4", "S1", "%\nG0 X1"):
        path.write_text(other)
        compiler.read(path)


def test_subprograms_in_files(tmp_path):
    """Beside the program, in its folder `subs`, and by a path; M98 takes a number."""
    for name, text in (("lib/far.ngc", "o<lib/far> sub\ng0 x1\no<lib/far> endsub\n"), ("subs/near.ngc", "o<near> sub\ng0 x2\no<near> endsub\n"),
                       ("subs/0012.ngc", "o12\ng0 x3\nm99\n")):  # fmt: skip
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    main = tmp_path / "main.ngc"
    main.write_text("o<lib/far> call\no<near> call\nm98 p12 l2\ng0 y1\nm30\n")
    assert compiler.compile_file(main, "ngc").listing.codes[1:] == ["G0 X1", "G0 X2", "G0 X3", "G0 Y1", "M30"]


def test_a_table_in_inches(tmp_path):
    table = tmp_path / "inch.tbl"
    table.write_text("T1 P1 D6 Z10\n;inch\nT2 P2 D0.25 Z2 ; an end mill\n")
    assert tool_table.read(table) == {1: tool_table.Tool(6.0, 10.0), 2: tool_table.Tool(6.35, 50.8)}


def test_detection_of_both(tmp_path):
    path = tmp_path / "both.nc"
    path.write_text("#1=5\nG79 N10\n")
    with pytest.raises(Failure, match="num .line 2 has G79. and ngc .line 1 has #"):
        compiler.read(path)


def test_stream_compiles(part, tmp_path, capsys):
    """The program's own lines in progress and errors; the machine ends where the program does."""
    with Running("fast") as running:
        stream.stream(part, running.line.name, 115200, "count", False, True, None, 5.0, tools=tmp_path / "tools.tbl")
        assert running.position() == [-10 * 320, 5 * 320, 5 * 400]
        assert "compiled as ngc, because line 2 has #" in capsys.readouterr().err
        part.write_text("#1=3\ng0 x1\no1 repeat [3]\nm62 p#1\no1 endrepeat")
        with pytest.raises(Refused, match=r"part.ngc:4, listing line 3, M62P3: error"):
            stream.stream(part, running.line.name, 115200, "count", False, True, None, 5.0)
        program = compiler.read(part)
        with GrblClient(running.line.name) as client, stream.Panel(client, list(program.rows()), None, program.origin) as panel:
            panel.count_line(2)
            assert "part.ngc" in panel.progress_text()


def test_check_compiles(part, tmp_path):
    done = CliRunner().invoke(app, ["check", str(part), "--tools", str(tmp_path / "tools.tbl")])
    assert done.exit_code == 0, done.output
    assert re.search(r"X +-10.000 … +23.000 mm", done.output) and re.search(r"Z +-2.000 … +5.000 mm", done.output)
    part.write_text("#1=9\ng0 x1\nm62 p#1\n")
    done = CliRunner().invoke(app, ["check", str(part)])
    assert "part.ngc:3: listing line 3: M62P9: error" in done.output and "the first is part.ngc:3" in str(done.exception)


# --- what is deep or long ends in a sentence

DEEP = {
    "hashes": ("ngc", "G1 X{}1 F100", "#", ""), "a parameter of hashes": ("ngc", "{}1=3", "#", ""), "brackets": ("ngc", "G1 X{}1{} F100", "[", "]"),
    "open brackets": ("ngc", "G1 X{} F100", "[", ""), "minus": ("ngc", "#1=2\nG1 X{}#1 F100", "-", ""), "signs": ("ngc", "#1=2\nG1 X{}#1 F100", "-+", ""),
    "functions": ("ngc", "G1 X{}0{} F100", "abs[", "]"), "arcs of the tangent": ("ngc", "G1 X{}0{} F100", "atan[", "]/[1]"),
    "exists": ("ngc", "G1 X{}0{} F100", "exists[#", "]"), "hashes and brackets": ("ngc", "G1 X{}1{} F100", "#[", "]"),
    "a condition": ("ngc", "o1 while [{}1{} GT 2]\no1 endwhile", "[", "]"), "a call": ("ngc", "o1 sub\no1 endsub\no1 call [{}1{}]", "[", "]"),
    "a label": ("ngc", "o1 sub\no1 endsub\no{}1{} call", "[", "]"), "minus and brackets": ("ngc", "G1 X{}1{}", "-[", "]"),
    "functions of NUM": ("num", "N1 G1 X{}1 F100", "S", ""), "functions with signs": ("num", "N1 L1={}1", "S-", ""), "a condition of NUM": ("num", "N1 G79 L1>{}1 N1", "T", ""),
}  # fmt: skip


@pytest.mark.parametrize("times", [60, 1000, 5000])
@pytest.mark.parametrize("kind", DEEP)
def test_what_is_deep_ends_in_a_sentence(kind, times, tmp_path):
    dialect, text, begin, end = DEEP[kind]
    file = tmp_path / f"deep.{dialect}"
    file.write_text(("%1\n" if dialect == "num" else "") + text.format(begin * times, end * times) + "\nM2\n")
    for verb in ("compile", "check"):
        result = CliRunner().invoke(app, [verb, str(file), "--dialect", dialect])
        assert isinstance(result.exception, Failure), result.exception
        assert re.search(r":[1-3]: error (333: too many calls or values inside each other: 50 at most|301: .*50 inside each other at most)$", str(result.exception))


@pytest.mark.parametrize("text", ["#1=1\nG1 X" + "#" * 40 + "1 F100", "#1=2\nG1 X" + "-" * 40 + "#1 F100", "G1 X" + "[" * 50 + "2" + "]" * 50 + " F100", "#2=2\nG1 X" + "#[" * 20 + "2" + "]" * 20 + " F100"])
def test_what_is_less_deep_is_worked_out(text, tmp_path):
    file = tmp_path / "a.ngc"
    file.write_text(text + "\nM2\n")
    result = run(file, "--dialect", "ngc", "-o", tmp_path / "a.nc")
    assert result.exit_code == 0 and re.search("X[12]\\b", (tmp_path / "a.nc").read_text()), result.exception


LONG = {
    "ngc": ("N{} G1 X1 F100", "O{}\nG1 X1 F100", "o{} sub\no{} endsub", "G1 X{} F100", "G{}", "#{}=1", "T{} M6", "o{} call"),
    "num": ("N{} G1 X1 F100", "N1 L{}=1", "N1 G{} X1", "%{}\nN1 G1 X1 F100", "N1 G77 H{}", "N1 G77 N{}", "N1 G1 X{} F100", "N1 T{} M6", "N1 G1 X1 F100\n%{}\nN2", "%²\nN1"),
}


@pytest.mark.parametrize("dialect, text", [(dialect, text) for dialect in LONG for text in LONG[dialect]])
def test_a_number_of_many_digits_ends_in_a_sentence(dialect, text, tmp_path):
    """Python itself takes 4300."""
    file = tmp_path / f"long.{dialect}"
    file.write_text(("%1\n" if dialect == "num" and text[0] != "%" else "") + text.replace("{}", "9" * 5000) + "\nM2\n")
    result = run(file, "--dialect", dialect, "-o", tmp_path / "out.nc")
    assert result.exception is None or isinstance(result.exception, (Failure, OSError)), result.exception

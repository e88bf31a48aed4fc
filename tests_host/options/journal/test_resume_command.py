"""`passo resume` against the firmware of the router."""

import pytest
from PIL import Image
from typer.testing import CliRunner

from host_tools.cli import jobs, resume
from host_tools.cli.main import app
from host_tools.drawings import engraving
from host_tools.drawings.engraving import Machine, Options
from host_tools.programs.resume_line import number_of, resume_point
from host_tools.clients.grbl import GrblClient, Refused
from host_tools.clients.grbl_wire import number_line
from host_tools.failure import Failure
from host_tools.programs import compiler, gcode_file, stored_job
from passo import commands
from router import BOARD, LASER
from running_router import Running

PART = b"G21 G90\nG1 X20 Y5 F3000\nG1 X20 Y15\nG1 X5 Y15\nG0 X0 Y0\nM30\n"


@pytest.fixture
def board():
    running = Running("fast", journal={"every_ms": 100})
    yield running
    running.close()


@pytest.fixture
def part(tmp_path):
    path = tmp_path / "part.nc"
    path.write_bytes(PART)
    return path


def begin(client, lines, count):
    """Home, and send the first `count` lines as passo stream does."""
    client.connect()
    client.command("$H", 600)
    client.command(f"$JR={number_of(lines):08x}")
    for number, line in lines[:count]:
        client.command(number_line(number, line).decode())


def test_a_lost_pc(board, part, capsys):
    """The PC sends three lines and is gone: the board ends them, and goes on behind them without homing."""
    with pytest.raises(Failure, match="journal is empty"):
        resume.resume(part, board.line.name, 115200, yes=True)
    lines = gcode_file.read(part)
    with GrblClient(board.line.name) as client:
        begin(client, lines, 3)
    resume.resume(part, board.line.name, 115200, yes=True)
    assert "interrupted before line 4" in capsys.readouterr().out
    assert board.position() == [0, 0, 0]
    resume.resume(part, board.line.name, 115200, yes=True)
    assert "interrupted before line 6" in capsys.readouterr().out  # which ends the program, and does not move
    part.write_bytes(b"G4P0\n" + PART)
    with pytest.raises(Failure, match="another file"):
        resume.resume(part, board.line.name, 115200, yes=True)


def test_a_wait_for_an_input(tmp_path, capsys):
    """Interrupted amid M66 a job goes on with it."""
    part = tmp_path / "part.nc"
    part.write_bytes(b"G21 G90\nG1 X20 Y5 F3000\nM66 P0 L3 Q9000\nG1 X5 Y15\nM30\n")
    lines = gcode_file.read(part)
    with Running("fast", journal={"every_ms": 100}, inputs=[*BOARD["inputs"], {"name": "p0", "pin": 20, "active": 1, "pull": "down"}]) as running:
        running.world.switches["p0"] = 0
        machine = running.app.controller.machine
        with GrblClient(running.line.name) as client:
            begin(client, lines, 2)
            client.real_time(number_line(*lines[2]) + b"\n")
            running.until(lambda: machine.busy_with(commands.CODE + 66) and running.app.controller.queue.still())
            client.reset()
        assert machine.command is None
        running.world.switches["p0"] = 1
        resume.resume(part, running.line.name, 115200, yes=True)
        assert "interrupted before line 3" in capsys.readouterr().out
        assert running.position() == [1600, 4800, 0] and "M66" in str(lines[2])


NGC = "#1=5\no100 while [#1 lt 20]\nG1 X#1 F3000\nG1 Y#1\n#1=[#1+5]\no100 endwhile\nG0 X0 Y0\nM30\n"


def test_a_compiled_program(board, tmp_path, capsys):
    """Streamed as it is, or as the file that passo compile makes of it, it is gone on with as any G-code."""
    part, listing = tmp_path / "part.ngc", tmp_path / "part.gcode"
    part.write_text(NGC)
    program = compiler.compile_file(part, None)
    listing.write_text(program.listing.text(program.texts))
    for file, lines in ((part, list(program.rows())), (listing, gcode_file.read(listing))):
        with GrblClient(board.line.name) as client:
            begin(client, lines, 5)
            client.wait_idle()
        resume.resume(file, board.line.name, 115200, yes=True)
        assert f"interrupted before line {lines[5][0]}" in capsys.readouterr().out
        assert board.position() == [0, 0, 0]


def test_a_picture(tmp_path):
    """passo engrave with --continue goes on with the rows that are left, and with no other picture."""
    Image.linear_gradient("L").resize((12, 6)).save(tmp_path / "sky.png")
    options = Options(width_mm=3, dots_mm=4, shade="grey", power=0.5, origin=(10, 10))
    rows = engraving.rows_of(engraving.powers_of(engraving.open_picture(tmp_path / "sky.png"), options), options)
    with Running("fast", journal={"every_ms": 100}, spindle=LASER) as running:
        asked = ["--lang", "en", "engrave", str(tmp_path / "sky.png"), "--dots", "4", "--shade", "grey", "--power", "50", "--origin", "10,10", "--port", running.line.name]
        with GrblClient(running.line.name) as client:
            client.connect()
            machine = Machine.of_settings(client.command("$$"))
            assert machine.takes_rows(client.command("$I"), True)
            lines = [(number, line.encode()) for number, line in enumerate(engraving.gcode_lines(rows, options, machine), 1)]
            begin(client, lines, len(lines) // 2)
        done = CliRunner().invoke(app, [*asked, "--width", "3.5", "--continue", "--yes"])
        assert done.exit_code == 1 and "another file" in str(done.exception)
        done = CliRunner().invoke(app, [*asked, "--width", "3", "--continue", "--yes"])
        assert done.exit_code == 0 and f"interrupted before line {len(lines) // 2 + 1}" in done.output, (done.output, done.exception)
        assert running.app.controller.machine.state == "idle"


def test_a_board_that_was_reset_has_to_home(board, part):
    lines = gcode_file.read(part)
    with GrblClient(board.line.name) as client:
        client.connect()
        client.command(f"$JR={number_of(lines):08x}")
    with pytest.raises(Failure, match="give --home"):
        resume.resume(part, board.line.name, 115200, yes=True)
    resume.resume(part, board.line.name, 115200, home=True, yes=True)
    assert board.position() == [0, 0, 0] and board.world.steps > 20_000


def test_an_alarm_that_only_a_reset_ends(board, part):
    """A line went out of the travel: where the machine is remains known, and `$X` and `$H` are refused."""
    lines = gcode_file.read(part)
    with GrblClient(board.line.name) as client:
        begin(client, lines, 2)
        with pytest.raises(Refused, match="alarm 2"):
            client.command("G0 X9999")
    with pytest.raises(Failure, match="in alarm: give --home"):
        resume.resume(part, board.line.name, 115200, yes=True)
    resume.resume(part, board.line.name, 115200, home=True, yes=True)
    assert board.position() == [0, 0, 0]


def test_a_stored_job_has_a_journal_too(part, tmp_path, capsys):
    with Running("fast", journal={"every_ms": 100}, jobs={"language": "grbl", "folder": str(tmp_path / "jobs")}) as running:
        port = running.line.name
        jobs.store(part, None, "grbl", check=False, port=port)
        jobs.run("PART.NC", True, True, port, 115200)
        with pytest.raises(Failure, match="no program was interrupted"):
            resume.resume(part, port, 115200, yes=True)
        with GrblClient(port) as client:
            client.command(f"$JR={stored_job.crc_of(stored_job.gcode_job(part)):08x}")
            client.command("N4G21G90G1X5Y15F3000")
            client.command("N5G0X0Y0")
            client.command("G4P0")
        resume.resume(part, port, 115200, yes=True)
        assert "interrupted before line 6" in capsys.readouterr().out


def test_what_the_journal_says(part):
    lines = gcode_file.read(part)
    job = f"{number_of(lines):08x}"
    assert resume_point([f"[JOURNAL:{job}|3|2|6400,1700,0]"], lines) == (3, [6400, 1700, 0], True)
    assert resume_point([f"[JOURNAL:{job}|3|1|6400,4800,0]"], lines) == (4, None, False)
    assert resume_point([f"[JOURNAL:{job}|0|0|0,0,0]"], lines) == (1, None, False)
    with pytest.raises(Failure, match="does not say"):
        resume_point(["ok"], lines)


def test_a_board_without_a_journal(part):
    with Running("fast", journal=None) as running:
        with pytest.raises(Failure, match="no journal"):
            resume.resume(part, running.line.name, 115200)

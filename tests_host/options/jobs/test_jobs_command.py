"""`passo jobs` against the firmware of the router."""

import re
import shutil

import pytest

from host_tools.cli import jobs, status
from host_tools.clients.grbl import GrblClient, Refused
from host_tools.failure import Failure
from host_tools.programs import program_names, stored_job
from host_tools.programs.job_record import Record
from passo.protocols.plotter.host import COMMANDS, packet
from running_router import Running

PART = b"(a part) G21 G90\n\nG1 X20 Y0 F6000 ; there\nG0 X0\nM30\n"


@pytest.fixture
def board(tmp_path):
    running = Running("fast", jobs={"language": "grbl", "folder": str(tmp_path / "flash")})
    running.folder = tmp_path / "flash"
    yield running
    running.close()


@pytest.fixture
def part(tmp_path):
    path = tmp_path / "part one.gcode"
    path.write_bytes(PART)
    return path


def test_jobs_are_numbered_as_their_file(part):
    assert stored_job.gcode_job(part) == b"N1G21G90\n\nN3G1X20Y0F6000\nN4G0X0\nN5M30\n"
    assert stored_job.name_of(part) == "PART_ONE.GCODE"
    assert len(stored_job.name_of("x" * 40)) == 24 and stored_job.name_of(".nc") == "NC"


def test_store_run_and_delete(board, part, capsys):
    port = board.line.name
    jobs.store(part, None, "grbl", port=port)
    assert "PART_ONE.GCODE has not been checked" in capsys.readouterr().out
    jobs.run("part_one.gcode", True, True, port, 115200)
    assert board.position()[0] == 0 and board.world.steps > 12_800
    jobs.check_("PART_ONE.GCODE", port, 115200)
    assert "every line is understood" in capsys.readouterr().out
    jobs.list_(port, 115200)
    assert "PART_ONE.GCODE" in capsys.readouterr().out
    jobs.delete("PART_ONE.GCODE", port, 115200)
    with pytest.raises(Refused, match="error 150"):
        jobs.run("PART_ONE.GCODE", False, True, port, 115200)


def test_a_job_with_an_error_says_its_line(board, part, capsys):
    port = board.line.name
    jobs.store(part, "OLD", "grbl", check=False, port=port)
    part.write_bytes(b"G21\nG1X1F100\nG1X2G7\n")
    with pytest.raises(Refused, match="line 3: error 20"):
        jobs.store(part, "BAD", "grbl", check=False, port=port)
        jobs.run("BAD", True, True, port, 115200)
    with pytest.raises(Failure, match="packet 1 is no packet"):
        jobs.store(part, "BAD", "plotter", port=port)
    with pytest.raises(Failure, match="bytes of flash"):
        free = shutil.disk_usage("/").free
        _too_large(part, free, port)


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_packets_of_a_job_draw_and_do_nothing_else(tmp_path, name):
    """No file may set the machine, give its command away, stop it or jog it."""
    path = tmp_path / "drawing.packets"
    path.write_bytes(packet(COMMANDS["REQUEST"]) + packet(COMMANDS[name], 100, 200))
    if name in ("REQUEST", "LINE", "MOVE", "END", "ORIGIN", "SPEED"):
        assert stored_job.plotter_job(path) == path.read_bytes()
    else:
        with pytest.raises(Failure, match="packet 2 is no part of a drawing"):
            stored_job.plotter_job(path)


def told_job(port):
    with GrblClient(port) as client:
        client.wait_idle()
        return status._job_row(client, client.ask_status())


def test_what_status_says_of_a_stored_job(tmp_path, part, monkeypatch):
    """A job done to its end, with M30 or without, is not offered; status names a stopped one."""
    monkeypatch.setattr(program_names, "KEPT", tmp_path / "begun.json")
    board = Running("fast", jobs={"language": "grbl", "folder": str(tmp_path / "flash")}, journal={"every_ms": 200})
    try:
        port = board.line.name
        for end in (b"", b"M30\n"):
            part.write_bytes(b"G21 G91\nG1 X2 F6000\nG1 X-2\n" + end)
            jobs.store(part, "WHOLE", "grbl", check=False, port=port)
            jobs.run("WHOLE", True, True, port, 115200)
            assert told_job(port) == []
        part.write_bytes(b"G21 G91\n" + b"G1 X2 F6000\nG1 X-2\n" * 60 + b"G1X2G7\n")
        jobs.store(part, "BAD", "grbl", check=False, port=port)
        with pytest.raises(Refused, match="line 122"):
            jobs.run("BAD", False, True, port, 115200)
        assert re.fullmatch(r"stopped (after|amid) line \d+ of BAD, spindle off; passo resume goes on with it", told_job(port)[0][1])
        jobs.delete("BAD", port, 115200)
        assert "has not begun" in told_job(port)[0][1]
        with GrblClient(port) as client:
            number = Record.of_answer(client.command("$JR")).job
        for name, command in (("photo.jpg", "engrave --continue"), ("card", "engrave --continue"), ("map.svg", "resume"), ("part.nc", "resume")):
            program_names.remember_name(number, name, 122)
            assert told_job(port)[0][1].endswith(f" of {name}, spindle off; passo {command} goes on with it")
    finally:
        board.close()


PNG = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"
LETTER = b"Dear Sir,\nplease find enclosed\n"


@pytest.mark.parametrize(
    "content, why",
    [
        (b"", "no line of G-code"),
        (b"; only a comment\n\n", "no line of G-code"),
        (PNG, "is a picture"),
        (LETTER, "line 1, DearSir,: error"),
        (b"G21\nG1X1F100\n" + b"G1X2\n" * 500 + b"G1X2G7\nG1X3\n", "line 503, G1X2G7: error 20"),
    ],
    ids=["empty", "comments", "picture", "letter", "error"],
)
def test_a_stranger_s_file_leaves_the_job_of_that_name(board, part, content, why):
    """With and without a machine that could check it: nobody has homed it."""
    port = board.line.name
    jobs.store(part, "PART", "grbl", port=port)
    part.write_bytes(content)
    with pytest.raises(Failure, match=why):
        jobs.store(part, "PART", "grbl", port=port)
    jobs.run("PART", True, True, port, 115200)
    assert board.position()[0] == 0 and board.world.steps > 12_800


def test_an_upload_that_is_cut_off_leaves_the_job_of_that_name(board, part, monkeypatch):
    """The cable comes off amid the upload, and again; then it is stored."""
    port = board.line.name
    jobs.store(part, "PART", "grbl", port=port)
    long = part.with_name("long.gcode")
    long.write_bytes(b"G21 G90\n" + b"".join(b"G1 X%d F6000\n" % (number * 7919 % 50) for number in range(900)))
    with jobs._connect_client(port, 115200, "grbl") as client:
        data = stored_job.gcode_job(long)
        client.command(f"$FS=PART,grbl,{len(data)},{stored_job.crc_of(data):08x},{len(stored_job.pack_job(data))}")
        client.command("$F:AAAA")
    jobs.run("PART", True, True, port, 115200)
    assert board.world.steps < 100_000
    pack = stored_job.pack_job
    monkeypatch.setattr(stored_job, "pack_job", lambda data: pack(data)[:-40] + bytes(40))  # bytes that are not the file's
    with pytest.raises(Refused, match="error 151"):
        jobs.store(long, "PART", "grbl", port=port)
    monkeypatch.setattr(stored_job, "pack_job", pack)
    jobs.run("PART", False, True, port, 115200)
    jobs.store(long, "PART", "grbl", port=port)
    jobs.list_(port, 115200)
    assert [entry.name for entry in board.folder.iterdir()] == ["PART.job"]


def _too_large(part, free, port):
    packed = stored_job.pack_job
    stored_job.pack_job = lambda data: range(free * 2)  # as long as no memory is
    try:
        jobs.store(part, "BIG", "grbl", check=False, port=port)
    finally:
        stored_job.pack_job = packed


def test_a_job_is_written_on_a_card_and_runs_there(tmp_path, part, capsys):
    """The PC writes twice, one file remains, and a board finds it."""
    for _ in range(2):
        jobs.store(part, "P", "grbl", card=tmp_path)
    assert [path.name for path in (tmp_path / "jobs").iterdir()] == ["P.job"]
    with pytest.raises(Failure, match="no folder"):
        jobs.store(part, "P", "grbl", card=tmp_path / "none")
    with pytest.raises(Failure, match="no job's name"):
        jobs.store(part, "A B", "grbl", card=tmp_path)
    card = {"spi": 0, "sck": 22, "mosi": 19, "miso": 20, "cs": 21}
    with Running("fast", jobs={"language": "grbl", "folder": str(tmp_path / "jobs")}, card=card) as running:
        jobs.run("P", True, True, running.line.name, 115200)
        jobs.list_(running.line.name, 115200)
        assert "P " in capsys.readouterr().out


def test_while_a_job_runs(tmp_path, part):
    running = Running("real", jobs={"language": "grbl", "folder": str(tmp_path / "flash")})
    port = running.line.name
    try:
        part.write_bytes(b"G91\nG1 X2 F60\nG1 X-2\n")
        jobs.store(part, "PART", "grbl", check=False, port=port)
        with jobs._connect_client(port, 115200, "grbl") as client:
            client.command("$X")
        jobs.run("PART", False, False, port, 115200)
        for what in (lambda: jobs.delete("part", port, 115200), lambda: jobs.list_(port, 115200), lambda: jobs.run("PART", False, True, port, 115200)):
            with pytest.raises(Failure, match="the stored job PART is running"):
                what()
    finally:
        running.close()


def test_a_board_without_jobs_says_so():
    with Running("fast") as running:
        with pytest.raises(Failure, match="no key `jobs`"):
            jobs.list_(running.line.name, 115200)

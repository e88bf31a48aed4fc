"""`passo stream`, `passo check` and `passo settings` against the firmware of the router."""

import re
import threading

import pytest

from host_tools.cli import check, main as cli, settings, stream
from host_tools.cli.log import find_language
from host_tools.clients.grbl import RESET, GrblClient, LinkError, Refused, fields_of
from host_tools.clients.grbl_wire import number_line
from host_tools.failure import Failure
from host_tools.programs import gcode_file
from host_tools.sim.job import VirtualJob
from running_router import Running

SQUARE = b"""%
(a square) G21 G90
G1 X20 Y0 F6000 ; first side
Y20

X0
N7 Y0
G2 X0 Y0 I5 J0
M30
%
"""


@pytest.fixture
def board():
    running = Running("fast")
    yield running
    running.close()


@pytest.fixture
def job(tmp_path):
    path = tmp_path / "job.gcode"
    path.write_bytes(SQUARE)
    return path


def test_lines_of_a_file(job):
    lines = gcode_file.read(job)
    assert lines[0] == (2, b"G21G90") and lines[1] == (3, b"G1X20Y0F6000") and lines[-1] == (9, b"M30")
    assert gcode_file.clock_text(59.6) == "1:00" and gcode_file.clock_text(3661) == "1:01:01"
    with pytest.raises(Failure, match="cannot read"):
        gcode_file.read(job.with_name("none"))
    job.write_bytes(b"; nothing\n")
    with pytest.raises(Failure, match="no line"):
        gcode_file.read(job)
    job.write_bytes(b"G0X1\n\x7fELF\0\n")
    with pytest.raises(Failure, match="no text"):
        gcode_file.read(job)


@pytest.mark.parametrize("flow", ["ok", "count"])
def test_stream(board, job, flow, capsys):
    stream.stream(job, board.line.name, 115200, flow, False, True, None, 5.0)
    assert board.position() == [0, 0, 0] and board.world.steps > 4 * 6400
    assert "7 lines" in capsys.readouterr().out


def test_stream_stops_at_the_first_error(board, job):
    job.write_bytes(b"G1 X5 F3000\nX10\n\nG1 E7\nX50\nX60\n")
    with pytest.raises(Refused, match="line 4, G1E7: error 20") as failure:
        stream.stream(job, board.line.name, 115200, "count", False, True, None, 5.0)
    assert failure.value.number == 4
    board.until(lambda: board.app.controller.state == "idle")
    assert board.position()[0] <= 60 * 320 and board.app.controller.queue.still()


def test_stream_wants_an_unlocked_machine(board, job):
    with pytest.raises(Failure, match="alarm"):
        stream.stream(job, board.line.name, 115200, "ok", False, False, None, 5.0)


def test_stream_tells_an_alarm(board, job):
    job.write_bytes(b"G1 X5 F3000\nX6\nX7\nX-1\nX7\n")
    with pytest.raises(Refused, match="(?s)line 4, X-1: alarm 2.*Work zero G54 lies at 0.000,0.000,0.000 of the machine"):
        stream.stream(job, board.line.name, 115200, "count", True, False, None, 5.0)


def test_keys(board, job):
    with GrblClient(board.line.name) as client:
        client.connect()
        for line in ("$X", "$I", "$10=3"):
            client.command(line)
        panel = stream.Panel(client, [(1, b"")])
        client.command("G1X50F60")  # long enough that the pause comes amid it, on any fast PC
        panel.press_key("p")
        board.until(board.standing)
        client.ask_status()
        panel.poll_keys()
        gone = panel.moving_s()
        assert "PAUSED: r resumes" in panel.progress_text() and panel.moving_s() == gone
        assert "0 lines/s, queue 1%" in panel.progress_text()
        assert "Hold" in fields_of("<Hold:0|MPos:0,0,0>")["state"] and "line 1" in panel.progress_text()
        panel.press_key("r")
        board.until(lambda: board.app.controller.state == "idle")
        client.command("G1X0")
        with pytest.raises(stream.Aborted):
            panel.press_key("a")
        assert not board.app.controller.machine.alarm


@pytest.mark.parametrize("prefix", [b"", b"N100"])
def test_progress_is_that_of_the_motion(job, prefix):
    """Everything has been answered long before the machine is there: it says itself where it is, by lines of the file, whatever N words that has."""
    running = Running("real")
    job.write_bytes(b"\n\nG1 F30\n" + b"".join([prefix + b"X%d\n" % (x % 2) for x in range(1, 7)]))
    lines = gcode_file.read(job)
    try:
        with GrblClient(running.line.name) as client, stream.Panel(client, lines) as panel:
            client.connect()
            client.command("$X")
            for number in client.stream(lines, True, None, True):
                panel.count_line(number)
            running.until(lambda: running.world.steps > 0)
            client.real_time(b"!")
            running.until(running.standing)
            client.ask_status()
            panel.poll_keys()
            assert 4 <= panel._line < 9 and "100%" not in panel.progress_text() and "–" not in panel.progress_text()
            client.halt()
    finally:
        running.close()


def test_where_the_queue_was_empty_is_told(board, capsys, monkeypatch):
    """The machine runs, there are more lines, and the queue was fuller before."""
    monkeypatch.setattr(stream, "_WORTH_S", 0)
    with GrblClient(board.line.name) as client:
        panel = stream.Panel(client, [(number, b"X1") for number in range(1, 100)])
        panel._asks = False
        client._notice_line("[OPT:VNMZJ,96,512]")
        for done, free in ((1, 96), (10, 40), (20, 95), (30, 94), (35, 40), (40, 94), (50, 10)):
            while panel._done < done:
                panel.count_line(panel._done + 1)
            client._notice_line("<Run|MPos:0,0,0|Bf:%d,512|Ln:%d|FS:1,0>" % (free, done))
            panel._asked = 0.0
            panel._asks = True
            panel.poll_keys()
        assert panel._starved == [20, 40] and client.window == 512
        panel.print_rate()
    said = capsys.readouterr().out
    assert "lines a second" in said and "nearly empty 2 times, first at line 20" in said


def test_what_may_be_numbered():
    assert number_line(7, b"G1X1") == b"N7G1X1" and len(number_line(9_999_999, b"G" * 72)) == 80
    for number, line in ((7, b"$H"), (7, b"G" * 73), (10_000_000, b"G0"), (7, b"5X1"), (7, b".5X1"), (7, b"=@@")):
        assert number_line(number, line) == line


def test_a_reset_ends_a_job(board, job):
    job.write_bytes(b"M0\nG1 X5 F600\n")
    with GrblClient(board.line.name) as client:
        client.connect()
        client.command("$X")
        asked = []

        def reset():
            if board.standing() and not asked:
                asked.append(client.real_time(RESET))

        with pytest.raises(LinkError, match="line 1, M0: the controller was reset"):
            list(client.stream(gcode_file.read(job), True, reset))


def test_a_board_that_falls_silent_ends_a_job(job):
    running = Running("fast")
    job.write_bytes(b"M0\n")
    stopped = []

    def stop():
        running.until(running.standing)
        running._stop = True
        stopped.append(True)

    stopper = threading.Thread(target=stop)
    try:
        stopper.start()
        with pytest.raises(LinkError, match="no answer any more"):
            stream.stream(job, running.line.name, 115200, "count", False, True, None, 0.7)
        assert stopped
    finally:
        stopper.join()
        running.close()


def test_nobody_answers(tmp_path, job):
    with pytest.raises(Failure, match="cannot open"):
        stream.stream(job, str(tmp_path / "port"), 115200, "ok", False, False, None, 5.0)
    with pytest.raises(Failure, match="count or ok"):
        stream.stream(job, "x", 115200, "xon", False, False, None, 5.0)


def test_check(job, tmp_path, capsys):
    picture = tmp_path / "job.png"
    check.check(job, "router_3axis", picture, None)
    said = capsys.readouterr().out
    assert "0.000 …    20.000 mm" in said and picture.stat().st_size > 10_000
    job.write_bytes(SQUARE.replace(b"M30\n%", b"G1 E1\nM99\n"))
    with pytest.raises(Failure, match="2 lines would be refused; the first is line 9"):
        check.check(job, "router_3axis", None, None)


def test_check_tells_which_line_it_is_at(job, monkeypatch):
    told = []

    class Bar:
        task_ids = [0]

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def update(self, task, completed, description, refresh):
            told.append((completed, description))

    monkeypatch.setattr(stream, "progress_bar", lambda transient: Bar())
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setattr(check, "_TELL_S", 0)
    job.write_bytes(b"".join(b"G1 X%d F3000\n" % (number % 2) for number in range(1, 301)))
    check.check(job, "router_3axis", None, None)
    numbers = [int(re.search(r"line (\d+) of 300$", text)[1]) for _, text in told]
    shares = [share for share, _ in told]
    assert shares == sorted(shares) and shares[0] < 0.4 < 0.9 < shares[-1] <= 1
    assert numbers == sorted(numbers) and len(set(numbers)) > 20 and numbers[0] < 120


@pytest.mark.parametrize("name, table", [("router_3axis", (0, 0, 300, 200)), ("laser_xy", None), ("plotter_2014", (0, 0, 400, 300))])
def test_the_table_of_a_picture_lies_as_the_machine_homes(name, table):
    board = VirtualJob(name).board
    left, bottom, right, top = check.table_mm(board)
    assert table is None or (left, bottom, right, top) == pytest.approx(table)
    for axis, (low, high) in zip(board["axes"], ((left, right), (bottom, top))):
        high_end = axis["name"] in (board["homing"] or {}).get("high_end", "")
        assert (high if high_end else low) == 0 and high - low == pytest.approx(axis["travel_steps"] / axis["steps_per_m"] * 1000)


FAR = b"G21G90\nG1X10Y10F5000\nX%d\nX0\n"


def test_check_fails_what_is_larger_than_the_machine(job, capsys):
    job.write_bytes(FAR % 300)
    check.check(job, "router_3axis", None, None)
    job.write_bytes(FAR % 301)
    with pytest.raises(Failure, match="is larger than the machine: X goes 301.0 of 300.0 mm"):
        check.check(job, "router_3axis", None, None)
    assert "MORE THAN THE TRAVEL" in capsys.readouterr().out


def test_check_knows_soft_limits(job, capsys):
    """The job's place on the machine decides, and the firmware itself names the first line outside."""
    job.write_bytes(FAR % 250)
    check.check(job, "router_3axis", None, "50,20,-30")
    assert "0.000 …   300.000 mm" in capsys.readouterr().out
    with pytest.raises(Failure, match="line 3, X250: alarm 2, the target lies outside"):
        check.check(job, "router_3axis", None, "50.1,20,-30")
    job.write_bytes(b"G1Z-6F600\n")
    with pytest.raises(Failure, match="line 1, G1Z-6F600: alarm 2"):
        check.check(job, "router_3axis", None, "0,0,-75")


@pytest.mark.parametrize("at, text", [
    ("1,2", "has 3 axes, X, Y, Z, and 2 places"), ("0,0,1", "Z1 is not on the machine, which goes from -80 to 0 mm"),
    ("a,b,c", "--at a,b,c: millimetres are wanted"),
])  # fmt: skip
def test_a_place_that_is_none(job, at, text):
    with pytest.raises(Failure, match=text):
        check.check(job, "router_3axis", None, at)


@pytest.mark.parametrize("zero", [None, [20.0, 30.0, -35.0]])
def test_what_is_below_the_program_s_zero_is_drawn_as_cut_wherever_it_lies(zero):
    job = VirtualJob("router_3axis", zero=zero)
    job.run([(1, b"G21G90G0Z2"), (2, b"X0Y0"), (3, b"G1Z-1F600"), (4, b"X5"), (5, b"G0Z2"), (6, b"X9")])
    x = zero[0] if zero else 0.0
    cut = [[place[0] - x for place in places] for lowered, places in job.track.strokes if lowered]
    assert len(cut) == 1 and min(cut[0]) == pytest.approx(0, abs=0.01) and max(cut[0]) == pytest.approx(5, abs=0.01)


def test_check_blocks_time():
    job = VirtualJob("router_3axis")
    job.run([(1, b"G1X10F600"), (2, b"G4P2"), (3, b"X20M0"), (4, b"X0")])
    assert 1 + 2 + 1 + 2 < job.seconds < 6.5 and not job.errors
    assert job.low == [0, 0, 0] and job.high == [20, 0, 0]
    assert 590 <= job.track.fastest[0] <= 612
    assert job.pauses == [(3, "X20M0")]
    assert 240 <= job.track.accelerations()[:, 1].max() <= 270  # $120 is 250
    assert any("line 3: X20M0" in line for line in check.summary_lines(job))


def test_check_probes_nothing():
    """No alarm ends the job, no line of it gets lost, and it is no error."""
    job = VirtualJob("router_3axis")
    job.run([(1, b"G91"), (2, b"G38.2Z-2F300"), (3, b"G1Z1"), (4, b"G38.4Z2"), (5, b"g38.5X5"), (6, b"G1X1"), (7, b"E1")])
    assert job.probes[:2] == [(2, "G38.2Z-2F300"), (4, "G38.4Z2")]
    assert [number for number, _, _ in job.errors] == [7]
    assert job.low[2] == -2 and job.high[0] == 1
    assert any("probe   line 2: G38.2Z-2F300" in line for line in check.summary_lines(job))


def test_check_carries_out_jobs_only():
    job = VirtualJob("router_3axis")
    orders = [(number, line) for number, line in enumerate((b"$H", b"$X", b"$C", b"$SLP", b"$RST=*", b"$h"), 1)]
    job.run(orders + [(7, b"$110=600"), (8, b"G0X2")])
    assert [number for number, _ in job.skipped] == [1, 2, 3, 4, 5, 6] and not job.errors
    assert job.high[0] == 2 and 590 <= job.track.fastest[0] <= 612
    assert any("skipped line 1: $H" in line for line in check.summary_lines(job))


def test_settings_that_wait_for_each_other(board):
    """Steps/mm times speed is bounded: where both change, one may have to go first."""
    with GrblClient(board.line.name) as client:
        client.connect()
        client.command("$X")
        for lines in (("$100=5000.000", "$110=100.000"), ("$100=100.000", "$110=6000.000"), ("$20=0", "$22=0")):
            assert settings.restore_lines(client, list(lines)) == list(lines)
        settings.restore_lines(client, ["$20=1", "$22=1"])
        assert {"$20=1", "$22=1"} <= set(client.command("$$"))
        with pytest.raises(Refused, match="error 12"):
            settings.restore_lines(client, ["$100=99999.000", "$111=900.000"])
        assert "$111=900.000" in client.command("$$")
        client.command("$SLP")
        client.connect()
        assert settings.restore_lines(client, ["$N1=G54"]) == ["$N1=G54"]


def test_settings_round_trip(board, tmp_path, capsys):
    file = tmp_path / "kept.txt"
    with GrblClient(board.line.name) as client:
        client.connect()
        client.command("$X")
        for line in ("$110=1234.5", "$N0=G54", "G10L2P2X1Y-2.5", "$13=0"):
            client.command(line)
    settings.settings(["backup", str(file)], board.line.name, 115200)
    with GrblClient(board.line.name) as client:
        client.command("$RST=*")
    settings.settings(["restore", str(file)], board.line.name, 115200)
    assert "3 of" in capsys.readouterr().out
    settings.settings(["show"], board.line.name, 115200)
    said = capsys.readouterr().out
    assert "x: highest speed" in said and "mm/min" in said and "0.001 … 999999.999" in said
    assert "$110=1234.500" in said and "$N0=G54" in said and "G10L2P2X1.000Y-2.500Z0.000" in said


def backup(board, file):
    settings.settings(["backup", str(file)], board.line.name, 115200)
    return file.read_text().splitlines()


def test_backups_of_older_firmware_are_converted(board, tmp_path, capsys):
    """Masks without a version said what differs from the board file; those of a grbl, and of version 2, mean what they say."""
    file = tmp_path / "kept.txt"
    masks = ["$2=0", "$3=7", "$4=0", "$5=1", "$6=0", "$23=3"]  # the router's, in grbl's words
    lines = backup(board, file)
    assert lines[0] == "; passo settings, version 2" and set(masks) < set(lines)
    old = ["$1=255", "$2=1", "$3=0", "$4=0", "$5=0", "$6=1", "$23=1", "$110=4000.000"]
    for own, wanted in ((["$140=0.000"], ["$2=1", "$3=7", "$5=1", "$6=1", "$23=2"]), ([], ["$2=1", "$3=0", "$5=0", "$6=1", "$23=1"])):
        file.write_text("\n".join(old + own) + "\n")
        settings.settings(["restore", str(file)], board.line.name, 115200)
        assert {"$1=255", "$110=4000.000", *wanted} < set(backup(board, file))
        settings.settings(["restore", str(file)], board.line.name, 115200)
        assert "0 of" in capsys.readouterr().out
    file.write_text("; passo settings, version 2\n" + "\n".join(masks + ["$140=0.000"]) + "\n")
    settings.settings(["restore", str(file)], board.line.name, 115200)
    assert set(masks) < set(backup(board, file))


class OldFirmware:
    """A client of the first firmware, which knows no $MASKS."""

    def command(self, line):
        if line == "$MASKS":
            raise Refused("error 3")
        return ["$23=0", "$140=0.000"]


def test_masks_are_not_sent_to_a_firmware_that_reads_them_otherwise():
    assert settings.convert_backup(OldFirmware(), ["$23=0", "$110=1.000"], 1) == ["$23=0", "$110=1.000"]
    assert settings.convert_backup(OldFirmware(), ["$110=1.000"], 2) == ["$110=1.000"]
    with pytest.raises(Failure, match="older"):
        settings.convert_backup(OldFirmware(), ["$23=3"], 2)


def test_a_failed_homing_is_no_success_to_a_client(board):
    board.world.switches["limit_z"] = 1
    with GrblClient(board.line.name) as client:
        client.connect()
        with pytest.raises(Refused, match="alarm 8"):
            client.command("$H")
        assert client.ask_status()["state"] == "Alarm"


def test_settings_refuses(tmp_path):
    file = tmp_path / "kept.txt"
    file.write_text("$110=1\nhello\n")
    with pytest.raises(Failure, match="line 2"):
        settings.settings(["restore", str(file)], "x", 115200)
    file.write_text("; passo settings, version 3\n$110=1\n")
    with pytest.raises(Failure, match="later passo"):
        settings.settings(["restore", str(file)], "x", 115200)
    file.write_text("\n")
    with pytest.raises(Failure, match="no settings"):
        settings.settings(["restore", str(file)], "x", 115200)
    with pytest.raises(Failure, match="FILE"):
        settings.settings(["backup"], "x", 115200)
    with pytest.raises(Failure, match="there is no setting erase"):
        settings.settings(["erase"], "x", 115200)


def test_what_the_system_refuses_is_one_line(board, job, monkeypatch, capsys):
    words = ["passo", "stream", str(job), "--port", board.line.name, "--log", str(job / "wire.log")]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as left:
        cli.main()
    assert left.value.code == 1 and capsys.readouterr().err == f"passo: {job / 'wire.log'}: Not a directory\n"


def test_stream_from_a_line(board, job, capsys):
    """X20Y20 is gone to with the tool up, then the rest is cut."""
    job.write_bytes(SQUARE.replace(b"G2 X0 Y0 I5 J0\n", b""))
    stream.stream(job, board.line.name, 115200, "count", True, False, None, 5.0, first=6, yes=True)
    assert board.position() == [0, 0, 0]
    assert "3 lines" in capsys.readouterr().out
    with pytest.raises(Failure, match="nobody can be asked"):
        stream.stream(job, board.line.name, 115200, "count", False, False, None, 5.0, first=6)
    with pytest.raises(Failure, match="ends before line 20"):
        stream.stream(job, board.line.name, 115200, "count", False, False, None, 5.0, first=20, yes=True)


class Chatty:
    """A port whose board says something by itself before it answers the first question."""

    def __init__(self, said):
        self._said = said

    def write(self, data):
        pass

    def read(self, count):
        found, self._said = self._said[:count], self._said[count:]
        return found

    def close(self):
        pass


@pytest.mark.parametrize("before", [b"", b"\r\nGrbl 1.1f ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n", b"ok\r\n", b"[MSG:a, b, c, d, e]\r\n" * 9])
@pytest.mark.parametrize("status, language", [(b"<Idle|MPos:0.000>", "grbl"), (b"<idle,0>", "pulses")])
def test_what_a_board_says_by_itself_is_no_other_language(monkeypatch, before, status, language):
    monkeypatch.setattr("host_tools.clients.serial_port.open_port", lambda port, baud: Chatty(before + status))
    assert find_language("/dev/none", 115_200) == language

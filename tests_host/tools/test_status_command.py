"""`passo status`: its rows for reports, and for boards of each language."""

import pytest
import serial
from typer.testing import CliRunner

from host_tools import boards
from host_tools.cli.main import app
from host_tools.cli.status import grbl_rows
from host_tools.clients.frames import FramedPort
from host_tools.clients.grbl import fields_of
from host_tools.failure import Failure
from test_board_command import Board

REPORT = "<Run|WPos:1.000,-2.500,0.000|Bf:10,100|FS:600,9000|Pn:XP|WCO:10.000,0.000,-1.000|Ov:100,50,100|A:SF>"


@pytest.mark.quick
def test_rows_of_a_report():
    rows = grbl_rows(fields_of(REPORT), ["[ENC:x,3200,-1,4]"], ["[PIN:bxb,1,2,7,1500,-1]", "[LOGGED:2x201]"])
    assert dict(rows[:-2]) == {
        "state": "Run",
        "machine": "X 11.000  Y -2.500  Z -1.000",
        "work": "X 1.000  Y -2.500  Z 0.000",
        "moves": "600 mm/min, S 9000, spindle clockwise, flood",
        "overrides": "feed 100 %, rapids 50 %, spindle 100 %",
        "active": "limit X, probe",
        "encoder x": "3200 counts, -1 steps off, 4 at most",
    }
    assert rows[-2][1].startswith("input bxb: active, stopped the machine 2 times, 7 glitches; last became active at 1.500 s")
    assert rows[-1][1] == "since the start: 2 times 201"


@pytest.mark.quick
def test_the_other_way_round():
    rows = dict(grbl_rows(fields_of("<Idle|MPos:1.000,2.000|FS:0,0|WCO:1.000,1.000>"), [], []))
    assert rows["machine"] == "X 1.000  Y 2.000" and rows["work"] == "X 0.000  Y 1.000" and rows["active"] == "no input"


@pytest.mark.quick
def test_an_alarm_says_why():
    """By the board's own code, else by its log, else it is the lock; and which axes are not homed, with the reason."""
    log = ["[LOG:10,9,pc]", "[LOG:12,201,limit_x]", "[LOG:15,9,pc]", "[LOGGED:2x9]"]
    for report, entries, wanted in (
        ("<Alarm|MPos:0,0,0|Al:211|Nh:YZ>", log, "Alarm 211: locked, because not every axis is homed: home the others, or unlock the machine"),
        ("<Alarm|MPos:0,0,0>", log, "Alarm 201: a limit switch or the emergency stop was hit, the position may be lost: free it, reset, and home"),
        ("<Alarm|MPos:0,0,0>", [], "Alarm 200: locked, because the position is not known: home the machine, or unlock it"),
        ("<Idle|MPos:0,0,0|Nh:XYZ>", log, "Idle"),
    ):
        rows = dict(grbl_rows(fields_of(report), [], entries))
        assert rows["state"] == wanted
    assert rows["not homed"] == "X Y Z; soft limits ($20) do not hold"


def asked(port, *more):
    result = CliRunner().invoke(app, ["status", "--port", port, *more])
    assert result.exit_code == 0, result.output
    return {line.split("  ")[0]: line for line in result.output.splitlines()} | {"all": result.output.splitlines()}


@pytest.mark.unmeasured
@pytest.mark.parametrize(
    "board, options, wanted",
    [
        ("mill_2004", (), {"state": "Alarm", "encoder x2": "0 counts"}),
        ("router_3axis", (), {"state": "Alarm 200: locked", "not homed": "X Y Z"}),
        ("plotter_2014", (), {"state": "idle", "drawn": "0"}),
        ("torch_manipulator", (), {"state": "idle", "error": "0"}),
        ("lpt_router", (), {"state": "idle", "going": "+"}),
        ("plotter_2014", ("--protocol", "plotter"), {"state": "idle", "drawn": "0"}),
        ("lpt_router", ("--protocol", "pulses"), {"state": "idle", "going": "+"}),
    ],
)
def test_of_each_language(board, options, wanted):
    with Board("--board", board, "--time", "fast") as running:
        rows = asked(running.port, *options)
        for name, text in wanted.items():
            assert text in rows[name]
        assert rows == asked(running.port, *options), "asking changes nothing"


@pytest.mark.slow
@pytest.mark.unmeasured
def test_behind_lines_that_a_program_has_left():
    """Status shows state and places at once; facts that need a line of their own wait behind the program's lines."""
    with Board("--board", "mill_2004") as running:
        with running.open() as client:
            client.write(b"$X\nG21G91\n" + b"G1X1F10\nG1X-1\n" * 100)
            client.read_until(b"ok")
        rows = asked(running.port)
        assert "Run" in rows["state"] and "mm/min" in rows["moves"] and "after the lines sent before" in rows[""]


@pytest.mark.unmeasured
@pytest.mark.parametrize("reports", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_link_that_a_killed_program_has_left_in_frames(reports, tmp_path):
    path = tmp_path / "framed.py"
    board = boards.load("router_3axis")
    board["links"][0]["frames"] = True
    path.write_text(f"BOARD = {board!r}\n")
    with Board("--board", path, links=2) as running:
        with running.open() as client:
            framed = FramedPort(client)
            assert framed.begin(10)
            if reports:
                framed.report(20, b"?")
            else:
                framed.urgent(b"?")
            while b">" not in framed.read(100):
                pass
        assert "Alarm" in asked(running.port)["state"]


@pytest.mark.quick
def test_a_language_without_a_word_for_it():
    result = CliRunner().invoke(app, ["status", "--port", "/dev/nothing", "--protocol", "keys"])
    assert isinstance(result.exception, Failure) and "no word for the status" in str(result.exception)


@pytest.mark.unmeasured
@pytest.mark.parametrize("verb", ["status", "log"])
def test_a_board_of_keys_is_sent_one_byte_and_named(verb, monkeypatch):
    sent = []
    write = serial.Serial.write
    monkeypatch.setattr(serial.Serial, "write", lambda port, data: (sent.append(bytes(data)), write(port, data))[1])
    with Board("--board", "two_motor_kit", "--time", "fast") as running:
        result = CliRunner().invoke(app, [verb, "--port", running.port])
    assert isinstance(result.exception, Failure) and str(result.exception).startswith("--protocol keys: it has no word")
    assert b"".join(sent) == b"?", "each byte more might be a key"

"""Senders that people use, against the firmware on a pseudo-terminal; each skips where it is not installed."""

import importlib.util
import subprocess
import time
from pathlib import Path

import pytest

from running_router import Running

from host_tools import interpreter


@pytest.fixture
def board():
    running = Running()
    yield running
    running.close()


def zigzag(count, step):
    return [f"G1 X{step * (i + 1):.3f} Y{(i % 2) * 0.5:.3f} F4000" for i in range(count)]


@pytest.mark.parametrize("one_by_one", [pytest.param(True, marks=pytest.mark.slow), False], ids=["ok", "characters"])
def test_grbl_streamer(board, one_by_one):
    module = pytest.importorskip("grbl_streamer")
    said = []
    client = module.GrblStreamer(lambda kind, *data: said.append((kind, *data)))
    kinds = lambda: [event[0] for event in said]
    state = lambda: board.app.controller.state
    client.setup_logging()
    client.cnect(board.line.name, 115200)
    try:
        board.until(lambda: client.connected)
        client.poll_start()
        client.incremental_streaming = one_by_one
        board.until(lambda: ("on_read", "$132=80.000") in said)
        client.killalarm()
        client.homing()
        board.until(lambda: board.app.controller.machine.homed and state() == "idle")
        zero = list(board.world.place)

        said.clear()
        client.write("\n".join(zigzag(60, 0.2)))
        client.job_run()
        board.until(lambda: "on_job_completed" in kinds() and state() == "idle")
        assert board.position() == [3840, 160, 0]
        assert [at - by for at, by in zip(board.world.place, zero)] == [3840, 160, 0]

        client.job_new()
        client.write("G1 X0 Y0 F600")
        client.job_run()
        board.until(lambda: state() == "run" and board.position()[0] < 3700)
        client.hold()
        board.until(board.standing)
        stood = board.position()
        time.sleep(0.2)
        assert board.position() == stood
        client._iface.serialport.write(b"\x91")
        client.resume()
        board.until(lambda: state() == "run")
        assert board.app.controller.machine.overrides[0] == 110
        client._iface.serialport.write(b"\x91" * 9)
        board.until(lambda: state() == "idle")
        assert board.position() == [0, 0, 0]

        client._iface_write("$J=X50F1000\n")
        board.until(lambda: state() == "jog" and board.position()[0] > 100)
        client._iface.serialport.write(b"\x85")
        board.until(lambda: state() == "idle")
        assert 100 < board.position()[0] < 16000

        client._iface_write("G0 X-5\n")
        board.until(lambda: any(event == ("on_alarm", "ALARM:2") for event in said))
        client.softreset()
        board.until(lambda: board.app.controller.machine.alarm == 200)
        client.killalarm()
        board.until(lambda: state() == "idle")
        assert [at - by for at, by in zip(board.world.place, zero)] == board.position()
        assert "on_error" in kinds()  # the answer to the line that raised the alarm
    finally:
        client.disconnect()


class Bcnc:
    """bcnc_sender.py in a process of its own."""

    def __init__(self, home):
        command = [*interpreter.python(), Path(__file__).with_name("bcnc_sender.py")]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env=interpreter.environment(HOME=str(home)),
        )  # fmt: skip

    def do(self, line):
        """Carry out a line of Python there; its value as text."""
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        assert answer.startswith("= ") and "Error" not in answer, (line, answer)
        return answer[2:].strip()

    def close(self):
        self._process.stdin.close()
        self._process.wait(20)


@pytest.mark.slow
def test_bcnc(board, tmp_path):
    pytest.importorskip("tkinter", reason="bCNC wants tkinter")
    if importlib.util.find_spec("bCNC") is None:
        pytest.skip("bCNC is not installed")
    bcnc = Bcnc(tmp_path)
    controller = board.app.controller
    idle = lambda: controller.state == "idle"
    job = tmp_path / "job.gcode"
    try:
        bcnc.do(f"sender.open({board.line.name!r}, 115200)")
        bcnc.do("sender.viewSettings()")
        board.until(lambda: bcnc.do("CNC.vars.get('grbl_132')") == "'80.000'")
        bcnc.do("sender.unlock()")
        board.until(idle)
        bcnc.do("sender.home()")
        board.until(lambda: controller.machine.homed and idle())
        zero = list(board.world.place)
        board.until(lambda: bcnc.do("CNC.vars['state'], CNC.vars['mx']") == "('Idle', 0.0)")

        job.write_text("\n".join(["G21 G90", *zigzag(60, 0.2), "G2 X12 Y0.5 J2 F900", "M30"]) + "\n")
        bcnc.do(f"run({str(job)!r})")
        board.until(lambda: controller.state == "run")
        board.until(lambda: bcnc.do("ended()") == "True" and idle())
        assert board.position() == [3840, 160, 0]
        assert [at - by for at, by in zip(board.world.place, zero)] == [3840, 160, 0]

        board.until(lambda: bcnc.do("sender.queue.qsize()") == "0" and idle())
        bcnc.do("sender.sendGCode('G1X0Y0F500')")
        board.until(lambda: controller.state == "run" and board.position()[0] < 3700)
        bcnc.do("sender.feedHold()")
        board.until(board.standing)
        stood = board.position()
        bcnc.do("CNC.vars.update(_OvFeed=200, _OvChanged=True)")
        board.until(lambda: controller.machine.overrides[0] == 200)
        assert board.position() == stood
        bcnc.do("sender.resume()")
        board.until(idle)
        assert board.position() == [0, 0, 0]

        bcnc.do("sender.mcontrol.jog('X50')")
        board.until(lambda: controller.state == "jog" and board.position()[0] > 100)
        bcnc.do("sender.serial_write(bytes([0x85]))")
        board.until(idle)
        assert 100 < board.position()[0] < 16000

        bcnc.do("sender.sendGCode('G90G0X-5')")
        board.until(lambda: controller.machine.alarm == 202)
        board.until(lambda: "ALARM:2" in bcnc.do("CNC.vars['state']"))
        bcnc.do("sender.softReset()")
        board.until(lambda: controller.machine.alarm == 200)

        def unlocked():
            bcnc.do("sender.unlock()")  # the sender may still be clearing its own queue after the reset: press again
            time.sleep(0.1)
            return idle()

        board.until(unlocked)
        assert [at - by for at, by in zip(board.world.place, zero)] == board.position()
    finally:
        bcnc.close()


@pytest.mark.slow
def test_bcnc_with_four_axes(tmp_path):
    """A job that turns a table: bCNC reads A's setting and position, and the trace ends at A to the step."""
    pytest.importorskip("tkinter", reason="bCNC wants tkinter")
    if importlib.util.find_spec("bCNC") is None:
        pytest.skip("bCNC is not installed")
    trace, job = tmp_path / "trace.csv", tmp_path / "job.gcode"
    command = [*interpreter.passo(), "board", "--board", "router_4axis", "--trace", trace, "--link", tmp_path / "port"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        bcnc = Bcnc(tmp_path)

        def until(line, wanted):
            end = time.monotonic() + 120
            while bcnc.do(line) != wanted:
                assert time.monotonic() < end, (line, bcnc.do(line), wanted)
                time.sleep(0.1)

        try:
            assert process.stdout.readline().startswith("port: ")
            bcnc.do(f"sender.open({str(tmp_path / 'port')!r}, 115200)")
            bcnc.do("sender.viewSettings()")
            until("CNC.vars.get('grbl_103')", "'53.333'")
            bcnc.do("sender.unlock()")
            until("CNC.vars['state']", "'Idle'")
            bcnc.do("sender.home()")
            until("CNC.vars['state']", "'Home'")
            until("CNC.vars['state']", "'Idle'")
            job.write_text("G21 G90\nG1 X10 A90 F3000\nG1 A-45\nG93 G1 X5 A30 F60\nG94\nG0 X0 A12.5\nM30\n")
            bcnc.do(f"run({str(job)!r})")
            until("ended()", "True")
            until("CNC.vars['state'], CNC.vars['mx'], CNC.vars['ma']", "('Idle', 0.0, 12.506)")
        finally:
            bcnc.close()
            process.terminate()
    last = trace.read_text().splitlines()[-1].split(",")
    assert last[1] == "0" and last[4] == str(round(12.5 * 53.333)), last

"""Senders that people use, against the firmware on a pseudo-terminal; each skips where it is not installed.

CNCjs: PASSO_CNCJS names the folder in which `npm install cncjs` was done. stream.py: PASSO_GRBL names grbl's sources, which have it in doc/script.
"""

import importlib.util
import json
import os
import shutil
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from running_router import Running

from host_tools import interpreter


# Files with letters beyond ASCII: a minus that is none, a no-break space, a comment of other letters. Which lines a sender sends as they are is its own.
ODD = "G21 (\u0417 \u2212)\nG1 X6 F4000\nG1 X\u22125\nG1\u00a0X1\nG1 Y3\n"
MINUS_ACTED = "[MSG:Letters beyond ASCII acted: feed 90 %]"
SPACE_ACTED = "[MSG:Letters beyond ASCII acted: flood on]"


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


def test_odd_letters_by_bcnc(board, tmp_path):
    """It leaves them out itself, without a word: X0 of X−5. They do not reach the board, which cannot report them; docs/reference/gcode.md says it."""
    pytest.importorskip("tkinter", reason="bCNC wants tkinter")
    if importlib.util.find_spec("bCNC") is None:
        pytest.skip("bCNC is not installed")
    bcnc = Bcnc(tmp_path)
    controller = board.app.controller
    job = tmp_path / "job.gcode"
    job.write_text(ODD, encoding="utf-8")
    try:
        bcnc.do(f"sender.open({board.line.name!r}, 115200)")
        board.until(lambda: bcnc.do("CNC.vars['state']") != "'Not connected'")
        bcnc.do("sender.unlock()")
        board.until(lambda: controller.state == "idle" and bcnc.do("CNC.vars['state']") == "'Idle'")
        bcnc.do(f"run({str(job)!r})")
        board.until(lambda: bcnc.do("ended()") == "True" and controller.state == "idle" and board.position() == [320, 3 * 320, 0])
        sent = [line for line in eval(bcnc.do("shown()")) if line[:1] == "G" and line[-1:] == "\n"]
        assert sent[-4:] == ["G1X6F4000\n", "G1X0\n", "G1X1\n", "G1Y3\n"], sent
    finally:
        bcnc.close()


# --- grbl's own script

@pytest.fixture
def stream_py(board, tmp_path):
    script = Path(os.environ.get("PASSO_GRBL", "grbl")) / "doc" / "script" / "stream.py"
    if not script.is_file():
        pytest.skip("PASSO_GRBL names no folder with grbl's doc/script/stream.py: its script was NOT run")
    if importlib.util.find_spec("lib2to3") is None:
        pytest.skip("this Python has no lib2to3, which makes Python 3 of grbl's stream.py: it was NOT run")

    def run(text, end):
        """Return the program's output for a job that ends at a position. It waits for Enter: a program that leaves before the machine stands is a lost host."""
        job = tmp_path / "job.nc"
        job.write_text(text, encoding="utf-8")
        command = [*interpreter.python(), Path(__file__).with_name("grbl_stream.py"), script, job, board.line.name]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8", errors="surrogateescape",
                              env=interpreter.environment(PYTHONIOENCODING="utf-8:surrogateescape")) as process:  # fmt: skip
            board.until(lambda: board.app.controller.state == "idle" and board.position() == end)
            return process.communicate("\n", timeout=240)[0]

    return run


def test_stream_py(board, stream_py):
    said = stream_py("\n".join(["$X", "G21 G90", *zigzag(60, 0.2), "M30"]) + "\n", [3840, 160, 0])
    assert said.count(': "ok"') == 63 and "error" not in said and "G-code streaming finished!" in said, said


def test_odd_letters_by_stream_py(stream_py):
    """It leaves out comments, sends the rest as it is, shows what the board says, counts errors, and goes on."""
    stream_py("$X\n", [0, 0, 0])
    said = stream_py(ODD, [6 * 320, 3 * 320, 0])
    for text in (f'MSG: "{MINUS_ACTED}"\n  REC<3: "error:1"', f'MSG: "{SPACE_ACTED}"\n  REC<4: "error:1"', 'REC<5: "ok"'):
        assert text in said, said


# --- CNCjs

class Cncjs:
    """Its server, and cncjs_sender.js as its page."""

    def __init__(self, folder, home):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = str(free.getsockname()[1])
        environment = interpreter.environment(HOME=str(home))
        server = ["node", folder / "node_modules/cncjs/bin/cncjs", "-p", port, "-H", "127.0.0.1", "-c", home / "cncrc", "--controller", "Grbl"]
        self._server = subprocess.Popen(server, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
        deadline = time.monotonic() + 240
        while True:
            try:
                socket.create_connection(("127.0.0.1", int(port))).close()
                break
            except OSError:
                assert self._server.poll() is None and time.monotonic() < deadline, "CNCjs does not start"
                time.sleep(0.1)
        page = ["node", Path(__file__).with_name("cncjs_sender.js"), folder, port]
        self._page = subprocess.Popen(page, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8", env=environment)
        self.events = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._page.stdout:
            self.events.append(json.loads(line))

    def emit(self, *event):
        self._page.stdin.write(json.dumps(event) + "\n")
        self._page.stdin.flush()

    def last(self, name):
        return next((event[1:] for event in reversed(self.events) if event[0] == name), [])

    def shown(self):
        """Lines of its console that the board or the sender has written."""
        return [event[1] for event in self.events if event[0] == "serialport:read"]

    def close(self):
        self._page.stdin.close()
        self._page.wait(60)
        self._reader.join()
        self._server.terminate()
        self._server.wait(60)


@pytest.fixture
def cncjs(board, tmp_path):
    folder = Path(os.environ.get("PASSO_CNCJS", "cncjs"))
    if not shutil.which("node") or not (folder / "node_modules/cncjs").is_dir():
        pytest.skip("PASSO_CNCJS names no folder with CNCjs in it (npm install cncjs), or there is no node: CNCjs was NOT run")
    cncjs = Cncjs(folder.absolute(), tmp_path)
    try:
        board.until(lambda: ["connect"] in cncjs.events)
        cncjs.emit("open", board.line.name, {"baudrate": 115200, "controllerType": "Grbl"})
        board.until(lambda: any(text.startswith("$132=") for text in cncjs.shown()))
        cncjs.emit("command", board.line.name, "unlock")
        board.until(lambda: board.app.controller.state == "idle")
        yield cncjs
    finally:
        cncjs.close()


def start(board, cncjs, text):
    cncjs.emit("command", board.line.name, "gcode:load", "job.nc", text, {})
    board.until(lambda: cncjs.last("gcode:load")[:1] == ["job.nc"])
    cncjs.events.clear()
    cncjs.emit("command", board.line.name, "gcode:start")


def test_cncjs(board, cncjs):
    """Homing, a job with a hold, an override and a resume, a jog that is cancelled, an alarm, reset and unlock."""
    port = board.line.name
    controller = board.app.controller
    cncjs.emit("command", port, "homing")
    board.until(lambda: controller.machine.homed and controller.state == "idle")
    start(board, cncjs, "\n".join(["G21 G90", *zigzag(60, 0.2), "G1 X0 Y0 F300", "M30"]) + "\n")
    board.until(lambda: board.position()[0] > 3700)
    board.until(lambda: controller.state == "run" and board.position()[0] < 3600)
    cncjs.emit("command", port, "gcode:pause")
    board.until(board.standing)
    cncjs.emit("command", port, "feedOverride", 10)
    board.until(lambda: controller.machine.overrides[0] == 110)
    cncjs.emit("command", port, "gcode:resume")
    board.until(lambda: controller.state == "idle" and board.position() == [0, 0, 0] and cncjs.last("workflow:state") == ["idle"])
    assert not [text for text in cncjs.shown() if text.startswith(("error", "ALARM"))]
    cncjs.emit("command", port, "gcode", "$J=G91X50F1000")
    board.until(lambda: controller.state == "jog" and board.position()[0] > 100)
    cncjs.emit("command", port, "jogCancel")
    board.until(lambda: controller.state == "idle")
    assert 100 < board.position()[0] < 16000
    cncjs.emit("command", port, "gcode", "G90G0X-5")
    board.until(lambda: controller.machine.alarm == 202 and any(text.startswith("ALARM:2") for text in cncjs.shown()))
    cncjs.emit("command", port, "reset")
    board.until(lambda: controller.machine.alarm == 200)
    cncjs.emit("command", port, "unlock")
    board.until(lambda: controller.state == "idle")


def test_odd_letters_by_cncjs(board, cncjs):
    """It leaves out comments, sends the rest as it is, shows what the board says, and pauses the job at the line that the board refuses."""
    start(board, cncjs, ODD)
    board.until(lambda: cncjs.last("workflow:state") == ["paused"] and board.app.controller.state == "idle" and board.position()[1] == 3 * 320)
    shown = cncjs.shown()
    assert MINUS_ACTED in shown and SPACE_ACTED in shown and shown.count("error:1 (Expected command letter)") == 2, shown
    assert board.position() == [6 * 320, 3 * 320, 0]

"""The firmware's own main.py on the fake ESP32, as it starts from flash: good and bad board files, Ctrl-C, a crash."""

import subprocess

import pytest
from test_board_command import ROOT

from host_tools import interpreter

PROGRAM = """
import sys
sys.path[:0] = {paths!r}
import fake_esp32
from fake_esp32 import chip
import gc, runpy, traceback, types
gc.threshold = lambda bytes: None
sys.print_exception = lambda error, file: traceback.print_exception(error, file=file)
chip.level[0] = 1
sys.modules.update(fake_esp32.fakes)
sys.platform = "esp32"
from boards.plotter_esp32 import BOARD
BOARD["outputs"] = [{{"name": "enable", "pin": 13, "active": 0}}]
{change}
if BOARD is not None:
    sys.modules["board"] = types.SimpleNamespace(BOARD=BOARD)
sleep_ms = chip.sleep_ms
def sleep(ms):
    if chip.now > 3_000_000:
        {end}
    sleep_ms(ms)
chip.sleep_ms = sleep
runpy.run_path({main!r})
print("pins", chip.level.get(13), chip.level.get(26), "watchdog", chip.watchdog is not None)
"""


def run(tmp_path, change="", end="raise KeyboardInterrupt"):
    paths = [str(ROOT / folder) for folder in ("tests_host/sims", "host_tools/shims", "firmware", ".")]
    source = PROGRAM.format(paths=paths, change=change, end=end, main=str(ROOT / "firmware" / "main.py"))
    command = [*interpreter.python(), "-c", source]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=interpreter.environment(), cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_ctrl_c_after_the_grace_period(tmp_path):
    assert run(tmp_path) == "stopped\npins 1 0 watchdog True\n"


@pytest.mark.parametrize(
    "change, text",
    [
        ("BOARD['axes'][0]['pins'][3] = 34", "board.py is wrong: axis x: pin 34 of an esp32 can only be an input"),
        ("BOARD['colour'] = 'red'", "board.py is wrong: the board file: unknown key 'colour'"),
        ("BOARD['links'][0]['protocol'] = 'esperanto'", "board.py is wrong: link pc: unknown protocol 'esperanto'"),
        ("chip.level[0] = 0", "input repl is active: no app, the REPL"),
    ],
)
def test_what_keeps_it_from_running(tmp_path, change, text):
    said = run(tmp_path, change).splitlines()
    assert said[0].startswith(text) and len(said) == 2
    assert said[1] == "pins 1 0 watchdog False"


def test_no_board_file(tmp_path):
    said = run(tmp_path, "BOARD = None")
    assert said.startswith("board.py cannot be read: ModuleNotFoundError")


def test_a_crash_leaves_safe_outputs_and_a_report(tmp_path):
    said = run(tmp_path, end="raise ZeroDivisionError('in the main loop')")
    assert "ZeroDivisionError: in the main loop" in said and said.endswith("pins 1 0 watchdog True\n")
    assert "in the main loop" in (tmp_path / "crash.txt").read_text()
    assert "the last run ended by:" in run(tmp_path)

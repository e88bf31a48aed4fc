"""The core moves a machine without options: a board file of needed keys, with homing, probe and spindle, and a firmware whose folders of
passo/options are deleted."""

import json
import shutil
import subprocess

import pytest

from host_tools import interpreter
from host_tools.build import tree
from host_tools.resources import EXAMPLES, FIRMWARE, ROOT
from passo.config.boardfile import check

BOARD = {
    "name": "plain",
    "chip": "rp2040",
    "drive": {"kind": "step_dir"},
    "axes": [
        {"name": "x", "pins": [2, 5], "steps_per_m": 80000, "travel_steps": 8000},
        {"name": "y", "pins": [3, 6], "steps_per_m": 80000, "travel_steps": 8000},
        {"name": "z", "pins": [4, 7], "steps_per_m": 80000, "travel_steps": 2400},
    ],
    "tool": {"pin": 8},
    "inputs": [
        {"name": "limit_x", "pin": 9, "active": 1, "pull": "up"},
        {"name": "limit_y", "pin": 10, "active": 1, "pull": "up"},
        {"name": "limit_z", "pin": 11, "active": 1, "pull": "up"},
        {"name": "probe", "pin": 12, "active": 0, "pull": "up"},
    ],
    "homing": {
        "sensors": {"x": "limit_x", "y": "limit_y", "z": "limit_z"},
        "high_end": "z",
        "seek_steps_s": 4000,
        "locate_steps_s": 400,
        "pull_off_steps": 160,
    },
    "speed": {"unit": "steps_per_s", "default": 2000, "min": 10, "max": 16000},
    "spindle": {"max_rpm": 24000},
    "links": [{"name": "pc", "port": "usb", "protocol": "grbl"}],
}

# Homes, cuts the slot with a hold on the way, probes into the air, and jogs; prints the board's answers, and the modules of the firmware.
_WORK = """
import json, sys
board, slot, sims = json.loads(sys.argv[1]), open(sys.argv[2]).read().splitlines(), sys.argv[3]
sys.path.append(sims)
from asked import Asked
from host_tools.sim.machine import VirtualMachine
asked = Asked(board, start=(400, 400, -400))
machine, plant = asked.machine, asked.plant
said = {}
asked.do("$H")
asked.do("G53G0Z-10", "G10L20P1Z5")
lines = [line for line in slot if line[:1] not in ("", "(")]
held = False
for number, line in enumerate(lines):
    asked.do(line)
    if not held and line.startswith("G3"):
        machine.run_ms(300)
        machine.send(b"!")
        machine.run_ms(1000)
        before = asked.machine.app.controller.position()
        machine.take()
        machine.send(b"?")
        machine.run_ms(100)
        said["held"] = machine.take().decode()
        machine.run_ms(500)
        said["stood"] = before == asked.machine.app.controller.position()
        machine.send(b"~")
        machine.run_ms(100)
        held = True
machine.settle()
machine.take()
machine.send(b"?")
machine.run_ms(100)
said["done"] = machine.take().decode()
asked.do("G90G38.3Z3F200")  # into the air
machine.settle()
said["probed"] = asked.machine.app.controller.position()[2]
asked.do("$J=G91X5F600")
machine.settle()
said["jogged"] = asked.machine.app.controller.position()
said["spun"] = plant.errors == []
said["modules"] = sorted(name for name in sys.modules if name.startswith("passo."))
print(json.dumps(said))
"""


def work(firmware, folder):
    script = folder / "work.py"
    script.write_text(_WORK, encoding="utf-8")
    command = [*interpreter.python(firmware, ROOT, ROOT / "host_tools" / "shims"), str(script), json.dumps(BOARD), str(EXAMPLES / "slot.gcode"), str(ROOT / "tests_host" / "sims")]
    done = subprocess.run(command, env=interpreter.environment(), cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def of_options(names):
    return [name for name in names if name.startswith("passo.options.")]


def judge(said):
    assert "Hold:0" in said["held"] and said["stood"], said
    assert "Idle|MPos:20.000,20.000,-10.000" in said["done"], said
    assert said["probed"] == -12 * 80 and said["jogged"][0] == 25 * 80, said
    assert said["spun"]


@pytest.mark.quick
def test_a_plain_board_loads_no_option(tmp_path):
    said = work(FIRMWARE, tmp_path)
    judge(said)
    assert of_options(said["modules"]) == []
    files = tree.select_modules(BOARD)
    assert [path for path in files if tree.option_of(path)] == [] and len(files) > 60


def test_it_works_without_their_folders(tmp_path):
    firmware = tmp_path / "firmware"
    shutil.copytree(FIRMWARE, firmware, ignore=shutil.ignore_patterns("__pycache__"))
    for folder in (firmware / tree.OPTIONS).iterdir():
        if folder.is_dir():
            shutil.rmtree(folder)
    judge(work(firmware, tmp_path))
    assert tree.select_modules(BOARD, firmware) == tree.select_modules(BOARD)
    assert "additions" not in check(BOARD)

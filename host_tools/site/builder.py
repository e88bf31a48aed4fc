"""The static site: the page, MicroPython as WebAssembly, the firmware and its virtual machine as texts. Any plain file server serves it.

    build(Path("build/site"), load_package())

MicroPython comes from npm, a version of one checksum, and stays in ~/.cache/passo. The firmware is what MicroPython on a PC runs
(tree.py: constants of other modules as numbers), without the marks of machine code: WebAssembly has none, and its plain text makes
the same words.
"""

import json
import math
import os
import re
import shutil
from functools import lru_cache
from pathlib import Path

from host_tools import boards
from host_tools.build.constants import fold_in_place
from host_tools.build.tree import module_files
from host_tools.drawings.objects import objects
from host_tools.drawings.packets import packet_words
from host_tools.failure import Failure
from host_tools.resources import FIRMWARE, HOST_TOOLS
from host_tools.site import offline
from host_tools.site.npm import Package

MICROPYTHON = Package(
    "MicroPython for the browser", "@micropython/micropython-webassembly-pyscript", "1.27.0",
    "DnXx4EqxgkeaFESrS3uKrL7mLMk4mRTd0mMzaOd3HUSiZUOAE7t11uLnjf3ftF87N2xm4knHnWEKcVK4IYIUDA==",
)  # fmt: skip
PAGE = FIRMWARE / "passo" / "web" / "page"
OWN = Path(__file__).resolve().parent
TAB = ("host_tools/sim/tab.py", "host_tools/sim/tab_jobs.py", "host_tools/sim/plant.py", "host_tools/sim/input_faults.py", "host_tools/sim/belt.py", "host_tools/sim/slipping.py", "host_tools/sim/parts.py", "host_tools/sim/decoders.py", "host_tools/sim/stock.py",
       *(f"host_tools/page/{name}.py" for name in (
           "cable_page", "cable_settings", "grbl_machine", "guest_sender", "job", "jobs", "orders",
           "plotter_job", "plotter_machine", "presence", "queue", "set_up", "slow_order", "teach")),
       "host_tools/programs/program_lines.py", "host_tools/programs/height_map.py", "host_tools/programs/surfacing.py",
       "host_tools/clients/answers.py", "host_tools/clients/grbl_wire.py", "host_tools/clients/plotter_wire.py")  # fmt: skip
SHIMS = ("random.py",)
BOARDS = ("router_3axis", "plotter_2014")  # the first one is shown
_LEFT_OUT = ("passo/ports/rp2/", "passo/ports/esp32/")
_MACHINE_CODE = re.compile(r"(?m)^[ ]*@micropython\.(viper|native)$|\bptr(8|32)(?=\()")
_MOST_AXES = 4


def load_package(cache=None):
    """Return {name: bytes} of MicroPython's two files, from the folder `cache` or from npm. Raises Failure."""
    return MICROPYTHON.read_files("micropython.mjs", "micropython.wasm", cache=cache)


@lru_cache(maxsize=1)
def tab_texts():
    """Return {path: text} of all that Python imports in the tab. Do not change it: it is kept."""
    found = {path.as_posix(): FIRMWARE / path for path in module_files() if not path.as_posix().startswith(_LEFT_OUT)}
    found |= {name: HOST_TOOLS.parent / name for name in TAB}
    read = fold_in_place({name: path.read_text(encoding="utf-8") for name, path in found.items()})
    read |= {name: (OWN / name).read_text(encoding="utf-8") for name in SHIMS}
    read |= {f"boards/{name}.py": boards.board_py(name).decode() for name in BOARDS}
    return {name: _MACHINE_CODE.sub("", text) for name, text in read.items()}


def relief_gcode():
    """Return G-code of a surface of waves in scan lines of short moves in three axes, 60 × 40 mm, in machine coordinates of the router."""
    lines = ["(Waves: 60 x 40 mm, a surface in scan lines)", "G21 G90 G94 F2400", "G0 Z-10", "G0 X60 Y50", "M3 S12000"]
    for row in range(41):
        columns = range(61) if row % 2 == 0 else range(60, -1, -1)
        for column in columns:
            x, y = column / 60 * 2 * math.pi, row / 40 * 2 * math.pi
            z = -16 + 3 * math.sin(1.5 * x) * math.cos(y)
            lines.append(f"G1 X{60 + column:.3f} Y{50 + row:.3f} Z{z:.3f}")
    return "\n".join([*lines, "G0 Z-10", "M5", "G0 X0 Y0", "M2"]) + "\n"


def rosette_gcode():
    """Return G-code of arcs and lines, flat, in machine coordinates of the router."""
    lines = ["(A rosette of arcs)", "G21 G90 G94 F2400", "G0 Z-10", "M3 S12000"]
    for petal in range(12):
        angle = petal * math.pi / 6
        x, y = 150 + 40 * math.cos(angle), 100 + 40 * math.sin(angle)
        i, j = 150 - x, 100 - y
        lines += ["G0 Z-12", f"G0 X{x:.3f} Y{y:.3f}", "G1 Z-15 F600", f"G2 X{x:.3f} Y{y:.3f} I{i / 2:.3f} J{j / 2:.3f} F2400"]
    return "\n".join([*lines, "G0 Z-10", "M5", "G0 X0 Y0", "M2"]) + "\n"


def demo_jobs():
    """Return {board: {name: text}} of the jobs that the tab's machines begin with."""
    return {
        "router_3axis": {"relief.gcode": relief_gcode(), "rosette.gcode": rosette_gcode()},
        "plotter_2014": {f"{name}.txt": packet_words(points) for name, points in objects().items()},
    }


_PATH = '<div class="pane" id="pane-path">\n'  # the part of the page that the machine of the tab is put into


def page_html(text):
    """Return index.html with the machine in it, and without a way out of its own site. Raises Failure if the page lacks a mark."""
    card = (OWN / "machine.html").read_text(encoding="utf-8")
    head = (OWN / "head.html").read_text(encoding="utf-8")
    for mark, made in (("</title>\n", "</title>\n" + head), (_PATH, _PATH + card)):
        if text.count(mark) != 1:
            raise Failure("{} has no {} to put the machine behind", PAGE / "index.html", mark.strip())
        text = text.replace(mark, made)
    return offline.add_to_page(text)


def build(out, files):
    """Write the site to the folder `out`, which is emptied first. `files`: load_package(). Return the bytes written. Raises Failure if the folder
    holds anything but a site."""
    from host_tools.clients import setting_names
    from host_tools.build.pages import error_list, page_words

    if out.exists() and not (out / "firmware.json").is_file() and any(out.iterdir()):
        raise Failure("{} is not empty, and holds no site of Passo: name another folder", out)
    firmware, machines = tab_texts(), {"boards": demo_jobs(), "rules": setting_names.all_rules(_MOST_AXES)}
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    _write_json(out, "firmware.json", firmware)  # first: by it a folder that was broken off is known
    for name, data in files.items():
        (out / name).write_bytes(data)
    for path in PAGE.iterdir():
        if not path.name.startswith("torch"):  # a page for the board's own network
            shutil.copyfile(path, out / path.name)
    for path in OWN.iterdir():
        if path.suffix in (".js", ".css"):
            shutil.copyfile(path, out / path.name)
    (out / "index.html").write_text(page_html((PAGE / "index.html").read_text(encoding="utf-8")), encoding="utf-8")
    _write_json(out, "pt.json", page_words() | json.loads((OWN / "pt.json").read_text(encoding="utf-8")))
    _write_json(out, "site.json", machines)
    _write_json(out, "errors.json", error_list())
    served = {path.name: path.read_bytes() for path in out.iterdir() if path.name not in offline.NAMES}
    for name, data in offline.make_files(served, "cache").items():
        (out / name).write_bytes(data)
    return sum(path.stat().st_size for path in out.iterdir())


def _write_json(out, name, data):
    """Write a file of JSON."""
    (out / name).write_text(json.dumps(data, ensure_ascii=False), encoding="utf-8")

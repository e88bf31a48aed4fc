"""Files in the form in which LightBurn and UGS write them, of our own geometry: words run together, a line that only takes the power away, inches
without a leading zero, comments of both kinds, arcs in each plane by R and by IJK. Each line is taken, and ends where it should.

Both half circles of UGS's form go down, to -3.175 mm: they are seen against the axis across their plane (RS274/NGC, 3.5.3). The forms are
those of files that people keep: LightBurn's `GRBL device profile, absolute coords`, 1.2 to 1.7, and `user origin`, 1.0, and UGS's test_files/.
"""

import pytest

from host_tools.panel.job_facts import tools_of
from host_tools.panel.store import gcode_lines
from host_tools.programs import gcode_file
from host_tools.sim.job import VirtualJob

LIGHTBURN = """; LightBurn 1.7.04
; GRBL device profile, absolute coords
; Bounds: X10 Y5 to X40 Y25
G00 G17 G40 G21 G54
G90
M4
; Cut @ 1200 mm/min, 60% power
M8
G0 X10Y5
; Layer C00 Pass 1 of 2
G1 X40S600F1200
G1 Y25
G1 X10
G1 Y5
; Layer C00 Pass 2 of 2
G1 X40
G1 Y25
G1 X10
G1 Y5
; Fill @ 3000 mm/min, 12.5% power
G0X12Y7
G91
G1 X3S0F3000
G1 X20S125
G1 X3S0
G0Y.254
G1 X-3S0
G1 X-20S125
G1 X-3S0
G90
M9
G1 S0
M5
G90
; return to user-defined finish pos
G0 X0 Y0
M2
"""
USER_ORIGIN = """; LightBurn 1.0.04
; GRBL device profile, user origin
; Bounds: X118 Y326 to X130 Y338

;USER START SCRIPT
M7;
M8;
;USER START SCRIPT

G00 G17 G40 G21 G54
G90
G0 X0 Y0
G91
M4
; Cut @ 50 mm/sec, 1% power
G0X0Y0
; Layer C00
G1Y12S010F3000
G1X12S10
G1Y-12
G1X-12
M9
G1S0
M5
G90
; return to user-defined finish pos
G0 X0 Y0
M2
"""
CURRENT_POSITION = """; LightBurn 1.1.03
; GRBL-M3 (1.1e or earlier) device profile, current position
; Bounds: X-30 Y0 to X0 Y2
G00 G17 G40 G21 G54
G91
; Cut @ 50 mm/sec, 50% power
M8
M5
G0 X0Y2
; Layer C01
M3
G1 X-14.5Y-1S127.5F3000
M5
G0 X-1
M3
G1 X-14.5Y-1
M5
M9
G1 S0
; return to starting pos
G0 X30Y0
M2
"""
UGS = """G17G20G90G94
F50.00000 ;    Defines feed rate
S1000.00000 ; Defines speed
G0Z0.1250 ; lift
X-0.0Y0.
G04P.1 (wait)
G1Z0.0
G1X0.0Y.5
G2X.5Y.0R.5
G0Z0.125
G18
G2X1.Z.125I.25K0.
G19
G3Y.5Z.125J.25K0.
G17
(a comment) G1 (amid) X.5 ; behind
G21
G0 X0 Y0 Z5
"""


@pytest.mark.parametrize("name, board, text, low, high", (
    ("lightburn.gc", "laser_xy", LIGHTBURN, (0, 0), (40, 25)), ("origin.gc", "laser_xy", USER_ORIGIN, (0, 0), (12, 12)),
    ("position.gc", "laser_xy", CURRENT_POSITION, (-30, 0), (0, 2)), ("ugs.nc", "router_3axis", UGS, (0, 0, -3.175), (25.4, 12.7, 5)),
), ids=("LightBurn", "LightBurn, user origin", "LightBurn, current position", "UGS"))  # fmt: skip
def test_each_line_is_taken(tmp_path, name, board, text, low, high):
    path = tmp_path / name
    path.write_text(text, newline="\r\n")
    job = VirtualJob(board)
    job.run(gcode_file.file_lines(path))
    assert job.errors == [] and tools_of(gcode_lines(path)) == []
    assert [round(value, 2) for value in job.low[: len(low)]] == pytest.approx(list(low), abs=0.02)
    assert [round(value, 2) for value in job.high[: len(high)]] == pytest.approx(list(high), abs=0.02)


def test_a_word_that_is_wrong_is_found_in_them(tmp_path):
    path = tmp_path / "wrong.gc"
    path.write_text(LIGHTBURN.replace("G1 Y25\n", "G1 Y25Q\n", 1))
    job = VirtualJob("laser_xy")
    job.run(gcode_file.file_lines(path))
    assert [line for line, *_ in job.errors] == [12]


def test_a_start_script_for_an_axis_that_is_not_there_is_told(tmp_path):
    path = tmp_path / "script.gc"
    path.write_text(USER_ORIGIN.replace("M7;\n", "G90 G20\nG0 X0 Y0\nG1 X0 Z1 F100\n").replace("G40", "G43.2"))
    job = VirtualJob("laser_xy")
    job.run(gcode_file.file_lines(path))
    assert [(line, "this machine has no Z" in what) for line, _, what in job.errors] == [(8, True), (12, False)]

"""The programs of docs/use/makers.md that are installed here make a file each, which is drawn at its size or run without a refused line.

They are Debian's freecad-python3, kicad, inkscape, openscad, gnuplot, plotutils, pstoedit, potrace, r-base-core, dia, fig2dev, zint, barcode,
ploticus, abcm2ps and gle-graphics, vpype of PyPI and matplotlib. The test of a program that is not installed skips.
"""

import os
import shutil
import subprocess

import pytest

from host_tools import interpreter
from host_tools.programs import gcode_file
from host_tools.sim.job import VirtualJob
from test_written_by import drawn

PYTHON = "/usr/bin/python3"  # that Debian's KiCad is made for
EPS = "%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 300 200\nnewpath 20 20 moveto 161.7323 20 lineto 161.7323 90.8661 lineto stroke\nshowpage\n"
INK = '<svg xmlns="http://www.w3.org/2000/svg" width="80mm" height="60mm" viewBox="0 0 80 60"><rect x="12" y="7" width="50" height="30" fill="none" stroke="#000" stroke-width=".2"/></svg>'
PBM = "P1\n20 10\n" + "0 0 0 0 0 1 1 1 1 1 1 1 1 1 1 0 0 0 0 0\n" * 10
FIG = "#FIG 3.2\nLandscape\nCenter\nMetric\nA4\n100.00\nSingle\n-2\n1200 2\n2 2 0 1 0 7 50 -1 -1 0.000 0 0 -1 0 0 5\n\t 450 450 2700 450 2700 1350 450 1350 450 450\n"
DIA = (
    '<?xml version="1.0" encoding="UTF-8"?><dia:diagram xmlns:dia="http://www.lysator.liu.se/~alla/dia/"><dia:layer name="Background" visible="true" active="true">'
    '<dia:object type="Standard - Box" version="0" id="O0"><dia:attribute name="obj_pos"><dia:point val="1,1"/></dia:attribute><dia:attribute name="elem_corner"><dia:point val="1,1"/>'
    '</dia:attribute><dia:attribute name="elem_width"><dia:real val="5"/></dia:attribute><dia:attribute name="elem_height"><dia:real val="3"/></dia:attribute></dia:object></dia:layer></dia:diagram>'
)
KICAD = """
import pcbnew
board, mm = pcbnew.BOARD(), pcbnew.FromMM
place = getattr(pcbnew, "wxPoint", None) or pcbnew.VECTOR2I
corners = (60, 50), (105, 50), (105, 75), (60, 75), (60, 50)
for begin, end in zip(corners, corners[1:]):
    edge = pcbnew.PCB_SHAPE(board)
    edge.SetShape(pcbnew.SHAPE_T_SEGMENT)
    edge.SetStart(place(mm(begin[0]), mm(begin[1])))
    edge.SetEnd(place(mm(end[0]), mm(end[1])))
    edge.SetLayer(pcbnew.Edge_Cuts)
    edge.SetWidth(mm(0.1))
    board.Add(edge)
board.Save("b.kicad_pcb")
control = pcbnew.PLOT_CONTROLLER(pcbnew.LoadBoard("b.kicad_pcb"))
control.GetPlotOptions().SetOutputDirectory(".")
control.SetLayer(pcbnew.Edge_Cuts)
for name, kind in ("svg", pcbnew.PLOT_FORMAT_SVG), ("dxf", pcbnew.PLOT_FORMAT_DXF), ("plt", pcbnew.PLOT_FORMAT_HPGL):
    control.OpenPlotfile(name, kind, "")
    control.PlotLayer()
    control.ClosePlot()
"""
FREECAD = """
import importlib, os, sys
sys.path[:0] = ["/usr/share/freecad/Mod/Path/PathScripts/post"]
import FreeCAD, Part
import Path
from PathScripts import PathDrilling, PathJob, PathProfile
document = FreeCAD.newDocument("plate")
plate = Part.makeBox(30, 20, 4)
plate = plate.makeFillet(4, [edge for edge in plate.Edges if abs(edge.Vertexes[0].Z - edge.Vertexes[-1].Z) > 1])
for x in (9, 21):
    plate = plate.cut(Part.makeCylinder(2, 20, FreeCAD.Vector(x, 10, -5)))
solid = document.addObject("Part::Feature", "Plate")
solid.Shape = plate
document.recompute()
job = PathJob.Create("Job", [solid], None)
document.recompute()
tool = job.Tools.Group[0]
tool.HorizFeed, tool.VertFeed, tool.SpindleSpeed = "2400 mm/min", "1200 mm/min", 9000
tool.HorizRapid, tool.VertRapid = "3000 mm/min", "1000 mm/min"
contour = PathProfile.Create("Profile")
document.recompute()
holes = PathDrilling.Create("Drill")
holes.PeckEnabled, holes.PeckDepth = True, 2
document.recompute()
for post in ("grbl", "linuxcnc", "mach3_mach4"):
    importlib.import_module(post + "_post").export([tool, contour, holes], os.path.abspath(post + ".nc"), "--no-show-editor")
"""

# Program: its words, files it reads, {file it writes: (width and height in mm, how near)}. The interpreter of these tests is "python".
WRITE = {
    "inkscape": (["inkscape", "--export-type=svg", "--export-plain-svg", "-o", "o.svg", "a.svg"], {"a.svg": INK}, {"o.svg": (50, 30, 0.05)}),
    "openscad dxf": (["openscad", "-o", "o.dxf", "a.scad"], {"a.scad": "square([44, 23]);"}, {"o.dxf": (44, 23, 0.01)}),
    "openscad svg": (["openscad", "-o", "o.svg", "a.scad"], {"a.scad": "square([44, 23]);"}, {"o.svg": (44, 23, 0.01)}),
    "gnuplot": (["gnuplot", "-e", "set term hpgl; set output 'o.plt'; unset tics; unset key; set margins 0,0,0,0; plot x"], {}, {"o.plt": (259.1, 199, 3)}),
    "graph": (["graph", "-T", "hpgl", "a.txt"], {"a.txt": "1 1\n5 2\n"}, {"-o.plt": (134.2, 131, 2)}),
    "pstoedit": (["pstoedit", "-q", "-f", "hpgl", "a.eps", "o.plt"], {"a.eps": EPS}, {"o.plt": (50, 25, 0.1)}),
    "potrace": (["potrace", "-b", "svg", "-W", "100mm", "-o", "o.svg", "a.pbm"], {"a.pbm": PBM}, {"o.svg": (50, 50, 0.5)}),
    "R": (["R", "--vanilla", "-q", "-e", 'svg("o.svg", width=4, height=3); par(mar=c(0,0,0,0)); plot.new(); rect(0,0,1,1); x <- dev.off()'], {}, {"o.svg": (94.1, 70.6, 0.5)}),
    "matplotlib": (["python", "-c", "import matplotlib.pyplot as p; f = p.figure(figsize=(4, 2)); f.add_axes((.25, .25, .5, .5)).set(xticks=[], yticks=[]); f.savefig('o.svg')"], {}, {"o.svg": (50.8, 25.4, 0.1)}),
    "vpype": (["vpype", "line", "20mm", "20mm", "120mm", "70mm", "pagesize", "a4", "write", "o.svg"], {}, {"o.svg": (100, 50, 0.05)}),
    "kicad": ([PYTHON, "a.py"], {"a.py": KICAD}, {"b-svg.svg": (45, 25, 0.15), "b-plt.plt": (45, 25, 0.15), "b-dxf.dxf": (45, 25, 0.15)}),
    "dia svg": (["dia", "-e", "o.svg", "a.dia"], {"a.dia": DIA}, {"o.svg": (58.82, 35.29, 0.2)}),
    "dia plt": (["dia", "-e", "o.plt", "a.dia"], {"a.dia": DIA}, {"o.plt": (125, 75, 0.1)}),
    "fig2dev": (["fig2dev", "-L", "svg", "a.fig", "o.svg"], {"a.fig": FIG}, {"o.svg": (50, 20, 0.4)}),
    "fig2dev ibmgl": (["fig2dev", "-L", "ibmgl", "a.fig", "o.plt"], {"a.fig": FIG}, {"o.plt": (50, 20, 0.1)}),
    "zint": (["zint", "-d", "PASSO-1", "--notext", "-o", "o.svg"], {}, {"o.svg": (59.27, 26.46, 0.1)}),
    "barcode": (["barcode", "-b", "PASSO-1", "-e", "128", "-n", "-S", "-o", "o.svg"], {}, {"o.svg": (39, 28, 1)}),
    "ploticus": (["ploticus", "-prefab", "scat", "data=a.txt", "x=1", "y=2", "-svg", "-o", "o.svg"], {"a.txt": "0 0\n10 5\n20 3\n"}, {"o.svg": (62.9, 62.4, 3)}),
    "abcm2ps": (["abcm2ps", "-q", "-g", "-O", "o.svg", "a.abc"], {"a.abc": "X:1\nM:4/4\nK:C\nCDEF GABc|\n"}, {"o001.svg": (66, 17, 6)}),
    "gle": (["gle", "-d", "svg", "a.gle"], {"a.gle": "size 9 7\namove 1 1\nbox 6 4\n"}, {"a.svg": (60, 40, 0.1)}),
}  # fmt: skip


def run(folder, words, files):
    begin = interpreter.python() if words[0] == "python" else [shutil.which(words[0])]
    if not begin[0]:
        pytest.skip(f"{words[0]} is not installed")
    for name, text in files.items():
        (folder / name).write_text(text)
    return subprocess.run([*begin, *words[1:]], cwd=folder, capture_output=True, timeout=120, stdin=subprocess.DEVNULL, env={**os.environ, "HOME": str(folder), "QT_QPA_PLATFORM": "offscreen", "MPLBACKEND": "svg"})


@pytest.mark.parametrize("name", WRITE)
def test_a_program_that_is_here_is_drawn_at_its_size(name, tmp_path):
    words, files, wanted = WRITE[name]
    done = run(tmp_path, words, files)
    if name == "kicad" and b"No module named 'pcbnew'" in done.stderr:
        pytest.skip("kicad is not installed")
    for out, (width, height, near) in wanted.items():
        path = tmp_path / out.lstrip("-")
        if out.startswith("-"):
            path.write_bytes(done.stdout)
        assert path.is_file(), done.stderr.decode("utf-8", "replace")[-2000:]
        size, _page = drawn(path)
        assert size == pytest.approx((width, height), abs=near), out


def test_freecads_programs_run_without_a_refused_line(tmp_path):
    """By its posts for grbl, LinuxCNC and Mach: arcs with K, helices, pecks and a tool change."""
    command = "freecadcmd" if shutil.which("freecadcmd") else "FreeCADCmd"
    done = run(tmp_path, [command, "a.py"], {"a.py": FREECAD})
    found = {}
    for post in ("grbl", "linuxcnc", "mach3_mach4"):
        path = tmp_path / f"{post}.nc"
        assert path.is_file(), done.stderr.decode("utf-8", "replace")[-2000:]
        job = VirtualJob("router_3axis")
        job.run(gcode_file.file_lines(path))
        assert job.errors == []
        found[post] = [*job.low, *job.high]
    assert any("K0.000" in line for line in (tmp_path / "grbl.nc").read_text().splitlines())
    assert found["grbl"] == pytest.approx(found["linuxcnc"], abs=0.01) and found["grbl"] == pytest.approx(found["mach3_mach4"], abs=0.01)

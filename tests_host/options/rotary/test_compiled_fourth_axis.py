"""A program with A, compiled, on the virtual router with a rotary table: to the last step, and in the time that G93 says."""

import pytest
from asked import Asked
from typer.testing import CliRunner

from host_tools.cli.main import app
from host_tools.programs.compiler import compile_file

PROGRAM = """
(flutes: four cuts along a bar, then a thread around it)
g21 g90 g94 f1200
#<step> = 90
g0 x10 y10 z-5 a0
o100 sub
  g1 z-7 f300
  g1 x30 a[#5423+#1] f1200
  g0 z-5
  g91 g0 x-20 a[#<_step> - #1]
  g90
o100 endsub
#<_step> = #<step>
o101 repeat [4]
  o100 call [12.5]
o101 endrepeat
g92 a0
g93 g1 x20 a720 f20
g1 x20.0001 a360 f20
g91 g1 a-400 f30
g94
g20
g1 a10 f3600
g90 g53 g0 a100
m2
"""


@pytest.fixture
def listing(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text(PROGRAM)
    return compile_file(path, "ngc").listing


def test_a_compiled_program_ends_to_the_step(listing):
    asked = Asked("router_4axis", start=(2000, 2000, -2000, 0))
    asked.do("$X", *(code.replace(" ", "") for code in listing.codes[:-1]))
    asked.stand()
    assert asked.plant.position[3] == round(100 * 53.333)
    assert asked.machine.app.controller.queue.position()[:3] == [round(20.0001 * 320), 3200, -2000]


@pytest.mark.parametrize("text, seconds", [("g93 g1 x0.0001 a90 f6", 10), ("g93 g1 x2 a90 f6", 10), ("g93 g1 a90 f6", 10), ("g20\nf540\ng1 a90", 10), ("g20\nf1.2\ng1 x.1 a90", 5)])
def test_feeds(tmp_path, text, seconds):
    path = tmp_path / "part.ngc"
    path.write_text(text)
    asked = Asked("router_4axis", start=(0, 0, 0, 0))
    asked.do("$X", "G92X0Y0Z0A0")
    asked.do(*(code.replace(" ", "") for code in compile_file(path, "ngc", None, (0, 0, 0, 0)).listing.codes))
    asked.stand()
    rows = asked.machine.trace.rows()
    assert (rows[-1][0] - rows[0][0]) / 1e6 == pytest.approx(seconds, abs=0.15)  # starts and stops


def test_passo_check_takes_it(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text(PROGRAM)
    done = CliRunner().invoke(app, ["check", str(path), "--board", "router_4axis"])
    assert done.exit_code == 0, done.output + str(done.exception)
    assert "degrees" in done.output or "°" in done.output, done.output

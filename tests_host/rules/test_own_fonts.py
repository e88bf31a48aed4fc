"""Tests, and the programs that they start, have the fonts that they bring and no others: own_fonts.py."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from host_tools import interpreter

pytestmark = pytest.mark.quick
LISTED = "from matplotlib import font_manager as m; print(*sorted({each.fname for each in m.fontManager.ttflist}), sep='\\n')"


def test_fontconfig_has_only_dejavu():
    if not shutil.which("fc-match"):
        pytest.skip("fontconfig is not installed: apt-get install fontconfig")

    def ask(*words):
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout

    assert {line.split(",")[0] for line in ask("fc-list", ":", "family").splitlines()} <= {"DejaVu Sans", "DejaVu Sans Display", "DejaVu Sans Mono", "DejaVu Serif", "DejaVu Serif Display"}
    for name, font in (("", "DejaVu Sans"), ("serif", "DejaVu Serif"), ("Times New Roman", "DejaVu Serif"), ("monospace", "DejaVu Sans Mono"), ("Nowhere", "DejaVu Sans")):
        assert ask("fc-match", "-f", "%{family[0]}", name) == font, name


def test_matplotlib_has_only_its_own_fonts():
    own = Path(pytest.importorskip("matplotlib").__file__).parent
    listed = subprocess.run([*interpreter.python(), "-c", LISTED], capture_output=True, text=True, check=True).stdout.split("\n")[:-1]
    assert len(listed) > 10 and all(own in Path(name).parents for name in listed)
    assert os.environ["MPLCONFIGDIR"]

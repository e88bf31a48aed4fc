"""Runs a script of this folder under CPython with kernels in C, as `passo board` does: host_tools/build/pc_kernels.py.

    python compiled.py digest.py job.bin
    python compiled.py micro_runner.py --few check_line
"""

import runpy
import sys
from pathlib import Path

from host_tools.build.pc_kernels import use_compiled

if __name__ == "__main__":
    if not use_compiled():
        sys.exit("kernels are not C")
    del sys.argv[0]
    runpy.run_path(str(Path(__file__).parent / sys.argv[0]), run_name="__main__")

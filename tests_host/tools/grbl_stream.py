"""Runs grbl's own stream.py, which is for Python 2: python grbl_stream.py STREAM.PY FILE PORT. Its texts are bytes there, so a byte from 80h on is kept as
it is, one character each.
"""

import argparse
import sys
import warnings

warnings.simplefilter("ignore")
from lib2to3.refactor import RefactoringTool, get_fixers_from_package  # noqa: E402

import serial  # noqa: E402

BYTES = {"encoding": "ascii", "errors": "surrogateescape"}


class Serial(serial.Serial):
    def write(self, text):
        return super().write(text.encode(**BYTES))

    def readline(self):
        return super().readline().decode(**BYTES)


serial.Serial = Serial
argparse.FileType = lambda mode: lambda name: open(name, mode, newline="\n", **BYTES)
script = sys.argv.pop(1)
with open(script, encoding="utf-8") as source:
    converted = RefactoringTool(get_fixers_from_package("lib2to3.fixes")).refactor_string(source.read() + "\n", script)
exec(compile(str(converted), script, "exec"), {"__name__": "__main__"})

#!/bin/sh
# vpype 1.15.0 (PyPI), drawings for pen plotters: https://github.com/abey79/vpype
#
# Input: one line of 200 mm, written as HPGL for an HP 7475A.
# Most would guess: 8000 units, since a unit of HP-GL is 0.025 mm.
# Behaviour: 8039 units, of 0.02488 mm: vpype takes that plotter's own step. A program that reads HPGL by the language's unit draws 201.0 mm.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip -q install --disable-pip-version-check vpype==1.15.0 >&2
env/bin/vpype line 20mm 20mm 220mm 20mm write --absolute -q -d hp7475a -p a4 --landscape line.hpgl
seen=$(env/bin/python -c '
import re
from importlib.metadata import version
begin, end = re.search(r"PU(\d+),\d+;PD(\d+),\d+;", open("line.hpgl").read()).groups()
print(version("vpype"), int(end) - int(begin))
')
wanted='1.15.0 8039'
echo "$seen"
[ "$seen" = "$wanted" ] || { echo "changed: it was $wanted" >&2; exit 1; }

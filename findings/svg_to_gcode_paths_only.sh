#!/bin/sh
# svg-to-gcode 1.5.4 (PyPI), SVG to G-code for lasers: https://github.com/PadLex/SvgToGcode
#
# Input: five SVG files of one shape each: rect, circle, line, polyline, path.
# Most would guess: each shape gives curves, or a message.
# Behaviour: parse_file() returns none for all but the path, and prints nothing. Turn shapes into paths before.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip -q install --disable-pip-version-check svg-to-gcode==1.5.4 >&2
seen=$(env/bin/python -c '
from importlib.metadata import version
from svg_to_gcode.svg_parser import parse_file
shapes = ["rect width=\"30\" height=\"20\"", "circle r=\"9\"", "line x2=\"30\"", "polyline points=\"0,0 9,9\"", "path d=\"M0 0L30 0\""]
counts = []
for shape in shapes:
    with open("a.svg", "w") as file:
        file.write(f"<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100\" height=\"100\" viewBox=\"0 0 100 100\"><{shape}/></svg>")
    counts.append(len(parse_file("a.svg")))
print(version("svg-to-gcode"), *counts)
' 2>&1)
wanted='1.5.4 0 0 0 0 1'
echo "$seen"
[ "$seen" = "$wanted" ] || { echo "changed: it was $wanted" >&2; exit 1; }

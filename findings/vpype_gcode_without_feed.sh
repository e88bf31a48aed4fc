#!/bin/sh
# vpype-gcode 0.13.0 (PyPI), a writer of G-code for vpype 1.15.0: https://github.com/plottertools/vpype-gcode
#
# Input: one line of 50 mm, written by `gwrite --profile gcode`, a profile that comes with it.
# Most would guess: G-code that a controller runs, in mm like the line.
# Behaviour: G20 (inches), G01 without any F, and no code that puts a tool down; a controller that keeps to RS274 refuses the G01 (grbl: error 22).
# Write a profile of your own with F and the tool.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip -q install --disable-pip-version-check vpype==1.15.0 vpype-gcode==0.13.0 >&2
env/bin/vpype line 10mm 10mm 60mm 10mm pagesize a5 gwrite -p gcode line.gcode >&2
version=$(env/bin/python -c 'from importlib.metadata import version; print(version("vpype-gcode"))')
seen="$version G20 $(grep -c G20 line.gcode || true) G01 $(grep -c G01 line.gcode || true) F $(grep -c F line.gcode || true) Z or M3 $(grep -cE 'Z|M0?[34]' line.gcode || true)"
wanted='0.13.0 G20 1 G01 1 F 0 Z or M3 0'
echo "$seen"
[ "$seen" = "$wanted" ] || { echo "changed: it was $wanted" >&2; exit 1; }

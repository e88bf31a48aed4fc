#!/bin/sh
# svgpathtools 1.8.0 (PyPI), Bezier curves and SVG paths: https://github.com/mathandy/svgpathtools
#
# Input: two squares, one of 50 and one of 5 units, each written by wsvg(paths, filename=...) with its defaults.
# Most would guess: a drawing whose unit is a px, as in the paths; the small square a tenth of the large one.
# Behaviour: both files are 600 px wide (158.75 mm at 96 px an inch), whatever their paths measure; the viewBox is the paths' with 10 % around.
# Give wsvg(..., dimensions=("50mm", "50mm")) or svg_attributes.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip -q install --disable-pip-version-check svgpathtools==1.8.0 >&2
seen=$(env/bin/python -c '
import re
from importlib.metadata import version
from svgpathtools import parse_path, wsvg
sizes = []
for side in (50, 5):
    wsvg([parse_path(f"M0 0H{side}V{side}H0Z")], filename="a.svg")
    sizes += re.search(" width=\"(.*?)\"", open("a.svg").read()).groups()
print(version("svgpathtools"), *sizes)
')
wanted='1.8.0 600px 600px'
echo "$seen"
[ "$seen" = "$wanted" ] || { echo "changed: it was $wanted" >&2; exit 1; }

#!/bin/sh
# shapely 2.1.2 (PyPI), geometry: https://shapely.readthedocs.io
#
# Input: squares of 10, 60 and 600 units, each as the SVG that a geometry has of itself, _repr_svg_().
# Most would guess: a page as large as the square, a unit for a px; the small square a sixtieth of the large one.
# Behaviour: the page is 100 to 300 px wide, whatever the square measures (26 to 79 mm at 96 px an inch); the viewBox is the square's with 4 % around.
# And svg(), the element alone, has no page: give one, with a size in mm, and scale(1, -1).
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip -q install --disable-pip-version-check shapely==2.1.2 >&2
seen=$(env/bin/python -c '
import re
import shapely
widths = [re.search(r" width=\"(.*?)\"", shapely.box(0, 0, side, side)._repr_svg_())[1] for side in (10, 60, 600)]
print(shapely.__version__, *widths)
')
wanted='2.1.2 100.0 100.0 300'
echo "$seen"
[ "$seen" = "$wanted" ] || { echo "changed: it was $wanted" >&2; exit 1; }

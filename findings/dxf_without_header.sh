#!/bin/sh
# ezdxf 1.4.5 (PyPI), a library that reads and writes DXF: https://ezdxf.mozman.at
#
# Input: a DXF of one line, 60 long, that has ENTITIES alone and so no $INSUNITS. OpenSCAD writes its files so.
# Most would guess: no unit (0): the file names none.
# Behaviour: readfile(...).units is 6, metres, and an importer that converts by it makes 60 mm of 60 units 60 000 mm.
# Also: a file that is cut off amid its ENTITIES has no entities after ezdxf.recover.readfile(), and its auditor no error.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip -q install --disable-pip-version-check ezdxf==1.4.5 >&2
printf '%s\n' 0 SECTION 2 ENTITIES 0 LINE 8 0 10 0 20 0 11 60 21 0 0 ENDSEC 0 EOF > plate.dxf
printf '%s\n' 0 SECTION 2 ENTITIES 0 LINE 8 0 10 0 20 0 11 60 21 0 0 LINE 8 0 10 0 > cut.dxf
seen=$(env/bin/python -c '
import ezdxf
from ezdxf import recover
whole = ezdxf.readfile("plate.dxf")
cut, auditor = recover.readfile("cut.dxf")
print(ezdxf.__version__, "units", whole.units, "lines", len(whole.modelspace()), "cut: lines", len(cut.modelspace()), "errors", len(auditor.errors))
')
wanted='1.4.5 units 6 lines 1 cut: lines 0 errors 0'
echo "$seen"
[ "$seen" = "$wanted" ] || { echo "changed: it was $wanted" >&2; exit 1; }

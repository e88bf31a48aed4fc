#!/bin/sh
# potrace 1.16 (Debian 12, potrace and libpotrace0 1.16-2), pictures to outlines: https://potrace.sourceforge.net
#
# Input: a picture that is all black, traced with -W 100mm, once as SVG and once as DXF.
# Most would guess: 100 mm wide in both.
# Behaviour: the SVG says 283.464567pt, which is 100 mm; the DXF has x up to 283.464567 and names no unit, so a program that takes mm draws
# 283 mm. Scale it by 0.35278.
# Wants apt-get, dpkg-deb and zlib of Debian 12; nothing is installed.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
chmod 755 "$folder"
cd "$folder"
apt-get -q download potrace=1.16-2 libpotrace0=1.16-2 >&2
for package in *.deb; do dpkg-deb -x "$package" root; done
libraries=$(dirname "$(find root -name 'libpotrace.so*' | head -1)")
potrace() { LD_LIBRARY_PATH="$folder/$libraries" root/usr/bin/potrace "$@"; }
printf 'P1\n4 2\n1 1 1 1\n1 1 1 1\n' > black.pbm
potrace -b svg -W 100mm -a 0 -o black.svg black.pbm
potrace -b dxf -W 100mm -a 0 -o black.dxf black.pbm
version=$(potrace --version | sed -n '1s/potrace \([0-9.]*[0-9]\).*/\1/p')
width=$(sed -n 's/.* width="\([0-9.]*pt\)".*/\1/p' black.svg | head -1)
far=$(awk 'code == 10 { if ($1 > most) most = $1 } { code = NR % 2 ? $1 : "" } END { printf "%.1f", most }' black.dxf)
units=$(grep -c INSUNITS black.dxf || true)
seen="$version svg $width dxf $far units $units"
wanted='1.16 svg 283.464567pt dxf 283.5 units 0'
echo "$seen"
[ "$seen" = "$wanted" ] || { echo "changed: it was $wanted" >&2; exit 1; }

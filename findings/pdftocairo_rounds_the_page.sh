#!/bin/sh
# pdftocairo 22.12.0 (Debian 12, poppler-utils and libpoppler126 22.12.0-2+deb12u3), PDF to SVG: https://poppler.freedesktop.org
#
# Input: a PDF of one page of 284.03 x 56.69 pt (100.2 x 20 mm) with a line of 28.3465 pt (10 mm), written with -svg.
# Most would guess: the line stays 10 mm long.
# Behaviour: the page is rounded up to whole points and fitted into the true one: matrix(0.994561, ...), so the line is 0.54 % short, and the
# drawing shifted by 0.29 pt. Of a page in whole points (283 x 57) nothing changes. pdf2svg of the same library keeps the size.
# Wants apt-get, dpkg-deb and the libraries that poppler needs (cairo, fontconfig, freetype, curl, nss, lcms, openjpeg, tiff); nothing is installed.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
chmod 777 "$folder"
cd "$folder"
apt-get -q download poppler-utils=22.12.0-2+deb12u3 libpoppler126=22.12.0-2+deb12u3 >&2
for package in *.deb; do dpkg-deb -x "$package" root; done
libraries=$(dirname "$(find root -name 'libpoppler.so*' | head -1)")
pdftocairo() { LD_LIBRARY_PATH="$folder/$libraries" root/usr/bin/pdftocairo "$@"; }
python3 - <<'END'
def write(name, width, height):
    ops = "28.3465 10 m 56.6929 10 l S"
    bodies = ["<</Type/Catalog/Pages 2 0 R>>", "<</Type/Pages/Kids[3 0 R]/Count 1>>",
              f"<</Type/Page/Parent 2 0 R/MediaBox[0 0 {width} {height}]/Contents 4 0 R>>", f"<</Length {len(ops)}>>stream\n{ops}\nendstream"]
    out, begins = "%PDF-1.4\n", []
    for number, body in enumerate(bodies, 1):
        begins.append(len(out))
        out += f"{number} 0 obj\n{body}\nendobj\n"
    table = "".join(f"{begin:010d} 00000 n \n" for begin in begins)
    out += f"xref\n0 5\n0000000000 65535 f \n{table}trailer<</Size 5/Root 1 0 R>>\nstartxref\n{len(out)}\n%%EOF\n"
    open(name, "w").write(out)
write("odd.pdf", 284.03, 56.69)
write("whole.pdf", 283, 57)
END
for name in odd whole; do pdftocairo -svg $name.pdf $name.svg; done
factor() { sed -n 's/.* transform="matrix(\([0-9.]*\),.*/\1/p' "$1.svg" | head -1; }
version=$(pdftocairo -v 2>&1 | sed -n '1s/.* //p')
seen="$version odd $(factor odd) whole $(factor whole)"
wanted='22.12.0 odd 0.994561 whole 1'
echo "$seen"
[ "$seen" = "$wanted" ] || { echo "changed: it was $wanted" >&2; exit 1; }

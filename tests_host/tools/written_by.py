"""Small files of own geometry, each written as one program writes its files, with Passo's result: the rows of docs/use/makers.md.

Drawings: (name of a file, text, size drawn in mm, the note). Programs: (name of a file, text, low, high in mm), and those that
are refused (name of a file, text, the sentence).
"""

SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
LINES = '<g fill="none" stroke="#000" stroke-width="1">'


def dxf(entities, header=""):
    """A DXF of rows "code value", apart by semicolons."""
    begin = f"0 SECTION;2 HEADER;{header};0 ENDSEC;" if header else ""
    rows = f"{begin}0 SECTION;2 ENTITIES;{entities};0 ENDSEC;0 EOF".split(";")
    return "".join("{}\n{}\n".format(*row.split(" ", 1)) for row in rows)


def line(x, y, to_x, to_y):
    return f"0 LINE;8 0;10 {x};20 {y};11 {to_x};21 {to_y}"


MM = "mm are taken"

# Row of the page: its drawing.
DRAWINGS = {
    "Inkscape SVG": ("a.svg", SVG + 'width="90mm" height="70mm" viewBox="0 0 90 70"><g style="display:inline"><rect style="fill:none;stroke:#000;stroke-width:.2" x="10" y="5" width="60" height="40"/></g></svg>', (60, 40), ""),
    "Inkscape HPGL": ("a.hpgl", "\n;IN;SP1;PU1000,400;PD3400,400;PD3400,2000;PD1000,2000;PD1000,400;SP0;PU0,0;IN; ", (60, 40), ""),
    "Inkscape DXF R14": ("a.dxf", dxf(line(0, 0, 60, 0) + ";" + line(60, 0, 60, 40), "9 $INSUNITS;70 4"), (60, 40), ""),
    "Inkscape DXF R12": ("a.dxf", dxf(line(0, 0, 60, 40)), (60, 40), MM),
    "KiCad SVG": ("a.svg", SVG + f'width="297.0022mm" height="210.0072mm" viewBox="0 0 297002200 210007200">{LINES}<path stroke-width="100000" d="M50000000 60000000 95000000 60000000 95000000 85000000"/></g></svg>', (45, 25), ""),
    "KiCad DXF": ("a.dxf", dxf(line(2, -3, 3, -1), "9 $ANGBASE;50 0.0;9 $MEASUREMENT;70 0"), (25.4, 50.8), "inches are taken"),
    "KiCad HPGL": ("a.plt", "IN;VS40;PU;PA;SP1;\nPU 4000,3200;\nPD 5600,3200;\nPD 5600,4400;\nPU;PA;SP0;\n", (40, 30), ""),
    "OpenSCAD DXF": ("a.dxf", dxf(line(0, 0, 33, 0) + ";" + line(33, 0, 33, 22)), (33, 22), MM),
    "gnuplot HPGL": ("a.plt", "\x1b.Y\n\x1b.I81;;17:\x1b.N;19:\x1b.M500:\nIN;\nPU;\nSP1;\nPU;PA400,800;\nPD;PA2400,800;\nPD;PA2400,1600;\n", (50, 20), ""),
    "gnuplot SVG": ("a.svg", SVG + f'width="600" height="480" viewBox="0 0 600 480"><rect x="0" y="0" width="600" height="480" fill="none"/>{LINES}<path d="M96 96H288V192"/></g></svg>', (50.8, 25.4), "nobody sees"),
    "plotutils HPGL": ("a.plt", "BP;IN;\nPS10160,7620;\nSP1;PU1000,1000;PA;PD3000,1000,3000,1800;PU;SP0;\n", (50, 20), ""),
    "makerjs SVG": ("a.svg", SVG + f'width="80" height="50" viewBox="0 0 80 50">{LINES}<path d="M0 0L80 0L80 50"/></g></svg>', (21.17, 13.23), ""),
    "d3, matplotlib, R": ("a.svg", SVG + 'width="144pt" height="72pt" viewBox="0 0 144 72"><path d="M0 72L144 72L144 0L0 0z" style="fill:#ffffff"/><path d="M36 36L108 36L108 54" style="fill:none;stroke:#1f77b4"/></svg>', (25.4, 6.35), "white background"),
    "potrace SVG": ("a.svg", SVG + 'width="100pt" height="50pt" viewBox="0 0 100 50"><g transform="translate(0,50) scale(0.1,-0.1)" fill="#000" stroke="none"><path d="M100 100l720 0 0 360 -720 0z"/></g></svg>', (25.4, 12.7), ""),
    "potrace DXF": ("a.dxf", dxf(line(0, 0, 72, 36)), (72, 36), MM),
    "pdf2svg": ("a.svg", SVG + 'width="283.465pt" height="141.732pt" viewBox="0 0 283.465 141.732"><path fill="none" stroke="#000" stroke-width="1" d="M 1 1 L 8 1 L 8 6" transform="matrix(28.346457,0,0,-28.346457,0,141.7)"/></svg>', (70, 50), ""),
    "pstoedit plot-svg": ("a.svg", SVG + 'width="8in" height="8in" viewBox="0 0 1 1" preserveAspectRatio="none"><rect x="0" y="0" width="1" height="1" stroke="none" fill="white"/><g transform="translate(-0.03125,1.1875) scale(1,-1) scale(0.00173611)" stroke="black" fill="none"><line x1="110" y1="210" x2="393.4646" y2="210" stroke-width="1"/></g></svg>', (100, 0), "white background"),
    "viaConstructor HPGL": ("a.hpgl", ";\nPU;\nPA;\nSP1;\nPU400,400;\nPD2800,400,2800,2000;\nPU", (60, 40), ""),
    "gnuplot DXF": ("a.dxf", "999\n% GNUPLOT: dxf file for AutoCad\n" + dxf("0 POLYLINE;8 1;6 CONTINUOUS;66 1;0 VERTEX;8 1;6 CONTINUOUS;10 9.167;20 4.000;30 0.000;0 VERTEX;8 1;6 CONTINUOUS;10 114.983;20 44.000;30 0.000;0 SEQEND", "9 $EXTMIN;10 0.000;20 0.000;9 $EXTMAX;10 120.000;20 80.000"), (105.82, 40), MM),
    "gnuplot PCL": ("a.pcl", "\x1bE\x1b&l1X\x1b&l1O\r\n\x1b%0B\x1b%0BINNP8SP1SD1,277,2,1,4,12.0,5,0,6,0,7,4148;SS;\nPU;\nSP1;PC1;\nPW0.25;\nLTLT;PA400,400;PD2400,400,2400,1200;PU;\nSP1;PC1;\n\x1b%1A\x1b&l0H\n\x1b%0A\x1bE", (50, 20), ""),
    "plotutils SVG": ("a.svg", '<?xml version="1.0" encoding="ISO-8859-1" standalone="no"?>\n' + SVG + 'version="1.1" baseProfile="full" width="8in" height="8in" viewBox="0 0 1 1" preserveAspectRatio="none"><rect id="background" x="0" y="0" width="1" height="1" stroke="none" stroke-width="0" fill="white"/><g id="content" transform="translate(0,1) scale(1,-1) scale(0.1)" fill-rule="evenodd"><polyline points="2,2 7,2 7,4.5 " fill="none" stroke="black" stroke-width="0.00847"/></g></svg>', (101.6, 50.8), "white background"),
    "makerjs DXF": ("a.dxf", dxf(line(0, 0, 60, 0) + ";" + line(60, 0, 60, 30), "9 $INSUNITS;70 4"), (60, 30), ""),
    "JSCAD": ("a.svg", '<?xml version="1.0" encoding="UTF-8"?>\n<!-- Created by JSCAD SVG Serializer -->\n' + SVG + 'width="60mm" height="30mm" viewBox="0 0 60 30" fill="none" fill-rule="evenodd" stroke-width="0.1px" version="1.1" baseProfile="tiny"><g><path fill="black" d="M0 30L60 30L60 0L0 0L0 30"/></g></svg>', (60, 30), ""),
    "svgwrite, drawsvg": ("a.svg", SVG + 'baseProfile="full" height="60mm" version="1.1" viewBox="0 0 90 60" width="90mm"><defs /><rect fill="none" height="30" stroke="black" width="50" x="10" y="10" /></svg>', (50, 30), ""),
    "shapely": ("a.svg", SVG + 'width="100.0" height="100.0" viewBox="-2.4 -2.4 64.8 34.8" preserveAspectRatio="xMinYMin meet"><g transform="matrix(1,0,0,-1,0,30.0)"><path fill-rule="evenodd" fill="#66cc99" stroke="#555555" stroke-width="1.296" opacity="0.6" d="M 60.0,0.0 L 60.0,30.0 L 0.0,30.0 L 0.0,0.0 L 60.0,0.0 z" /></g></svg>', (24.5, 12.25), ""),
    "Graphviz": ("a.svg", SVG + 'width="62pt" height="44pt" viewBox="0.00 0.00 62.00 44.00"><g id="graph0" class="graph" transform="scale(1 1) rotate(0) translate(4 40)"><polygon fill="white" stroke="transparent" points="-4,4 -4,-40 58,-40 58,4 -4,4"/><g class="node"><title>a</title><polygon fill="none" stroke="black" points="54,-36 0,-36 0,0 54,0 54,-36"/></g></g></svg>', (19.05, 12.7), "white background"),
    "qrencode": ("a.svg", SVG + 'width="3.07cm" height="3.07cm" viewBox="0 0 29 29" preserveAspectRatio="none" version="1.1"><g id="QRcode"><rect x="0" y="0" width="29" height="29" fill="#ffffff"/><g id="Pattern" transform="translate(4,4)"><rect x="0" y="0" width="1" height="1" fill="#000000"/><rect x="20" y="20" width="1" height="1" fill="#000000"/></g></g></svg>', (22.23, 22.23), "white background"),
    "qrcode": ("a.svg", '<svg xmlns:svg="http://www.w3.org/2000/svg" width="29mm" height="29mm" version="1.1" xmlns="http://www.w3.org/2000/svg"><svg:rect x="4mm" y="4mm" width="1mm" height="1mm" /><svg:rect x="24mm" y="24mm" width="1mm" height="1mm" /></svg>', (21, 21), ""),
    "pdftocairo": ("a.svg", SVG + 'width="284.03pt" height="56.69pt" viewBox="0 0 284.03 56.69" version="1.2"><g id="surface1"><path style="fill:none;stroke-width:1;stroke:rgb(0%,0%,0%)" d="M 28.344624 9.998564 L 56.694118 9.998564 " transform="matrix(0.994561,0,0,-0.994561,0.29,56.381686)"/></g></svg>', (9.947, 0), ""),
    "pstoedit DXF": ("a.dxf", "999\n DXF created by pstoedit\n" + dxf("0 LINE;8 C00-00-00;62 0;10 0.277778;20 0.277778;30 0.0;11 4.214786;21 0.277778;31 0.0"), (3.937, 0), MM),
    "vpype HPGL": ("a.hpgl", "IN;DF;PS4;SP1;PU402,400;PD8441,400;PU;SP0;IN;", (200.98, 0), ""),
    "Dia SVG": ("a.svg", SVG + 'width="7cm" height="5cm" viewBox="19 19 122 82"><g><rect style="fill:#fff;stroke-width:2;stroke:#000" x="20" y="20" width="120" height="80"/></g></svg>', (68.85, 45.9), ""),
    "Dia DXF": ("a.dxf", dxf(line(1, -1, 7, -5), "9 $EXTMIN;10 .95;20 -5.05"), (6, 4), MM),
    "Dia HPGL": ("a.plt", "SP1;\nLT;\nPU1000,-1000;PD;EA7000,-5000;\n", (150, 100), ""),
    "fig2dev SVG": ("a.svg", SVG + f'width="2.5in" height="1.5in" viewBox="400 400 3000 1800">{LINES}<rect x="450" y="450" width="2400" height="1200" stroke-width="8px"/></g></svg>', (50.8, 25.4), ""),
    "fig2dev IBMGL": ("a.plt", "BP;IN;\nIP0,8396,11881,0;\nIW0,0,11881,8396;\nSC0,11.69,0,8.26;\nPW0.3;\nSP1;\nPA1,1;PM;PD3,1;\nPA3,2;\nPA1,2;\nPA1,1;\nPU;PM2;\nEP;\nPU;SP;IN;\n", (50.82, 25.41), ""),
    "fig2dev DXF": ("a.dxf", dxf(line(0, 0, 2, 1)), (2, 1), MM),
    "zint": ("a.svg", SVG + 'width="240" height="120"><g fill="#000000"><rect x="0" y="0" width="240" height="120" fill="#FFFFFF"/><rect x="24.00" y="0.00" width="4.00" height="96.00"/><rect x="212.00" y="0.00" width="4.00" height="96.00"/></g></svg>', (50.8, 25.4), "white background"),
    "GNU barcode": ("a.svg", SVG + 'width="132pt" height="100pt"><rect x="0pt" y="0pt" width="132pt" height="100pt" style="fill:#ffffff;fill-opacity:1"/><line x1="11pt" y1="82pt" x2="11pt" y2="10pt" style="stroke:rgb(0,0,0);stroke-width:1.85pt"/><line x1="83pt" y1="82pt" x2="83pt" y2="10pt" style="stroke:rgb(0,0,0);stroke-width:1.85pt"/></svg>', (25.4, 25.4), "white background"),
    "ploticus": ("a.svg", '<?xml version="1.0" encoding="iso-8859-1"?>\n<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 20010904//EN" "http://www.w3.org/TR/2001/REC-SVG-20010904/DTD/svg10.dtd" [\n<!ENTITY sw "stroke-width:">\n]>\n' + SVG + 'width="200" height="100"><polyline style="&sw;1;stroke:black;fill:none" points="10,10 106,10 106,58"/></svg>', (25.4, 12.7), ""),
    "abcm2ps": ("a.svg", SVG + 'color="black" width="816.00px" height="108.00px"><style type="text/css">.fill {fill: currentColor}\n.stroke {stroke: currentColor; fill: none}</style><path class="stroke" stroke-width="0.7" d="m48 60h384m-384 -6h384"/></svg>', (101.6, 1.5875), ""),
    "GLE": ("a.svg", SVG + 'width="257.11811pt" height="200.425197pt" viewBox="0 0 257.11811 200.425197"><g id="surface1"><path style="fill:none;stroke-width:0.02;stroke:rgb(0%,0%,0%)" d="M 1 1 L 8 1 L 8 6 L 1 6 Z M 1 1" transform="matrix(28.346457,0,0,-28.346457,1,199.425197)"/></g></svg>', (70, 50), ""),
    "schemdraw": ("a.svg", SVG + 'height="72pt" width="144pt" viewBox="-4.6 -31.2 144 72"><path d="M 0.0,-0.0 L 36,-0 L 39,-9 L 72,-0" style="stroke:black;fill:none;stroke-width:2.0;stroke-dasharray:-;"/></svg>', (25.4, 3.175), ""),
    "svgpathtools": ("a.svg", SVG + 'height="361px" viewBox="-5 -3 60 36.1" width="600px"><path d="M 0,0 L 48.0,0.0 L 48.0,24.0" fill="none" stroke="#000000" stroke-width="0.05"/></svg>', (127, 63.5), ""),
    "dxf-writer": ("a.dxf", dxf("0 LWPOLYLINE;5 1F;100 AcDbEntity;8 cut;100 AcDbPolyline;90 3;70 0;10 0;20 0;10 70;20 0;10 70;20 40", "9 $ACADVER;1 AC1021;9 $INSUNITS;70 4"), (70, 40), ""),
    "MathJax": ("a.svg", SVG + 'width="10ex" height="5ex" viewBox="0 -1000 4000 2000"><defs><path id="x" d="M0 0L800 0L800 800Z"/></defs><g stroke="currentColor" fill="currentColor" stroke-width="0" transform="scale(1,-1)"><use xlink:href="#x"/><use xlink:href="#x" transform="translate(3200,0)"/></g></svg>', None, "ex"),
    "bwip-js": ("a.svg", SVG + 'viewBox="0 0 224 74"><path stroke="#000000" stroke-width="4" d="M2 58L2 0M194 58L194 0"/></svg>', (50.8, 15.35), ""),
    "paper.js": ("a.svg", SVG + 'version="1.1" width="200" height="100" viewBox="0,0,200,100"><g fill="none" stroke="#000" stroke-width="1" font-family="none" font-size="none" style="mix-blend-mode: normal"><path d="M20,20h96v48"/></g></svg>', (25.4, 12.7), ""),
}  # fmt: skip

HEAD = "(Exported by FreeCAD)\n(Post Processor: {}_post)\n(Output Time:2026-11-28 20:03:25)\n"

# Row of the page: the program, bounds of its path in mm.
PROGRAMS = {
    "FreeCAD grbl": ("a.nc", HEAD.format("grbl") + "(Begin preamble)\nG17 G90\nG21\n(TC: Default Tool)\n( M6 T1 )\nM3 S10000\nG0 Z14.000\nG0 X40.000 Y20.000\nG1 Z-1.000 F150.000\nG2 X30.000 Y10.000 Z-1.000 I-10.000 J0.000 K0.000 F600.000\nG1 X30.000 Y0.000 Z-1.000 F600.000\nM5\nG17 G90\nM2\n", (0, 0, -1), (40, 20, 14)),
    "FreeCAD linuxcnc, mach3": ("a.nc", HEAD.format("linuxcnc") + "(begin preamble)\nG17 G54 G40 G49 G80 G90\nG21\nM5\nM6 T1\nG43 H1\nM3 S10000\nG0 Z14\nG0 X8 Y8\nG98\nG83 X8 Y8 Z0 F150 Q2 R12\nG83 X52 Y8 Z0 F150 Q2 R12\nG80\nM5\nG17 G54 G90 G80 G40\nM2\n", (0, 0, 0), (52, 8, 14)),
    "FreeCAD fablin": ("a.nc", "G90\nG0 Z5.0000 F10000\nG0 X10.0000 Y0.0000\nG1 Z-1.0000 F2.50\nG1 X40.0000 Y0.0000 F40.00\nG1 X40.0000 Y20.0000 F40.00\nM5\nG00 X-1.0 Y1.0\nG90\n", (-1, 0, -1), (40, 20, 5)),
    "viaConstructor": ("a.ngc", "(--------------------------------------------------)\n(Generator: viaConstructor)\nG21 (Metric/mm)\nG40 (No Offsets)\nG90 (Absolute-Mode)\nG64 P0.05\nM05 (Spindle off)\nG00 Z5.0\nM06 T1\nM03 S10000\nG04 P1\nG00 X10 Y10\nG01 Z-2 F100\nG03 X20 Y20 I0 J10 F800\nG00 Z5\nM05\nM02\n", (0, 0, -2), (20, 20, 5)),
    "svg-to-gcode and others": ("a.gcode", "G21;\nG90;\nG1 F1000;\nM5;\n" + f"; {'a long comment ' * 20}\n" + "G1 X30 Y20;\nM3 S255;\nG1 X45.25 Y20;\nM5;\n", (0, 0, 0), (45.25, 20, 0)),
}  # fmt: skip

CHOOSE = "choose grbl, linuxcnc or mach3_mach4"

# Row of the page: the program, and the sentence of the refusal.
REFUSED = {
    "FreeCAD rrf, marlin": ("a.nc", HEAD.format("rrf") + "G90\nG21\nT1\nM3 S10000\nG4 S3\nG0 X1\n", f"FreeCAD's post rrf: {CHOOSE}"),
    "FreeCAD uccnc": ("a.nc", "%prog1\n(uccnc_post --no-show-editor)\n(Exported by FreeCAD for UC-CNC)\nG0 X1\n", f"FreeCAD's post uccnc: {CHOOSE}"),
    "FreeCAD centroid": ("a.nc", ";Exported by FreeCAD\n;Post Processor: centroid_post\nG0 X1\nM25\nG49 H0\nM99\n", f"FreeCAD's post centroid: {CHOOSE}"),
    "FreeCAD opensbp": ("a.nc", "'Exported by FreeCAD\n'Post Processor: opensbp_post\n&Tool=1\nTR,10000.0\nJZ,14\n", "ShopBot"),
    "FreeCAD rml": ("a.nc", "PA;PA;\n!MC1;\nVS2.0;\n!VZ1.0;\nZ2442,1642,240;\n", "Roland's mills"),
    "FreeCAD nccad": ("a.nc", ";Exported by FreeCAD\n;Post Processor: nccad_post\nG77      ; release\nM10 O6.0\n", "nccad"),
    "Slic3r": ("a.gcode", "; generated by Slic3r 1.3.0 on 2026-11-28\n\nG21\nG1 F7800 X66.668 Y74.274 2.00000\n", "PrusaSlicer with the G-code flavor No extrusion"),
    "PrusaSlicer": ("a.gcode", "; generated by PrusaSlicer 2.5.0 on 2026-11-28\n\nM107\nG21\nG1 X10 Y10 E1.5 F600\n", "choose the G-code flavor No extrusion, empty start"),
    "FullControl": ("a.gcode", "; Time to print!!!!!\n; GCode created with FullControl - tell us what you print\nM83\nG1 F1000 X40 E0.99\n", "FullControl"),
    "Cura": ("a.gcode", ";FLAVOR:Marlin\n;TIME:100\nM104 S200\nG1 X10 E1\n", "Cura"),
    "mecode": ("a.gcode", "G91 ;relative\nG1 F600\nG16 X Y Z ;coordinate axis assignment\nG18 ;XZ plane\nG2 X10.000000 Z10.000000 R20.000000\nG90 ;absolute\n", "sed '/^G16/d'"),
    "vpype-gcode": ("a.gcode", "G20\nG17\nG90\nG00 X0.3937 Y7.8740\nG01 X2.3622 Y7.8740\n", "docs/use/vpype.toml has profiles"),
    "pstoedit gcode": ("a.ngc", "( Generated by pstoedit 3.78 from l.eps at 20261128201545\0 )\nG20\nG90\nG01 X1\n", "pstoedit -f hpgl"),
    "KiCad drill": ("a.drl", "M48\n; DRILL file {KiCad}\nFMAT,2\nMETRIC\nT1C0.800\n%\nG90\nT1\nX10.0Y-10.0\nM30\n", "drill file"),
}  # fmt: skip

"""DXF files that ezdxf refuses: old Inkscape's, without a header, splines without their subclass, one handle for all entities; and those that
it reads as empty, because they are cut off.

    repair_tags(data)          # bytes of a text DXF -> bytes that ezdxf.recover reads, or None if they are no tags
    section_cut_off(data)   # the name of the section amid which the file ends, or None
"""

import re

_BOUND = re.compile(rb"(?:^|\n)[ \t]*0[ \t]*\r?\n[ \t]*(SECTION|ENDSEC|EOF)[ \t\r]*(?=\n|$)(?:\n[ \t]*2[ \t]*\r?\n[ \t]*(\w+))?")

_HEADER = [(b"0", b"SECTION"), (b"2", b"HEADER"), (b"9", b"$ACADVER"), (b"1", b"AC1015"), (b"0", b"ENDSEC")]
_SUBCLASS = [(b"100", b"AcDbEntity"), (b"100", b"AcDbSpline")]
_BODY = (b"210", b"70", b"71")  # codes that a spline's own data begin with


def repair_tags(data):
    """Return the bytes of a text DXF in a form that ezdxf.recover reads; None if there are no tags, or a header is there."""
    lines = [line.strip() for line in data.splitlines()]
    tags = [tag for tag in zip(lines[::2], lines[1::2]) if tag[0] != b"999"]
    if not tags or (b"2", b"HEADER") in tags:
        return None
    found, spline, waits = _HEADER[:], False, False
    for code, value in tags:
        if code == b"0":
            spline = waits = value == b"SPLINE"
        elif code == b"5" or spline and code == b"100":
            continue
        elif waits and code in _BODY:
            found += _SUBCLASS
            waits = False
        found.append((code, value))
    return b"".join(b"%s\n%s\n" % tag for tag in found)


def section_cut_off(data):
    """Return the name of the section amid which a text DXF's bytes end, "SECTION" if it has no name; None if its last section is closed."""
    bounds = [match.groups() for match in _BOUND.finditer(data)]
    if bounds and bounds[-1][0] == b"SECTION":
        return (bounds[-1][1] or b"SECTION").decode("ascii")
    return None

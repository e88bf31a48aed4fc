"""DXF files as CAD programs write them: splines by any knots, frames, units, frozen layers, files that are cut off, pages, bounds."""

import math
import time

import ezdxf
import ezdxf.fonts.fonts
import numpy
import pytest
from ezdxf.render.forms import cube
from hypothesis import given, settings
from hypothesis import strategies as st

from host_tools import boards
from host_tools.drawings import drawing, dxf_entities, placement, sources
from host_tools.drawings.placement import MM_PER_PX, Options, box_of
from host_tools.failure import Failure

INCH = 25.4


def saved(tmp_path, draw, units=4, version="R2010", measurement=None):
    """The path of a file that `draw(document, space)` makes."""
    document = ezdxf.new(version)
    document.header["$INSUNITS"] = units
    if measurement is not None:
        document.header["$MEASUREMENT"] = measurement
    draw(document, document.modelspace())
    path = tmp_path / "a.dxf"
    document.saveas(path)
    return path


def lines_mm(path, deviation_px=0.02):
    """(lines in mm, y up, their page)."""
    page = sources.open_drawing(path).outlines(deviation_px)
    lines = [(line.real + 1j * (page.size_px[1] - line.imag)) * MM_PER_PX for lines in page.layers.values() for line in lines]
    return lines, page


def size_mm(lines):
    left, bottom, right, top = box_of([lines])
    return right - left, top - bottom


# --- splines


def by_de_boor(points, knots, degree, at):
    """The place on a B-spline of complex control points."""
    span = next(index for index in range(degree, len(points)) if knots[index] <= at <= knots[index + 1] and knots[index] < knots[index + 1])
    row = [points[span - degree + index] for index in range(degree + 1)]
    for level in range(1, degree + 1):
        for index in range(degree, level - 1, -1):
            low, high = knots[span - degree + index], knots[span + 1 + index - level]
            share = (at - low) / (high - low)
            row[index] = (1 - share) * row[index - 1] + share * row[index]
    return row[degree]


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_clamped_spline_is_the_same_curve(data):
    degree = data.draw(st.integers(1, 5))
    count = data.draw(st.integers(degree + 1, degree + 6))
    steps = data.draw(st.lists(st.integers(0, 3), min_size=count + degree, max_size=count + degree))
    knots = [-2.0 + float(each) for each in numpy.cumsum([0, *steps])]
    points = data.draw(st.lists(st.builds(complex, st.integers(-50, 50), st.integers(-50, 50)), min_size=count, max_size=count))
    found = dxf_entities.clamp_knots([(each.real, each.imag) for each in points], knots, [], degree)
    begin, end = knots[degree], knots[count]
    if found is None:
        assert not begin < end or knots[0] == begin and knots[-1] == end
        return
    places, clamped, weights = found
    assert clamped[:degree + 1] == [0.0] * (degree + 1) and clamped[-degree - 1:] == [end - begin] * (degree + 1) and weights == []
    if any(clamped.count(each) > degree for each in clamped[degree + 1 : -degree - 1]):
        return  # a curve of two parts
    places = [complex(*each) for each in places]
    for at in numpy.linspace(begin, end, 17):
        assert abs(by_de_boor(places, clamped, degree, at - begin) - by_de_boor(points, knots, degree, at)) < 1e-6


def test_a_periodic_spline_of_weights_stays_in_its_domain(tmp_path):
    """Seven control points around a square: ezdxf draws 242 mm of it."""
    corners = [(20, 20, 0), (40, 20, 0), (40, 40, 0), (20, 40, 0)]
    for weights in ([], [1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0]):

        def draw(document, space, weights=weights):
            spline = space.add_spline(dxfattribs={"degree": 3, "flags": 3})
            spline.control_points, spline.knots, spline.weights = corners + corners[:3], list(range(11)), weights

        lines, _ = lines_mm(saved(tmp_path, draw))
        assert abs(lines[0][0] - lines[0][-1]) < 1e-6
        if not weights:
            # The uniform cubic goes farthest halfway between two corners: 1/48 of the first and the last, 23/48 of both in the middle.
            assert size_mm(lines) == pytest.approx((20 * 44 / 48,) * 2, abs=0.02)
        assert max(size_mm(lines)) < 20


@pytest.mark.parametrize("kind", ["in a block", "edge of a hatch"])
def test_splines_elsewhere_are_cut_to_their_domain_too(tmp_path, kind):
    points, knots = [(0, 0), (10, 20), (20, 0), (30, 20), (40, 0)], list(range(9))

    def draw(document, space):
        if kind == "in a block":
            spline = document.blocks.new("B").add_spline(dxfattribs={"degree": 3})
            spline.control_points, spline.knots = points, knots
            space.add_blockref("B", (0, 0), dxfattribs={"xscale": 2})
        else:
            path = space.add_hatch().paths.add_edge_path()
            path.add_spline(control_points=points, knot_values=knots, degree=3)
            path.add_line((30, 20 / 3), (10, 20 / 3))

    lines, _ = lines_mm(saved(tmp_path, draw))
    begin, end = (by_de_boor([complex(*each) for each in points], knots, 3, at) for at in (3, 5))
    wide = abs(end - begin) * (2 if kind == "in a block" else 1)
    assert size_mm(lines)[0] == pytest.approx(wide, abs=0.02) == (40 if kind == "in a block" else 20)


def test_the_frame_of_a_spline_fit_polyline_is_not_drawn(tmp_path):
    curve = [(10, 10), (15, 17.5), (20, 20), (25, 17.5), (30, 10)]

    def draw(document, space):
        line = space.add_polyline2d([(10, 10), (20, 30), (30, 10), *curve], dxfattribs={"flags": 4})
        for index, vertex in enumerate(line.vertices):
            vertex.dxf.flags = 16 if index < 3 else 8

    lines, _ = lines_mm(saved(tmp_path, draw))
    assert len(lines) == 1 and size_mm(lines) == pytest.approx((20, 10)) and len(lines[0]) == len(curve)


def test_the_frame_of_a_smooth_mesh_is_not_drawn(tmp_path):
    def draw(document, space):
        mesh = space.add_polymesh((2, 2))
        for row, column in ((0, 0), (0, 1), (1, 0), (1, 1)):
            mesh.set_mesh_vertex((row, column), (row * 90, column * 90, 0))
        for vertex in mesh.vertices:
            vertex.dxf.flags = 16 + 64
        mesh.append_vertices([(row * 10, column * 10, 0) for row in range(3) for column in range(3)], dxfattribs={"flags": 8 + 64})
        mesh.dxf.smooth_type, mesh.dxf.m_smooth_density, mesh.dxf.n_smooth_density = 6, 3, 3

    lines, _ = lines_mm(saved(tmp_path, draw))
    assert size_mm(lines) == pytest.approx((20, 20))


# --- units


@pytest.mark.parametrize("units, measurement, mm, named", [
    (0, 0, INCH, "inches are taken"), (0, 1, 1.0, "mm are taken"), (0, None, 1.0, "mm are taken"), (1, 1, INCH, ""), (4, 0, 1.0, ""), (5, 0, 10.0, ""),
    (7, 1, 1e6, ""), (21, 1, 304.8006096, ""), (99, 0, INCH, "inches are taken"), (99, 1, 1.0, "mm are taken"),
])  # fmt: skip
def test_the_unit_is_that_of_the_file_or_named(tmp_path, units, measurement, mm, named):
    path = saved(tmp_path, lambda document, space: space.add_lwpolyline([(0, 0), (0.3, 0), (0.3, 0.2)]), units, measurement=measurement)
    lines, page = lines_mm(path)
    assert size_mm(lines) == pytest.approx((0.3 * mm, 0.2 * mm)) and [named in note for note in page.notes] == [True] * bool(named)


@pytest.mark.parametrize("header, mm", [("9\n$MEASUREMENT\n70\n0\n", INCH), ("9\n$MEASUREMENT\n70\n1\n", 1.0), ("", 1.0), (None, 1.0)])
def test_the_unit_of_files_of_release_12(tmp_path, header, mm):
    """KiCad writes no $INSUNITS, OpenSCAD no header at all."""
    head = "" if header is None else f"0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n{header}0\nENDSEC\n"
    path = tmp_path / "a.dxf"
    path.write_text(f"{head}0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n0\n20\n0\n11\n2\n21\n1\n0\nENDSEC\n0\nEOF\n")
    plan = drawing.load(path, boards.load("plotter_2014"))
    assert plan.box_mm[2] - plan.box_mm[0] == pytest.approx(2 * mm)
    assert sum("names no unit" in note for note in plan.notes) == 1


# --- layers, cut files, curves of no angle


def test_a_block_on_a_frozen_layer_is_not_drawn_and_one_on_a_layer_that_is_off_in_part(tmp_path):
    def draw(document, space, state):
        getattr(document.layers.add("HIDDEN"), state)()
        document.layers.add("SHOWN")
        inner, outer = document.blocks.new("I"), document.blocks.new("O")
        inner.add_line((0, 0), (7, 0), dxfattribs={"layer": "0"})
        inner.add_line((0, 5), (7, 5), dxfattribs={"layer": "SHOWN"})
        outer.add_blockref("I", (0, 0), dxfattribs={"layer": "0"})
        outer.add_line((0, 9), (7, 9), dxfattribs={"layer": "SHOWN"})
        space.add_blockref("O", (0, 0), dxfattribs={"layer": "HIDDEN", "row_count": 2, "row_spacing": 20})
        space.add_blockref("I", (0, 60), dxfattribs={"layer": "hidden"})
        space.add_line((0, 50), (7, 50))

    for state, heights in (("freeze", [50]), ("off", [5, 9, 25, 29, 50, 65])):
        lines, page = lines_mm(saved(tmp_path, lambda document, space, state=state: draw(document, space, state)))
        lowest = min(heights)
        assert sorted(round(line[0].imag) + lowest for line in lines) == heights and not page.left_out


@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
@pytest.mark.parametrize("section", ["HEADER", "BLOCKS", "ENTITIES", "OBJECTS"])
def test_a_file_that_ends_amid_a_section_is_cut_off(tmp_path, section, line_end):
    def draw(document, space):
        document.blocks.new("B").add_line((0, 0), (1, 1))
        for x in range(40):
            space.add_line((x, 0), (x, 9))

    path = saved(tmp_path, draw)
    lines = path.read_text().splitlines()
    begin = next(index for index, line in enumerate(lines) if line.strip() == section and lines[index - 2].strip() == "SECTION")
    end = next(index for index, line in enumerate(lines) if index > begin and line.strip() == "ENDSEC")
    for at in (begin + 2, (begin + end) // 2, end - 1):
        path.write_bytes(line_end.join(lines[:at]).encode())
        with pytest.raises(Failure, match=f"cut off: it ends amid its section {section}"):
            sources.open_drawing(path)


def test_a_file_without_its_last_lines_is_drawn(tmp_path):
    path = tmp_path / "a.dxf"
    whole = "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n0\n20\n0\n11\n2\n21\n1\n0\nENDSEC\n"
    for text in (whole, whole + "0\nEOF"):
        path.write_text(text)
        assert len(lines_mm(path)[0]) == 1


def test_a_binary_file_that_is_cut_off_is_refused(tmp_path):
    document = ezdxf.new("R2000", units=4)
    for x in range(300):
        document.modelspace().add_line((x, 0), (x, 9))
    path = tmp_path / "a.dxf"
    document.saveas(path, fmt="bin")
    data = path.read_bytes()
    amid = data.index(b"ENTITIES") + 2000
    path.write_bytes(data[:amid])
    with pytest.raises(Failure, match="cut off"):
        sources.open_drawing(path)


def test_curves_that_leave_no_ink_are_named(tmp_path):
    def draw(document, space):
        space.add_arc((50, 50), 10, 30, 30)
        space.add_ellipse((50, 50), (10, 0), 0.5, 1, 1)
        space.add_circle((50, 50), 0)
        space.add_xline((0, 0), (1, 0))
        space.add_ray((0, 0), (1, 0))
        for begin, end in ((0, 360), (360, 720), (-90, 270)):
            space.add_arc((50, 50), 10, begin, end)
        space.add_ellipse((50, 50), (10, 0), 0.5, -math.pi, math.pi)

    lines, page = lines_mm(saved(tmp_path, draw))
    assert page.left_out == {
        "arc or ellipse of no angle": 2, "circle or curve without a size": 1, "construction line without an end (XLINE, RAY)": 2,
    }  # fmt: skip
    assert len(lines) == 4 and all(size_mm([line])[0] == pytest.approx(20, abs=0.02) for line in lines)


# --- the page


def curves(document, space):
    space.add_lwpolyline([(0, 0, 0, 0, 2), (10, 0, 0, 0, -2), (20, 0), (30, 0, 0, 0, 1)], close=True)
    space.add_spline([(0, 0), (10, 13), (20, -4), (33, 10)])
    block = document.blocks.new("B")
    block.add_ellipse((0, 0), (8, 2), 0.4, 0, 2)
    space.add_blockref("B", (50, 50), dxfattribs={"rotation": 67, "xscale": -2, "yscale": 2})


@pytest.mark.parametrize("options", [Options(crop=False), Options(crop=False, scale=2.5), Options(crop=False, fit=True, margin=0.0), Options(tolerance=0.01, crop=False)],
                         ids=["as it is", "scaled", "fit", "fine"])  # fmt: skip
def test_the_page_holds_all_that_is_drawn(tmp_path, options):
    """The page came from coarser points: 0.05 mm of a curve lay beyond it, and --no-crop refused the drawing."""
    path = saved(tmp_path, curves)
    for board in ("plotter_2014", "router_3axis"):
        machine = boards.load(board)
        plan = drawing.load(path, machine, options)
        table = placement.table_mm(machine)
        assert plan.box_mm[0] >= -1e-6 and plan.box_mm[1] >= -1e-6
        assert plan.box_mm[2] <= table[0] + 1e-6 and plan.box_mm[3] <= table[1] + 1e-6
        for deviation in (0.5, 0.02, 0.001):
            page = sources.open_drawing(path).outlines(deviation)
            assert box_of(page.layers.values()) == pytest.approx((0, 0, *page.size_px), abs=1e-6)


def test_cropping_a_dxf_cuts_nothing_off(tmp_path):
    path = saved(tmp_path, curves)
    whole, cropped = (drawing.load(path, boards.load("router_3axis"), Options(crop=crop, scale=2.5)) for crop in (False, True))
    assert whole.objects(1000) == cropped.objects(1000) and not cropped.notes


# --- bounds


def grid(document, space):
    document.blocks.new("B").add_circle((0, 0), 1)
    space.add_blockref("B", (0, 0), dxfattribs={"row_count": 30000, "column_count": 30000, "row_spacing": 1, "column_spacing": 1})


def nested(document, space):
    document.blocks.new("B0").add_circle((0, 0), 2)
    for depth in range(1, 12):
        for x in range(10):
            document.blocks.get(f"B{depth}", document.blocks.new(f"B{depth}") if x == 0 else None).add_blockref(f"B{depth - 1}", (x, depth))
    space.add_blockref("B11", (0, 0))


def long_text_in_a_grid(document, space):
    document.blocks.new("B").add_text("Passo" * 1000)
    space.add_blockref("B", (0, 0), dxfattribs={"row_count": 10, "column_count": 10, "row_spacing": 1, "column_spacing": 1})


@pytest.mark.parametrize("draw", [grid, nested, long_text_in_a_grid])
def test_blocks_that_multiply_are_refused_at_once(tmp_path, draw):
    path = saved(tmp_path, draw)
    begun = time.process_time()
    with pytest.raises(Failure, match="block B.*more entities than can be drawn"):
        sources.open_drawing(path)
    assert time.process_time() - begun < 2


def long_text(document, space):
    space.add_text("Passo " * 20000)
    space.add_mtext("Passo " * 20000)
    space.add_line((0, 0), (9, 9))


def fine_hatch(document, space):
    hatch = space.add_hatch()
    hatch.set_pattern_fill("ANSI31", scale=0.0001)
    hatch.paths.add_polyline_path([(0, 0), (100, 0), (100, 100), (0, 100)], is_closed=True)


@pytest.mark.parametrize("draw, left_out", [
    (long_text, {"text of more than 10000 letters": 2}), (fine_hatch, {"hatch of lines too near to each other (the edge of its area is drawn)": 1}),
])  # fmt: skip
def test_long_labels_and_fine_hatches_are_named(tmp_path, draw, left_out):
    path = saved(tmp_path, draw)
    begun = time.process_time()
    lines, page = lines_mm(path)
    assert time.process_time() - begun < 4 and page.left_out == left_out and len(lines) == 1


def test_an_array_of_a_thousand_is_drawn(tmp_path):
    def draw(document, space):
        document.blocks.new("B").add_circle((0, 0), 1)
        space.add_blockref("B", (0, 0), dxfattribs={"row_count": 40, "column_count": 25, "row_spacing": 3, "column_spacing": 3})

    assert len(lines_mm(saved(tmp_path, draw))[0]) == 1000


def test_bodies_are_no_frames(tmp_path):
    """A polyface has flags of its own: 64 and 128."""
    lines, _ = lines_mm(saved(tmp_path, lambda document, space: cube().render_polyface(space)))
    assert size_mm(lines) == pytest.approx((1, 1))


@pytest.mark.parametrize("font, named", [("arial.ttf", True), ("txt", True), ("DejaVuSans.ttf", False)])
@pytest.mark.parametrize("kind", ["text", "mtext", "text of a block"])
def test_the_stand_in_of_a_font_is_named(tmp_path, font, named, kind):
    def draw(document, space):
        document.styles.add("S", font=font)
        if kind == "mtext":
            space.add_mtext("Passo", dxfattribs={"style": "S", "char_height": 5})
            return
        target = space if kind == "text" else document.blocks.new("B")
        target.add_text("Passo", dxfattribs={"style": "S", "height": 5})
        if kind != "text":
            space.add_blockref("B", (0, 0))

    if not named and not ezdxf.fonts.fonts.font_manager.has_font(font):
        pytest.skip("DejaVu Sans is not installed")
    lines, page = lines_mm(saved(tmp_path, draw))
    assert len(lines) >= 5 and [each.startswith(f"the font {font}, which is not on this computer (") for each in page.left_out] == [True] * named

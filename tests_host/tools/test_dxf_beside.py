"""Constructs of DXF beside ezdxf's own drawing add-on, which makes SVG of them: each has the same lines, or the table has the reason."""

import io
import logging
import math

import pytest
from test_draw_oracles import agreement, samples

from host_tools.drawings import sources
from host_tools.drawings.placement import box_of
from host_tools.drawings.svg_file import SvgFile

ezdxf = pytest.importorskip("ezdxf")
VERSIONS = ("R12", "R2000", "R2004", "R2007", "R2010", "R2013", "R2018")


def shapes_of_any_version(document, space):
    space.add_circle((20, 20), 8)
    space.add_arc((40, 20), 8, 30, 200)
    space.add_polyline2d([(5, 5, 0, 0, 1), (20, 5, 0, 0, -0.5), (30, 15, 0, 0, 0.3)], format="xyseb", close=True)


def bulges(document, space):
    space.add_lwpolyline([(5, 5, 0, 0, 1), (20, 5, 0, 0, -0.5), (30, 15, 0, 0, 2.5), (40, 5, 0, 0, 0)], close=True)


def rational_splines(document, space):
    space.add_rational_spline([(5, 5), (5, 25), (25, 25), (40, 5)], [1, 0.707, 3, 1])
    side = math.sqrt(0.5)
    round_ = [(30, 10), (40, 10), (40, 20), (40, 30), (30, 30), (20, 30), (20, 20), (20, 10), (30, 10)]
    space.add_rational_spline(round_, [1, side, 1, side, 1, side, 1, side, 1], degree=2, knots=[0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4])
    for degree in (2, 5):
        space.add_open_spline([(5, 5), (5, 25), (25, 25), (40, 5), (50, 30), (55, 5), (20, 3)], degree=degree)


def splines_by_places(document, space):
    space.add_spline([(5, 5), (20, 30), (40, 5)])
    space.add_spline([(5, 5), (20, 30), (40, 5), (5, 5)])


def nested(document, change):
    change(document.layers.add("F"))
    block = document.blocks.new("I", base_point=(2, 1))
    block.add_circle((10, 10), 5, dxfattribs={"layer": "F"})
    block.add_circle((30, 10), 5, dxfattribs={"layer": "0"})
    document.blocks.new("O").add_blockref("I", (0, 0), dxfattribs={"rotation": 20})
    document.modelspace().add_blockref("O", (5, 3), dxfattribs={"xscale": 1.2, "yscale": 0.8})


def blocks_with_a_frozen_layer(document, space):
    nested(document, lambda layer: layer.freeze())


def blocks_with_a_layer_that_is_off(document, space):
    nested(document, lambda layer: layer.off())


def an_insert_on_a_frozen_layer(document, space):
    document.layers.add("F").freeze()
    document.blocks.new("I").add_circle((30, 10), 5, dxfattribs={"layer": "G"})
    space.add_blockref("I", (0, 0), dxfattribs={"layer": "F"})


def invisible_entities(document, space):
    space.add_circle((20, 20), 8, dxfattribs={"invisible": 1})
    document.layout("Layout1").add_circle((5, 5), 4)


def arrays(document, space):
    document.blocks.new("I").add_line((0, 0), (3, 1))
    space.add_blockref("I", (10, 5), dxfattribs={"row_count": 3, "column_count": 2, "row_spacing": 8, "column_spacing": 10, "rotation": 15})


def planes_of_their_own(document, space):
    space.add_lwpolyline([(-5, 5, 0, 0, 1), (-20, 5)], dxfattribs={"extrusion": (0, 0, -1)})
    space.add_ellipse((40, 20), (10, 0, 0), 0.5, 0, 3, dxfattribs={"extrusion": (0, 0, -1)})
    document.blocks.new("I").add_arc((0, 0), 5, 0, 90)
    space.add_blockref("I", (-30, 20), dxfattribs={"extrusion": (0, 0, -1)})
    space.add_line((5, 5, 50), (30, 30, -20))


def arcs_and_ellipses(document, space):
    space.add_arc((20, 20), 8, 350, 20)
    space.add_arc((40, 20), 8, -30, 400)
    space.add_ellipse((30, 20), (10, 5, 0), 0.4, 5, 1.2)
    space.add_ellipse((10, 20), (0, 8, 0), 0.3, math.pi, 2 * math.pi)


def hatches(document, space):
    for number, pattern in enumerate((None, "ANSI31")):
        hatch = space.add_hatch(color=1)
        if pattern:
            hatch.set_pattern_fill(pattern, scale=0.5)
        hatch.paths.add_polyline_path([(5 + 27 * number, 5), (30 + 27 * number, 5), (30 + 27 * number, 30)], is_closed=True)


def widths_and_line_types(document, space):
    space.add_lwpolyline([(5, 5, 2, 2), (40, 5, 2, 4), (40, 30, 1, 1)])
    space.add_line((5, 35), (55, 35), dxfattribs={"linetype": "DASHED"})


def faces_and_meshes(document, space):
    space.add_solid([(5, 5), (20, 5), (5, 20), (20, 20)])
    space.add_3dface([(25, 5), (40, 5), (40, 20), (25, 20)])
    space.add_polymesh((3, 3))
    space.add_mline([(5, 25), (30, 30), (50, 25)])


def dimensions(document, space):
    space.add_linear_dim(base=(0, -10), p1=(0, 0), p2=(60, 0)).render()
    space.add_leader([(5, 5), (20, 20), (30, 20)])


def lines_without_an_end(document, space):
    space.add_ray((5, 5), (1, 0))


def a_periodic_spline(document, space):
    frame = [(20, 20, 0), (40, 20, 0), (40, 35, 0), (20, 35, 0)]
    spline = space.add_spline()
    spline.dxf.degree, spline.dxf.flags = 3, 3
    spline.control_points, spline.knots = [*frame, *frame[:3]], list(range(11))


def a_wipeout(document, space):
    space.add_line((5, 20), (55, 20))
    space.add_wipeout([(20, 10), (40, 30)])


CONSTRUCTS = (
    bulges, rational_splines, splines_by_places, blocks_with_a_frozen_layer, blocks_with_a_layer_that_is_off, an_insert_on_a_frozen_layer, invisible_entities, arrays,
    planes_of_their_own, arcs_and_ellipses, hatches, widths_and_line_types, faces_and_meshes, dimensions, lines_without_an_end, a_periodic_spline, a_wipeout,
)  # fmt: skip
OTHERWISE = {
    an_insert_on_a_frozen_layer: "ezdxf draws what is in the block; CAD programs do not",
    lines_without_an_end: "ezdxf draws 20 units of them; they are named",
    a_periodic_spline: "ezdxf draws the whole knot vector, far outside the curve",
    a_wipeout: "black on black in ezdxf's picture; here it covers what was drawn before",
}


def written(folder, build, version):
    document = ezdxf.new(version, setup=True, units=4)
    space = document.modelspace()
    space.add_polyline2d([(0, 0), (60, 0), (60, 40), (0, 40)], close=True)
    build(document, space)
    path = folder / "a.dxf"
    document.saveas(path)
    return path


def drawn_by_ezdxf(path, folder):
    """Its lines, in px of a page 380 mm wide."""
    from ezdxf.addons.drawing import Frontend, RenderContext, config, layout, svg

    document, _ = ezdxf.recover.read(io.BytesIO(path.read_bytes()))
    backend = svg.SVGBackend()
    choice = config.Configuration(background_policy=config.BackgroundPolicy.WHITE, color_policy=config.ColorPolicy.BLACK, max_flattening_distance=0.005)
    Frontend(RenderContext(document), backend, config=choice).draw_layout(document.modelspace())
    picture = folder / "a.svg"
    picture.write_text(backend.get_string(layout.Page(0, 0, layout.Units.mm, max_width=380, max_height=380), settings=layout.Settings(scale=1, fit_page=True)))
    return [line for lines in SvgFile(picture).outlines(0.002).layers.values() for line in lines]


def compare(path, folder):
    """(share of ezdxf's lines on ours, of ours on ezdxf's, our Page), box laid on box."""
    from ezdxf import recover  # noqa: F401  that ezdxf.recover is there

    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
    page = sources.open_drawing(path).outlines(0.01)
    lines, theirs = [line for lines in page.layers.values() for line in lines], drawn_by_ezdxf(path, folder)
    here, there = box_of([lines]), box_of([theirs])
    scale = (there[2] - there[0]) / (here[2] - here[0])
    ours = [(line.real - here[0]) * scale + there[0] + 1j * ((line.imag - here[1]) * scale + there[1]) for line in lines]
    return *agreement(samples(theirs, 1.0), ours, 1.5), page


@pytest.mark.parametrize("build", CONSTRUCTS)
def test_constructs_beside_ezdxf(tmp_path, build):
    *shares, page = compare(written(tmp_path, build, "R2010"), tmp_path)
    if build in OTHERWISE:
        assert min(shares) < 0.99
    else:
        assert min(shares) > 0.99 and not set(page.left_out) - {name for name in page.left_out if "font" in name}


@pytest.mark.parametrize("version", VERSIONS)
def test_versions_beside_ezdxf(tmp_path, version):
    *shares, page = compare(written(tmp_path, shapes_of_any_version, version), tmp_path)
    assert min(shares) > 0.99 and page.size_px == pytest.approx((60 * 96 / 25.4, 42.5 * 96 / 25.4), abs=9) and not page.left_out


@pytest.mark.parametrize("unit, mm", [(1, 25.4), (2, 304.8), (4, 1), (5, 10), (6, 1000), (9, 0.0254), (10, 914.4), (14, 100), (21, 1200 / 3937 * 1000)])
def test_units_of_a_file(tmp_path, unit, mm):
    document = ezdxf.new("R2010", units=unit)
    document.modelspace().add_line((0, 0), (30, 40))
    path = tmp_path / "a.dxf"
    document.saveas(path)
    page = sources.open_drawing(path).outlines(0.01)
    assert page.size_px == pytest.approx((30 * mm * 96 / 25.4, 40 * mm * 96 / 25.4), rel=1e-4) and not page.notes

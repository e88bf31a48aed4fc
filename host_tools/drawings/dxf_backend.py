"""ezdxf's drawing add-on draws by this Frontend into this Backend: lines and areas, by layer, in the file's units, y up."""

from collections import Counter

import numpy
import shapely
from ezdxf.addons.drawing import Frontend as BaseFrontend
from ezdxf.addons.drawing import RenderContext
from ezdxf.addons.drawing.backend import Backend as Base
from ezdxf.addons.drawing.config import Configuration
from ezdxf.entities import Insert
from ezdxf.fonts import fonts
from ezdxf.render.hatching import DenseHatchingLinesError

from host_tools.drawings import svg_area
from host_tools.drawings.page import LONGEST_TEXT, TOO_LONG, Ink
from host_tools.language import N_, _


class Frontend(BaseFrontend):
    def __init__(self, document, backend, config):
        super().__init__(RenderContext(document), backend, config=config)
        self._styles = document.styles
        self._frozen = {layer.dxf.name.lower() for layer in document.layers if layer.is_frozen()}

    def skip_entity(self, entity, msg):
        """Name what is not drawn, bodies of ACIS for one; ezdxf only logs it."""
        if msg != "invisible":
            self.pipeline.backend.left_out[entity.dxftype()] += 1

    def draw_image_entity(self, entity, properties):
        """Name a picture, and draw its frame, by ImagePolicy.RECT: else ezdxf writes the name of a file that it does not find."""
        self.pipeline.backend.left_out[N_("picture")] += 1
        super().draw_image_entity(entity, properties)

    def draw_composite_entity(self, entity, properties):
        """Leave out a block on a frozen layer with all that is in it, as CAD programs do; on a layer that is off its other layers are shown."""
        if not (isinstance(entity, Insert) and properties.layer.lower() in self._frozen):
            super().draw_composite_entity(entity, properties)

    def draw_text_entity(self, entity, properties):
        self._draw_text(super().draw_text_entity, entity, properties)

    def draw_mtext_entity(self, entity, properties):
        self._draw_text(super().draw_mtext_entity, entity, properties)

    def _draw_text(self, draw, entity, properties):
        """Draw a text by ezdxf's `draw`, and name a font that stands in; a text of more than LONGEST_TEXT letters is left out and counted."""
        if len(entity.dxf.get("text", "")) > LONGEST_TEXT:
            self.pipeline.backend.left_out[TOO_LONG] += 1
        else:
            self._name_stand_in(entity, properties)
            draw(entity, properties)

    def _name_stand_in(self, entity, properties):
        """Name a text style's font that this computer has not: ezdxf takes another silently."""
        name = entity.dxf.get("style", "Standard")
        wanted = self._styles.get(name).dxf.font if self._styles.has_entry(name) else ""
        if wanted and not fonts.font_manager.has_font(wanted):
            face = fonts.font_manager.get_font_face(fonts.font_manager.find_font_name(self.get_font_face(properties)))
            self.pipeline.backend.left_out[_("the font {}, which is not on this computer ({} is drawn)", wanted, face.family)] = 1

    def draw_hatch_pattern(self, polygon, paths, properties):
        """Name a pattern whose lines are too near to each other: ezdxf takes its area instead."""
        try:
            super().draw_hatch_pattern(polygon, paths, properties)
        except DenseHatchingLinesError:
            self.pipeline.backend.left_out[N_("hatch of lines too near to each other (the edge of its area is drawn)")] += 1
            raise

    def draw_line_entity(self, entity, properties):
        """Name lines without an end: ezdxf would draw 20 units of them."""
        if entity.dxftype() == "LINE":
            super().draw_line_entity(entity, properties)
        else:
            self.pipeline.backend.left_out[N_("construction line without an end (XLINE, RAY)")] += 1

    def draw_curve_entity(self, entity, properties):
        """Name a curve that leaves no ink."""
        backend = self.pipeline.backend
        before = backend.count
        super().draw_curve_entity(entity, properties)
        if backend.count == before:
            kind = entity.dxftype()
            without_angle = kind == "ELLIPSE" or kind == "ARC" and entity.dxf.radius
            backend.left_out[N_("arc or ellipse of no angle") if without_angle else N_("circle or curve without a size")] += 1


class Backend(Base):
    """`inks`: {name of a layer: [Ink]}."""

    def __init__(self, deviation, fills):
        super().__init__()
        self._deviation, self._fills = deviation, fills
        self.inks = {}
        self.count = 0  # of the lines drawn
        self.left_out = Counter()
        self._background = None

    def _add_ink(self, properties, lines, areas=()):
        """Add lines and areas, in the file's units, to the inks of a layer. Lines of one point are dropped; lines with a number that is not finite go
        to `left_out`."""
        given = [line for line in lines if len(line) > 1]
        lines = [line for line in given if numpy.isfinite(line).all()]
        self.count += len(given) + len(areas)
        if len(lines) < len(given):
            self.left_out[N_("number that is none, or that cannot be read")] += len(given) - len(lines)
        if lines or areas:
            self.inks.setdefault(properties.layer, []).append(Ink(properties.color[:7], lines, list(areas)))

    def _add_area(self, lines, rule, properties):
        """Add closed `lines` and the area that they enclose. In the background's colour (a wipeout) they cover everything drawn before."""
        if properties.color != self._background:
            self._add_ink(properties, lines, [svg_area.fill_area(lines, rule)] if self._fills and lines else ())
        elif lines:
            covered = svg_area.fill_area(lines, rule)
            for ink in (ink for inks in self.inks.values() for ink in inks):
                ink.lines = svg_area.subtract_area(ink.lines, covered)
                ink.areas = [shapely.difference(area, covered) for area in ink.areas]

    def _flatten_path(self, path):
        """Return the polylines of a path, which may have several parts."""
        lines = []
        for part in path.to_path().sub_paths() if hasattr(path, "to_path") else path.sub_paths():
            line = numpy.array([complex(place.x, place.y) for place in part.flattening(self._deviation)])
            if len(line):
                lines.append(line)
        return lines

    # --- called by the add-on; those that pass have nothing to do here

    def draw_point(self, pos, properties):
        self._add_ink(properties, [numpy.array([complex(pos.x, pos.y)] * 2)])

    def draw_line(self, start, end, properties):
        self._add_ink(properties, [numpy.array([complex(start.x, start.y), complex(end.x, end.y)])])

    def draw_solid_lines(self, lines, properties):
        self._add_ink(properties, [numpy.array([complex(a.x, a.y), complex(b.x, b.y)]) for a, b in lines])

    def draw_path(self, path, properties):
        self._add_ink(properties, self._flatten_path(path))

    def draw_filled_paths(self, paths, properties):
        lines = [line for path in paths for line in self._flatten_path(path)]
        lines = [line if line[0] == line[-1] else numpy.append(line, line[0]) for line in lines]
        self._add_area(lines, "evenodd", properties)

    def draw_filled_polygon(self, points, properties):
        line = numpy.array([complex(place.x, place.y) for place in points.vertices()])
        self._add_area([numpy.append(line, line[0])], "nonzero", properties)

    def draw_image(self, image_data, properties):
        pass

    def set_background(self, color):
        self._background = color

    def clear(self):
        self.inks = {}

    def finalize(self):
        pass

    def configure(self, config: Configuration):
        pass

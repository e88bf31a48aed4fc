"""Pictures to rows of laser power, and rows to G-code.

    options = Options(width_mm=60, dots_mm=10, shade="jarvis")
    powers = powers_of(open_picture("photo.jpg"), options)      # numpy, 0 to 1, the lowest row first
    lines = gcode_lines(rows_of(powers, options, machine), options, machine)

A row runs along X at one speed. The head reaches that speed before the first dot and slows down behind the last one: the length of that,
the overscan, is computed from speed and acceleration. Dots of one power side by side are one line. Blank rows are left out, and long
blank stretches of a row are passed at rapid. On a machine that takes rows of dots several dots are one line, `X1.6S0:250:1000`; packed
`X1.6S=@@GZ_H`, which goes in frames.

Error diffusion: R. W. Floyd and L. Steinberg, "An adaptive algorithm for spatial grey scale", 1976; J. F. Jarvis, C. N. Judice and
W. H. Ninke, "A survey of techniques for the display of continuous tone pictures on bilevel displays", 1976.
"""

import math
import re
from array import array
from dataclasses import dataclass
from functools import partial

import numpy as np
from PIL import Image, ImageDraw, ImageFont, ImageOps, UnidentifiedImageError

from host_tools.build.pc_kernels import kernels_of
from host_tools.drawings import dither_viper
from host_tools.failure import Failure, reason
from host_tools.programs import file_kinds
from host_tools.programs.gcode_file import refuse_others_at
from host_tools.programs import toolpath
from host_tools.programs.gcode_time import Limits, settings_of

SHADES = ("jarvis", "floyd", "threshold", "grey")
MOST_DOTS = 40_000_000
MOST_PIXELS = 20_000_000  # of a picture as it is read: up to 5 bytes each
Image.MAX_IMAGE_PIXELS = None  # pillow's own bound: it would refuse a large JPEG, too, and without a word of what to do
_BAND = 256  # rows of a picture at once
number = partial(toolpath.number_text, decimals=3)
# How a dot's error is shared, in parts of the first number: (dx, dy, parts)
_FLOYD = 16, ((1, 0, 7), (-1, 1, 3), (0, 1, 5), (1, 1, 1))
_JARVIS = 48, (
    (1, 0, 7), (2, 0, 5), (-2, 1, 3), (-1, 1, 5), (0, 1, 7), (1, 1, 5), (2, 1, 3), (-2, 2, 1), (-1, 2, 3), (0, 2, 5), (1, 2, 3), (2, 2, 1),
)  # fmt: skip
_SAVED_S = 0.01  # a rapid move amid a row saves at least this time
LINES_S = 1700  # dots a second over USB, if the PC answers after 1 ms: docs/reference/benchmarks.md
DOTS_S = 5000  # the same in rows
PACKED_S = 10_000  # and in packed ones
CLUSTER = 16  # dots of a line, if no machine says it
PACKED = 100  # the same of a packed row
_ROW_CHARACTERS = 100  # of a line's dots: it may have 127, with its other words
CARD_PATCHES = 11  # 0, 10 … 100 % of the power


@dataclass
class Options:
    """How a picture is burnt. Lengths in mm."""

    width_mm: float | None = None  # of the picture; the other side follows
    height_mm: float | None = None
    dots_mm: float = 10.0  # along the rows and across them
    shade: str = "jarvis"
    threshold: float = 0.5  # darkness from which a dot burns, for shade threshold
    greys: int = 64  # powers told apart, for shade grey
    black: float = 0.0  # brightness, 0 to 1, that counts as black
    white: float = 1.0
    gamma: float = 1.0  # above 1: middle tones get lighter
    invert: bool = False
    curve: tuple = ()  # (power, darkness), each 0 to 1, of a test card
    power: float = 0.2  # of the darkest dots, part of full power
    least: float = 0.0  # of the lightest dots that burn
    speed: float = 3000.0  # mm/min
    one_way: bool = False
    offset_mm: float = 0.0  # added to X of rows from right to left
    overscan_mm: float | None = None
    origin: tuple[float, float] = (0.0, 0.0)  # of the lower left corner
    passes: int = 1
    constant: bool = False  # M3 instead of M4
    air: bool = False
    frame: float | None = None  # power of a frame around everything, before it burns


@dataclass
class Machine:
    """A laser: limits of its axes, and S of full power."""

    limits: Limits
    full: float
    cluster: int = 0  # dots that a line may have; 0: one power a line
    packed: bool = False  # two characters a dot

    @classmethod
    def of_board(cls, board, name):
        """Make a Machine of a board file's dict. Raises Failure if it is no laser's."""
        spindle = board.get("spindle") or {}
        if not spindle.get("laser"):
            raise Failure("{} is no laser: passo engrave wants a board file with \"laser\": True, as laser_xy has", name)
        return cls(Limits.of_board(board), spindle["max_rpm"])

    @classmethod
    def of_settings(cls, answer):
        """Make a Machine of the answer to $$. Raises Failure if the machine is not in laser mode ($32=1)."""
        found = settings_of(answer)
        if not found.get(32):
            raise Failure("set $32=1: without laser mode the machine stands at each dot with the beam on")
        return cls(Limits.of_settings(answer), found[30])

    def takes_rows(self, answer, packed=False):
        """True if the answer to $I says that rows of dots are accepted. Sets `cluster` to the dots that a line may have."""
        found = re.search(rf"\[{'PACKED' if packed else 'CLUSTER'}:(\d+)\]", "\n".join(answer))
        self.cluster, self.packed = int(found[1]) if found else 0, packed
        return self.cluster > 0

    @property
    def speed(self):
        """The highest speed of X, along the rows, in mm/min."""
        return self.limits.speeds[0] * 60

    @property
    def acceleration(self):
        """The acceleration of X, in mm/s²."""
        return self.limits.accelerations[0]


@dataclass
class Row:
    """A row's height, and its runs in the order in which they are burnt. Run n lies between `cuts` n and n + 1, in dots, `left` is where dot 0
    begins, and `powers` has the power of each, 0 to 1. Arrays: a tuple of floats a run would be ten times as much memory."""

    y: float
    backward: bool
    left: float
    pitch: float
    cuts: object
    powers: object

    @property
    def begin(self):
        """The start of the first run, in mm."""
        return self.left + int(self.cuts[0]) * self.pitch

    @property
    def end(self):
        return self.left + int(self.cuts[-1]) * self.pitch

    @property
    def runs(self):
        """The runs as [(begin, end, power)], in mm."""
        places = [self.left + cut * self.pitch for cut in self.cuts.tolist()]
        return list(zip(places, places[1:], self.powers.tolist()))


def open_picture(path):
    """Open a picture in grey, transparent parts white, turned as its camera says. Raises Failure."""
    try:
        with Image.open(path) as picture:
            _check_pixels(picture, path)
            ImageOps.exif_transpose(picture, in_place=True)
            if picture.mode in ("I", "I;16", "I;16B", "F"):
                return _of_numbers(picture)
            if not picture.has_transparency_data:
                return picture.convert("L")
            grey = Image.new("L", picture.size, "white")
            for part in _row_bands(picture):
                colours = picture.crop(part).convert("RGBA")
                grey.paste(colours.convert("L"), part, colours.getchannel("A"))
            return grey
    except FileNotFoundError:
        raise Failure("there is no file {}", path) from None
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError) as error:
        refuse_others_at(path, (file_kinds.PICTURE,))
        raise Failure("{} cannot be read as a picture: {}", path, reason(error)) from None


def _row_bands(picture):
    """Yield boxes of rows, from above. Work goes band by band, because a copy of the whole in another mode takes as much memory as the picture."""
    for top in range(0, picture.height, _BAND):
        yield 0, top, picture.width, min(top + _BAND, picture.height)


def _of_numbers(picture):
    """Return a grey picture of one whose values have more than 8 bits, scaled from its least to its largest value."""
    low, high = picture.getextrema()
    grey = Image.new("L", picture.size)
    for part in _row_bands(picture):
        values = np.asarray(picture.crop(part), np.float64)
        grey.paste(Image.fromarray(((values - low) / max(1e-9, high - low) * 255).astype(np.uint8)), part)
    return grey


def _check_pixels(picture, path):
    """Take a JPEG of too many pixels at a half, a quarter or an eighth of its size, as it is read; raise Failure of any other."""
    pixels = picture.width * picture.height
    if pixels > MOST_PIXELS:
        part = next((each for each in (2, 4) if pixels <= MOST_PIXELS * each**2), 8)
        picture.draft("L", (picture.width // part, picture.height // part))
    if picture.width * picture.height > MOST_PIXELS:
        raise Failure("{} has {} × {} pixels: at most {} in all; make it smaller in a drawing program", path, picture.width, picture.height, MOST_PIXELS)


def size_of(picture, options):
    """Return (dots across, dots up). Raises Failure if the size is missing, or there are too many dots."""
    across, up = picture.size
    if options.width_mm is None and options.height_mm is None:
        raise Failure("how large? give --width or --height in mm")
    if options.width_mm is not None and options.height_mm is not None:
        width, height = options.width_mm, options.height_mm
    elif options.width_mm is not None:
        width, height = options.width_mm, options.width_mm * up / across
    else:
        width, height = options.height_mm * across / up, options.height_mm
    dots = max(1, round(width * options.dots_mm)), max(1, round(height * options.dots_mm))
    if dots[0] * dots[1] > MOST_DOTS:
        raise Failure("{} × {} dots are too many: at most {} in all; give a smaller size or fewer --dots", *dots, MOST_DOTS)
    return dots


def powers_of(picture, options, progress=None):
    """Return the power of each dot, 0 to 1 of the laser's full power, as an array of rows, the lowest first. Raises Failure."""
    small = picture.resize(size_of(picture, options), Image.Resampling.LANCZOS)
    light = np.asarray(small, np.float64)[::-1] / 255
    if options.white <= options.black:
        raise Failure("--black is darker than --white: black {:g}, white {:g}", options.black, options.white)
    light = np.clip((light - options.black) / (options.white - options.black), 0, 1) ** (1 / options.gamma)
    dark = light if options.invert else 1 - light
    if options.shade == "threshold":
        dark = (dark >= options.threshold).astype(np.float64)
    elif options.shade == "floyd":
        dark = diffuse_dots(dark, *_FLOYD, progress)
    elif options.shade == "jarvis":
        dark = diffuse_dots(dark, *_JARVIS, progress)
    else:
        dark = np.round(dark * options.greys) / options.greys
    return powers_of_darkness(dark, options)


def powers_of_darkness(dark, options):
    """Turn darkness, 0 to 1, into power, 0 to 1, by the curve of a test card if there is one. White stays dark."""
    wanted = dark
    if options.curve:
        powers, found = (np.array(column) for column in zip(*sorted(options.curve)))
        found = np.maximum.accumulate(found)
        wanted = np.interp(dark * found[-1], found, powers)
    return np.where(dark > 0, options.least + wanted * (options.power - options.least), 0.0)


def diffuse_dots(dark, parts, shares, progress=None):
    """Turn `dark`, 0 to 1, into dots, 1 or 0, of the same mean: each dot's error goes to its neighbours that follow (error diffusion). Rows run from
    the left and from the right in turn, so that no pattern leans."""
    height, width = dark.shape
    room, below = max(abs(dx) for dx, _, _ in shares), max(dy for _, dy, _ in shares)
    pitch = width + 2 * room
    kernels = kernels_of(dither_viper.__name__, "diffuse_row")
    numbers = array("i", [each for share in shares for each in share] + [0] * dither_viper.SHARE)
    errors, blank = array("i", bytes(4 * pitch * (below + 1))), array("i", bytes(4 * pitch))
    out = np.empty((height, width))
    for y in range(height):
        row = array("i", np.rint(dark[y] * dither_viper.ONE).astype(np.int32).tobytes())
        kernels.diffuse_row(row, errors, numbers, parts, room, width, y % 2)
        out[y] = row
        errors = errors[pitch:] + blank
        if progress:
            progress((y + 1) / height)
    return out


def overscan_length(options, machine):
    """Return the mm before and behind a row in which the head speeds up and slows down: v² / 2a, and a tenth more."""
    if options.overscan_mm is not None:
        return options.overscan_mm
    return 1.1 * (options.speed / 60) ** 2 / (2 * machine.acceleration)


def rows_of(powers, options):
    """Return the Rows that burn, from below, with runs of equal power. They run to the right and to the left in turn, unless `one_way`."""
    pitch = 1 / options.dots_mm
    left, bottom = options.origin
    rows = []
    for number, row in enumerate(powers):
        burning = np.flatnonzero(row)
        if not len(burning):
            continue
        first, last = int(burning[0]), int(burning[-1]) + 1
        cuts = np.concatenate(([first], first + 1 + np.flatnonzero(np.diff(row[first:last])), [last])).astype(np.int32)
        backward = not options.one_way and len(rows) % 2 == 1
        shift = left + (options.offset_mm if backward else 0)
        powers_of_runs = row[cuts[:-1]]
        if backward:
            cuts, powers_of_runs = cuts[::-1], powers_of_runs[::-1]
        rows.append(Row(bottom + (number + 0.5) * pitch, backward, shift, pitch, cuts, powers_of_runs))
    return rows


def bounds_mm(rows, options, machine):
    """Return left, bottom, right, top that the head reaches, overscan included, in mm. Raises Failure if nothing burns."""
    if not rows:
        raise Failure("nothing burns: the picture is white by --white, --threshold or --invert")
    over = overscan_length(options, machine)
    ends = [x for row in rows for x in (row.begin, row.end)]
    return min(ends) - over, rows[0].y, max(ends) + over, rows[-1].y


def gcode_lines(rows, options, machine):
    """Yield the lines of G-code, as text. S0 stands before all motion between dots: the laser is dark in ramps, turns and at the end."""
    left, bottom, right, top = bounds_mm(rows, options, machine)
    yield "G21 G90 G17 G94"
    yield "M5 S0"
    if options.air:
        yield "M8"
    if options.frame is not None:
        over = overscan_length(options, machine)
        corners = (left + over, bottom), (right - over, bottom), (right - over, top), (left + over, top), (left + over, bottom)
        yield f"G0 X{number(corners[0][0])} Y{number(corners[0][1])}"
        yield f"M3 S{number(options.frame * machine.full)}"
        yield f"G1 F{number(options.speed)}"
        for x, y in corners[1:]:
            yield f"G1 X{number(x)} Y{number(y)}"
        yield "M5 S0"
        yield "M0"
    yield f"{'M3' if options.constant else 'M4'} S0"
    yield f"G1 F{number(options.speed)}"
    for _ in range(options.passes):
        for row in rows:
            yield from row_lines(row, options, machine)
    yield "M5 S0"
    if options.air:
        yield "M9"
    yield "M2"


def row_lines(row, options, machine):
    """Yield the lines of G-code of one row."""
    over = overscan_length(options, machine) * (-1 if row.backward else 1)
    yield f"G0X{number(row.begin - over)}Y{number(row.y)}"
    yield f"G1X{number(row.begin)}S0"
    mode = ""
    dots = []  # powers of equally long dots up to `reached`, which will be one line

    def flush_dots():
        made = [f"{mode}X{number(reached)}S{'=' + ''.join(dots) if machine.packed else ':'.join(dots)}"] if dots else []
        dots.clear()
        return made

    for begin, end, power in row.runs:
        count = round(abs(end - begin) * options.dots_mm)
        rapid = power == 0 and is_rapid(abs(end - begin), options, machine)
        if rapid or count > machine.cluster:
            for each in flush_dots():
                yield each
                mode = ""
            yield f"G0X{number(end)}" if rapid else f"{mode}X{number(end)}S{power_word(power, machine)}"
            mode = "G1" if rapid else ""
            continue
        for dot in range(count):
            reached = begin + (end - begin) * (dot + 1) / count
            dots.append(pack_power(power) if machine.packed else power_word(power, machine))
            if len(dots) == machine.cluster or not machine.packed and len(":".join(dots)) + len(dots[-1]) >= _ROW_CHARACTERS:
                yield from flush_dots()
                mode = ""
    yield from flush_dots()
    yield f"X{number(row.end + over)}S0"


def powers_s(rows, options, machine):
    """Return (powers a second that the densest row needs, powers a second that a link carries)."""
    def count_numbers(row):
        dots = abs(np.diff(row.cuts))
        return int(np.where(dots <= machine.cluster, dots, 1).sum())

    rates = (count_numbers(row) / max(1e-9, abs(row.end - row.begin)) for row in rows)
    return max(rates) * options.speed / 60, PACKED_S if machine.packed else DOTS_S if machine.cluster else LINES_S


def is_rapid(length, options, machine):
    """True if a blank stretch of `length` mm amid a row is passed sooner at rapid, the head being at its speed at both ends."""
    speed, rapid = options.speed / 60, machine.speed / 60
    if rapid <= speed:
        return False
    peak = min(rapid, math.sqrt(speed**2 + machine.acceleration * length))
    ramps = (peak**2 - speed**2) / machine.acceleration
    return length / speed - (2 * (peak - speed) / machine.acceleration + max(0.0, length - ramps) / peak) > _SAVED_S


def pack_power(power):
    """Return the two letters of a power, 0 to 1 of full power, in a packed row."""
    value = min(1000, max(round(1000 * power), 1 if power else 0))
    return chr(64 + (value >> 5)) + chr(64 + (value & 31))


def power_word(power, machine):
    """Return the number behind S for a power, 0 to 1 of full power: whole, unless full power is below 100."""
    value = min(power, 1.0) * machine.full
    return str(round(value)) if machine.full >= 100 else number(value)


# --- the test card


def draw_card(options):
    """Draw a test card: patches of 0 to 100 % of the power, with their figures. Returns (picture, options for it). The frame is the card's edge."""
    width = options.width_mm or 90.0
    options.width_mm, options.height_mm = width, width / CARD_PATCHES * 2
    options.shade, options.greys, options.curve, options.invert = "grey", 100, (), False
    options.black, options.white, options.gamma = 0.0, 1.0, 1.0
    dots = size_of(Image.new("L", (CARD_PATCHES, 2)), options)
    picture = Image.new("L", dots, 255)
    draw = ImageDraw.Draw(picture)
    side = dots[0] / CARD_PATCHES
    font = ImageFont.load_default(max(8, side * 0.4))
    for patch in range(CARD_PATCHES):
        share = patch / (CARD_PATCHES - 1)
        box = round(patch * side), 0, round((patch + 1) * side) - 1, dots[1] // 2
        draw.rectangle(box, fill=round(255 * (1 - share)))
        draw.text(((patch + 0.5) * side, dots[1] * 0.75), f"{100 * share:.0f}", fill=127, font=font, anchor="mm")
    draw.rectangle((0, 0, dots[0] - 1, dots[1] - 1), outline=127, width=max(1, round(0.2 * options.dots_mm)))
    return picture


def read_curve(path):
    """Return (power, darkness) of each patch, 0 to 1: from a text of `POWER DARKNESS` in % a line, or from a picture of a burnt card, cut to the
    card's frame. Raises Failure."""
    if str(path).lower().endswith((".txt", ".csv")):
        return _read_curve(path)
    picture = open_picture(path)
    if not CARD_PATCHES / 2 * 0.9 < picture.width / picture.height < CARD_PATCHES / 2 * 1.1:
        raise Failure("{}: {} × {} dots are not the card's shape; cut the picture to the card's frame", path, *picture.size)
    light = np.asarray(picture, np.float64)
    side, half = picture.width / CARD_PATCHES, picture.height / 2
    rows = slice(int(half * 0.3), int(half * 0.75))
    found = [float(np.median(light[rows, int((n + 0.3) * side) : int((n + 0.7) * side)])) for n in range(CARD_PATCHES)]
    if found[0] - min(found) < 5:
        raise Failure("{}: no patch is darker than the first, which is blank", path)
    return tuple((n / (CARD_PATCHES - 1), max(0.0, (found[0] - value) / 255)) for n, value in enumerate(found))


def _read_curve(path):
    """Return ((power, darkness), …), 0 to 1, of a text file with `POWER DARKNESS` in % a line; # begins a comment. Raises Failure if it is no UTF-8,
    a line is wrong, it has fewer than two, or none is dark."""
    curve = []
    try:
        text = open(path, encoding="utf-8").read()
    except UnicodeDecodeError:
        raise Failure("{} is no text", path) from None
    for line, content in enumerate(text.splitlines(), 1):
        parts = content.partition("#")[0].replace(",", " ").replace("%", " ").split()
        if not parts:
            continue
        try:
            power, darkness = (float(part) / 100 for part in parts)
        except ValueError:
            raise Failure("{}, line {}: POWER DARKNESS in %, as in 40 65, not {!r}", path, line, content) from None
        if not (0 <= power <= 1 and 0 <= darkness <= 1):
            raise Failure("{}, line {}: 0 to 100 % are wanted, not {!r}", path, line, content)
        curve.append((power, darkness))
    if len(curve) < 2 or max(darkness for _, darkness in curve) == 0:
        raise Failure("{} has no curve: two lines at least of POWER DARKNESS in %, one of them dark", path)
    return tuple(curve)

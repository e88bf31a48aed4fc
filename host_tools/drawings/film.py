"""A film of a trace: the path as it grows, the tool, time and speed; GIF or MP4.

    trace = load_moves("job.csv")                             # a trace of passo board --trace, as arrays
    write("job.gif", trace, (10, 10), seconds=20)

Frames are drawn one on the other, so a film takes as long as its path and its frames, not their product.
"""

import csv
import math
from dataclasses import dataclass

import numpy as np

from host_tools.failure import Failure, reason
from host_tools.language import _, line_text
from host_tools.sim.trace import HEADER

SIZE = 960, 720
MOST_FRAMES = 3000
_MARGIN = 56
_PAPER, _AHEAD, _UP, _DOWN, _HEAD, _TEXT = "#ffffff", "#e4e4ea", "#9cc3e6", "#1a1a2e", "#d03030", "#404048"
_COLORS = _PAPER, _AHEAD, _UP, _DOWN, _HEAD, _TEXT


@dataclass
class Moves:
    """A trace as arrays: seconds, steps of x, y, z, a, and the tool 0 … 1000."""

    seconds: np.ndarray
    places: np.ndarray
    tool: np.ndarray


def load_moves(path):
    """Read a trace CSV as Moves. Raises Failure with the line that is wrong."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            if file.readline().strip() != HEADER:
                raise Failure("{} is not a trace: its first line should be {}", path, HEADER)
            try:
                rows = np.loadtxt(file, delimiter=",", ndmin=2)
            except ValueError as error:
                raise Failure("{}: {}: not a row of a trace", path, _first_wrong_line(path)) from error
    except OSError as error:
        raise Failure("cannot read trace {}: {}", path, reason(error)) from error
    if rows.shape[0] < 2 or rows.shape[1] != 6 or not np.isfinite(rows).all():
        raise Failure("{}: {}: nothing moves in it, or a row is none of a trace", path, _first_wrong_line(path))
    return Moves(rows[:, 0] / 1e6, rows[:, 1:5], rows[:, 5])


def _first_wrong_line(path):
    """Return the name of the first line that is no row of a trace."""
    with open(path, newline="", encoding="utf-8", errors="replace") as file:
        reader = csv.reader(file)
        next(reader, None)
        for fields in reader:
            try:
                if len(fields) != 6 or not all(math.isfinite(float(field)) for field in fields):
                    return line_text(reader.line_num)
            except ValueError:
                return line_text(reader.line_num)
    return _("its end")


def frame_times(moves, seconds, speed, per_second):
    """Return the moment of each frame, in seconds of the trace. The film lasts `seconds`, or runs `speed` times as fast as the machine. Raises
    Failure if it has too many frames."""
    first = float(moves.seconds[1])  # the first row is the state before
    span = float(moves.seconds[-1]) - first
    length = span / speed if speed else seconds
    count = max(2, round(length * per_second))
    if count > MOST_FRAMES:
        raise Failure("a film of {} frames is too long, {} at most: take a higher --speed, or fewer --seconds", count, MOST_FRAMES)
    return first + span * np.arange(count) / (count - 1)


class Painter:
    """Draws frame after frame of Moves; `scale`: steps/mm of X and Y."""

    def __init__(self, moves, scale, size=SIZE):
        from PIL import Image, ImageDraw, ImageFont

        self._moves = moves
        self._size = size
        self._mm = moves.places[:, :2] / np.array(scale)
        low, high = self._mm.min(axis=0), self._mm.max(axis=0)
        room = np.array(size) - 2 * _MARGIN
        self._zoom = float(min(room / np.maximum(high - low, 1e-6)))
        at = (self._mm - (low + high) / 2) * self._zoom * [1, -1] + np.array(size) / 2
        self._at = at
        self._drawn = 0
        self._font = ImageFont.load_default(18)
        self._sheet = Image.new("RGB", size, _PAPER)
        self._pen = ImageDraw.Draw(self._sheet)
        self._draw_line(0, len(at) - 1, _AHEAD, 1)

    def _draw_line(self, begin, end, color, width):
        """Draw from row to row; positions nearer than half a pixel are left out."""
        points = self._at[begin : end + 1]
        if len(points) > 2:
            pixels = np.round(points * 2).astype(np.int64)
            keep = np.ones(len(points), bool)
            keep[1:-1] = (pixels[1:-1] != pixels[:-2]).any(axis=1)
            points = points[keep]
        self._pen.line([tuple(point) for point in points.tolist()], fill=color, width=width, joint="curve")

    def draw_frame(self, second):
        """Draw up to a moment of the trace and return the picture. Each moment is later than the one before."""
        from PIL import ImageDraw

        rows = self._moves
        now = int(np.searchsorted(rows.seconds, second, "right")) - 1
        begin = self._drawn
        while begin < now:
            lit = rows.tool[begin] > 0
            change = np.flatnonzero((rows.tool[begin:now] > 0) != lit)
            end = begin + int(change[0]) if len(change) else now
            self._draw_line(begin, end, _DOWN if lit else _UP, 3 if lit else 1)
            begin = end
        self._drawn = max(now, self._drawn)
        picture = self._sheet.copy()
        pen = ImageDraw.Draw(picture)
        x, y = self._at[now]
        radius = 7
        lit = rows.tool[now] > 0
        pen.ellipse([x - radius, y - radius, x + radius, y + radius], outline=_HEAD, width=3, fill=_HEAD if lit else None)
        pen.text((16, 12), self._caption_text(second, now), fill=_TEXT, font=self._font)
        return picture

    def _caption_text(self, second, now):
        """Return a frame's caption: minutes and seconds since the trace's first row, X and Y in mm of row `now`, and the speed in mm/min over the
        last 0.1 s."""
        rows = self._moves
        then = int(np.searchsorted(rows.seconds, second - 0.1, "right")) - 1
        way = np.hypot(*np.diff(self._mm[max(then, 0) : now + 1], axis=0).T).sum() if now > then >= 0 else 0.0
        minutes, rest = divmod(second - float(rows.seconds[1]), 60)
        x, y = self._mm[now]
        return f"{int(minutes)}:{rest:04.1f}   X {x:.2f}  Y {y:.2f} mm   {way * 600:.0f} mm/min"


def write(path, moves, scale, seconds=20.0, speed=None, per_second=20, progress=None):
    """Write a film to `path`, .gif or .mp4; returns how many frames it has. Calls `progress(share)`. Raises Failure."""
    moments = frame_times(moves, seconds, speed, per_second)
    painter = Painter(moves, scale)

    def draw_frames():
        """Yield the picture of each moment; calls `progress(share)` before each, 0…1."""
        for number, moment in enumerate(moments):
            if progress:
                progress(number / len(moments))
            yield painter.draw_frame(float(moment))

    kind = str(path).lower().rpartition(".")[2]
    try:
        if kind == "gif":
            _write_gif(path, draw_frames(), per_second)
        elif kind == "mp4":
            _write_mp4(path, draw_frames(), per_second)
        else:
            raise Failure("{}: a film is a .gif or an .mp4", path)
    except OSError as error:
        raise Failure("cannot write {}: {}", path, reason(error)) from error
    return len(moments)


def _write_gif(path, frames, per_second):
    """Write a GIF whose frames share one palette: the film's few colours, and the mixtures of two of them."""
    from PIL import Image

    colors = [_rgb_of(color) for color in _COLORS]
    mixed = [tuple(round(a + (b - a) * part / 4) for a, b in zip(one, other)) for one in colors for other in colors for part in range(1, 4)]
    palette = Image.new("P", (1, 1))
    table = list(dict.fromkeys(colors + mixed))[:256]
    palette.putpalette([value for color in table for value in color])
    reduced = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    first = next(reduced)
    first.save(path, save_all=True, append_images=reduced, duration=round(1000 / per_second), loop=0, optimize=False, disposal=1)


def _rgb_of(color):
    return tuple(int(color[at : at + 2], 16) for at in (1, 3, 5))


def _write_mp4(path, frames, per_second):
    """Write pictures of SIZE as an MP4 of `per_second` frames a second, by imageio-ffmpeg."""
    import imageio_ffmpeg

    writer = imageio_ffmpeg.write_frames(str(path), SIZE, fps=per_second, macro_block_size=16, output_params=["-movflags", "+faststart"])
    writer.send(None)
    try:
        for frame in frames:
            writer.send(frame.tobytes())
    finally:
        writer.close()

"""Finds steps/mm, backlash and squareness from measured lengths, and says whether scale or mechanics is at fault.

    rows = read("table.txt")
    fit = fit_axis([row for row in rows if row.axis == "x"], steps_per_mm=48)
    fit.steps_per_mm, fit.u_steps_per_mm, fit.backlash, fit.verdict

A table has a line for each length, or for each reading of it; # begins a comment, separators are blanks, tabs, commas or semicolons:

    # axis  commanded  measured  sigma  readings  after
    x       10         9.467     0.330  10        turn
    x       20         18.078    0.167  10        turn
    xy+     100x100    141.52    0.05   5

`measured` is the mean of readings; `readings` is their number, `sigma` their standard deviation; without both it is one reading. `after` turn (what
stands there by default): the axis had moved the other way before, so its backlash is missing in the length; same: it had not.
xy+ and xy- are the two diagonals of a rectangle, from its lower left corner and from its lower right.

The model of an axis is measured = scale · commanded − backlash (after a turn) + offset (of the readings, known only if both
kinds are measured), fitted by least squares weighted by the means' uncertainties. Whether it explains the lengths is Pearson's
χ² test on what is left; if it does not, uncertainties grow by √(χ²/degrees of freedom) (Birge). Uncertainties are standard ones.
"""

import math
import re
from dataclasses import dataclass

import numpy as np

from host_tools.failure import Failure, reason
from host_tools.language import N_, _

DOUBT = 0.01  # less likely than that by chance: the line does not explain the lengths
SURE = 2.0  # standard uncertainties
READING_MM = 0.02  # of a caliper
_LONGEST_MM = 100_000.0
_NUMBER = r"\d+(?:\.\d*)?|\.\d+"
_FORM = N_("axis, commanded mm, measured mm, and if known: sigma, readings, turn or same")


@dataclass
class Row:
    """One line of a table. `axis`: x, y, z, a, or a diagonal, xy+; `commanded`: a length, or the sides of a rectangle."""

    axis: str
    commanded: tuple
    measured: float
    sigma: float = 0.0
    readings: int = 1
    turn: bool = True


def characterise(rows):
    """Return {commanded mm: {axis: (mean, standard deviation)}} of the lengths along axes, as table 1 of the torch's document of 2020 has them. A
    length with a line for each reading gets both from its lines; of one reading alone the deviation is 0."""
    found = {}
    for row in rows:
        if len(row.axis) == 1:
            found.setdefault(row.commanded[0], {}).setdefault(row.axis, []).append(row)
    return {length: {axis: _mean_of(found[length][axis]) for axis in sorted(found[length])} for length in sorted(found)}


def _mean_of(rows):
    """Return (mean, standard deviation) of all readings of the rows, in mm."""
    count = sum(row.readings for row in rows)
    mean = sum(row.readings * row.measured for row in rows) / count
    squares = sum((row.readings - 1) * row.sigma**2 + row.readings * (row.measured - mean) ** 2 for row in rows)
    return mean, math.sqrt(squares / (count - 1)) if count > 1 else 0.0


@dataclass
class Fit:
    axis: str
    steps_per_mm: float  # that would be right
    u_steps_per_mm: float
    scale: float  # measured / commanded mm
    u_scale: float
    backlash: float  # mm; with the readings' offset if `split` is False
    u_backlash: float
    split: bool  # backlash and the readings' offset are known apart
    offset: float
    left: list  # (commanded, measured, measured − model, uncertainty) in mm
    chi2: float
    freedom: int
    chance: float  # that χ² comes out so large by chance; None without scatter or spare lengths
    verdict: str  # "right", "scale", "mechanics" or "unknown"


@dataclass
class Square:
    axes: str
    mm_m: float  # how far the second axis leans towards the first: mm at 1 m
    u_mm_m: float
    degrees: float  # the angle between them is 90° less this


def read(path):
    """Read the rows of a table. Raises Failure with the line that is wrong."""
    try:
        text = open(path, encoding="utf-8", errors="replace").read()
    except OSError as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        fields = re.split(r"[\s,;]+", line.partition("#")[0].strip().lower())
        if fields != [""] and fields[0] != "axis":
            rows.append(_parse_row(f"{path}:{number}", fields))
    if not rows:
        raise Failure("{} has no line with a length: {}", path, _(_FORM))
    return rows


def _parse_row(where, fields):
    """Return the Row of a line's fields: axis, commanded, measured and sigma in mm, readings, after. Raises Failure, which names the line by `where`,
    if a field is wrong."""
    axis, *rest = fields
    diagonal = re.fullmatch(r"([xyza])([xyza])[+-]", axis)
    if not (diagonal and diagonal[1] != diagonal[2]) and axis not in ("x", "y", "z", "a"):
        raise Failure("{}: {!r} is no axis; x, y, z, a, or a diagonal: xy+, xy-", where, axis)
    if len(rest) < 2 or len(rest) > 5:
        raise Failure("{}: a line has {}", where, _(_FORM))
    sides = rest[0].split("x") if diagonal else rest[:1]
    if len(sides) != (2 if diagonal else 1):
        raise Failure("{}: a diagonal's commanded sides are written 100x80, not {!r}", where, rest[0])
    for name, text in zip(("commanded", "commanded", "measured", "sigma")[2 - len(sides) :], (*sides, *rest[1:3])):
        if not re.fullmatch(_NUMBER, text) or not (0 if name == "sigma" else 1e-6) <= float(text) <= _LONGEST_MM:
            raise Failure("{}: {} {!r} is no length in mm", where, name, text)
    readings = rest[3] if len(rest) > 3 else "1"
    if not re.fullmatch(r"[1-9]\d{0,5}", readings):
        raise Failure("{}: {!r} is no number of readings", where, readings)
    after = rest[4] if len(rest) > 4 else "turn"
    if after not in ("turn", "same"):
        raise Failure("{}: after what? turn or same, not {!r}", where, after)
    sigma = float(rest[2]) if len(rest) > 2 else 0.0
    return Row(axis, tuple(map(float, sides)), float(rest[1]), sigma, int(readings), after == "turn")


def pool_rows(rows, reading=READING_MM):
    """Pool equal lengths; return [(commanded, turn, mean, its standard uncertainty)] in mm. `reading`: the uncertainty of a reading, in mm. A length
    read once, without sigma, has the uncertainty `reading` alone."""
    groups = {}
    for row in rows:
        groups.setdefault((row.commanded, row.turn), []).append(row)
    found = []
    for (commanded, turn), same in groups.items():
        count = sum(row.readings for row in same)
        mean = sum(row.measured * row.readings for row in same) / count
        spread = sum((row.readings - 1) * row.sigma**2 + row.readings * (row.measured - mean) ** 2 for row in same)
        variance = spread / (count - 1) / count if count > 1 else same[0].sigma ** 2
        found.append((commanded, turn, mean, math.sqrt(variance + reading**2)))
    return found


def fit_axis(rows, steps_per_mm, reading=READING_MM):
    """Fit scale and backlash to one axis's rows, measured at `steps_per_mm`, by weighted least squares. Returns a Fit. Raises Failure if there are
    too few lengths."""
    points = pool_rows(rows, reading)
    axis = rows[0].axis
    lengths = np.array([commanded[0] for commanded, _, _, _ in points])
    if len(set(lengths)) < 2:
        raise Failure("{}: at least two different lengths are wanted, the longer the better", axis.upper())
    measured, sigma = np.array([point[2] for point in points]), np.array([point[3] for point in points])
    turned = np.array([1.0 if turn else 0.0 for _, turn, _, _ in points])
    split = 0 < turned.sum() < len(points) and len(points) > 2
    columns = [lengths, -turned, np.ones(len(points))] if split else [lengths, -np.ones(len(points))]
    design = np.column_stack(columns)
    weighted = design / sigma[:, None]
    covariance = np.linalg.inv(weighted.T @ weighted)
    solution = covariance @ weighted.T @ (measured / sigma)
    rest = measured - design @ solution
    chi2, freedom = float(((rest / sigma) ** 2).sum()), len(points) - len(columns)
    scatter = any(row.sigma for row in rows) or len(rows) > len(points)
    chance = chi2_above(chi2, freedom) if freedom and scatter else None
    if freedom:
        covariance = covariance * max(1.0, chi2 / freedom)
    u_scale, u_backlash = (math.sqrt(covariance[index, index]) for index in range(2))
    scale = float(solution[0])
    right = steps_per_mm / scale
    return Fit(
        axis, right, right * u_scale / scale, scale, u_scale, float(solution[1]), u_backlash, split,
        float(solution[2]) if split else 0.0, list(zip(lengths, measured, rest, sigma)), chi2, freedom, chance,
        _verdict_of(scale, u_scale, chance),
    )  # fmt: skip


def _verdict_of(scale, u_scale, chance):
    """Return "unknown" without a chance of χ², "mechanics" if it is below DOUBT, "scale" if the scale is off 1 by more than SURE uncertainties, else
    "right"."""
    if chance is None:
        return "unknown"
    if chance < DOUBT:
        return "mechanics"
    return "scale" if abs(scale - 1) > SURE * u_scale else "right"


def chi2_above(chi2, freedom):
    """Return the chance that χ² of `freedom` degrees of freedom is above `chi2` (Abramowitz and Stegun, 26.4.4 and 26.4.5)."""
    half = chi2 / 2
    tail = math.erfc(math.sqrt(half)) if freedom % 2 else math.exp(-half)
    for degrees in range(freedom % 2 or 2, freedom, 2):
        tail += math.exp(degrees / 2 * math.log(half) - half - math.lgamma(degrees / 2 + 1)) if half else 0.0
    return tail


def squareness(rows, scales, reading=READING_MM):
    """The Square of each pair of axes whose two diagonals were measured on one rectangle. `scales`: {axis: measured / commanded}.

    By the law of cosines d₊² − d₋² = 4 a b cos γ: sides of the wrong length have little say in it.
    """
    found = []
    kinds = {}
    for commanded, turn, mean, sigma, axis in [
        (*point, axis) for axis in sorted({row.axis for row in rows}) for point in pool_rows([row for row in rows if row.axis == axis], reading)
    ]:
        kinds.setdefault((axis[:2], commanded), {})[axis[2]] = mean, sigma
    for (axes, (first, second)), both in kinds.items():
        if len(both) < 2:
            raise Failure("{}: the other diagonal of {:g}x{:g} is missing", axes, first, second)
        (plus, u_plus), (minus, u_minus) = both["+"], both["-"]
        sides = 4 * first * scales.get(axes[0], 1.0) * second * scales.get(axes[1], 1.0)
        cosine = (plus * plus - minus * minus) / sides
        if abs(cosine) > 0.5:
            raise Failure("{}: these are no diagonals of {:g}x{:g}: {:g} and {:g}", axes, first, second, plus, minus)
        uncertain = 2 * math.hypot(plus * u_plus, minus * u_minus) / sides
        found.append(Square(axes, 1000 * cosine, 1000 * uncertain, math.degrees(math.asin(cosine))))
    return found


def square_waves(axis, lengths, count, spacing=4.0):
    """Return the square waves of the document, [(mm of a length's first point or None, x, y)], from 0, 0: `count` strokes to and fro along `axis` (x
    or y) for each length, `spacing` mm apart on the other axis; each stroke is after a turn. To a length's first point the tool is off."""
    found, across = [], 0.0

    def add_point(length, along):
        found.append((length, along, across) if axis == "x" else (length, across, along))

    for length in lengths:
        add_point(length, 0.0)
        for stroke in range(count):
            along = float(length) if stroke % 2 == 0 else 0.0
            add_point(None, along)
            if stroke < count - 1:
                across += spacing
                add_point(None, along)
        across += 3 * spacing
    return found


def pattern_lines(axis, lengths, count, feed):
    """Return these square waves as lines of G-code, at `feed` mm/min. M3 lowers the pen, M5 lifts it."""
    lines, before = ["G21 G90 G94", "M5"], None
    for length, x, y in square_waves(axis, lengths, count):
        if length is not None:
            lines += ["M5", "G4 P0.5"] if before else []
            lines += [f"G0 X{x:g} Y{y:g}" if axis == "x" else f"G0 Y{y:g} X{x:g}", "M3 S1000", "G4 P0.5", f"(strokes of {length:g} mm)"]
        elif x != before[0] or axis == "x" and y == before[1]:
            lines.append(f"G1 X{x:g}" + (f" F{feed:g}" if axis == "x" else ""))
        else:
            lines.append(f"G1 Y{y:g}" + (f" F{feed:g}" if axis == "y" else ""))
        before = x, y
    return [*lines, "M5", "G4 P0.5", "G0 X0 Y0", "M2"]


def pattern_packets(axis, lengths, count, steps_per_mm):
    """Return these square waves in the words of the plotter's packets."""
    waves = square_waves(axis, lengths, count)
    return [f"{'LINE' if length is None else 'MOVE'} {round(x * steps_per_mm[0])} {round(y * steps_per_mm[1])}" for length, x, y in waves] + ["END"]


def pattern_pulses(axis, lengths, count, feed, steps_per_mm):
    """Return these square waves as a file of pulses, whose tool is on along the strokes."""
    codes, at = [f"[+{feed:g}"], (0, 0)
    for length, x, y in square_waves(axis, lengths, count):
        to = round(x * steps_per_mm[0]), round(y * steps_per_mm[1])
        codes += [")"] if length is not None else []
        codes += ["AB"[to[0] < at[0]] * abs(to[0] - at[0]), "CD"[to[1] < at[1]] * abs(to[1] - at[1])]
        codes += ["("] if length is not None else []
        at = to
    return ["".join(codes) + ")]"]

"""Read plain G-code as a machine would, for tests of the compilers' output. Shares no code with them.

    for event in events(["G1 X5 F100", "M8"]): …
"""

import math
import re

_WORD = re.compile(r"([A-Z])([-+]?\d*\.?\d+)")
_PLANES = {17: "XYZ", 18: "ZXY", 19: "YZX"}


def events(lines, start=(None, None, None)):
    """Return the actions of the lines in order: ("rapid", place), ("feed", F, place), ("arc", F, clockwise, plane, place, centre, turns) and ("word",
    text). A place is (x, y, z), by default the one in `start`; the centre is in the plane of the arc.
    """
    place = dict(zip("XYZ", start))
    motion, plane, feed = 0, 17, None
    found = []
    for line in lines:
        line = re.sub(r";.*|\(.*?\)|\s", "", line).upper()
        words = [(letter, float(value)) for letter, value in _WORD.findall(line)]
        assert "".join(letter + value for letter, value in _WORD.findall(line)) == line, line
        values = dict(words)
        codes = [value for letter, value in words if letter == "G"]
        rest = []
        for letter, value in words:
            if letter == "G" and value in (0, 1, 2, 3):
                motion = int(value)
            elif letter == "G" and value in (17, 18, 19):
                plane = int(value)
            elif letter == "G" and value in (21, 90, 94, 40, 80):
                pass
            elif letter in "GMST" or letter == "P" and (4 in codes or any(one == "M" for one, _ in words)):
                rest.append(f"{letter}{value:g}")
        feed = values.get("F", feed)
        axes = [axis for axis in "XYZ" if axis in values]
        if any(code in (10, 28, 28.1, 30, 30.1, 38.2, 38.3, 38.4, 38.5, 43.1, 53, 92, 92.1, 91) for code in codes):
            found.append(("word", line))
            continue
        if rest:
            found.append(("word", " ".join(rest)))
        if not axes and "I" not in values and "J" not in values and "K" not in values:
            continue
        before = dict(place)
        place.update({axis: values[axis] for axis in axes})
        end = tuple(place.values())
        if motion == 0:
            found.append(("rapid", end))
        elif motion == 1:
            found.append(("feed", feed, end))
        else:
            first, second, _ = _PLANES[plane]
            offsets = {"X": "I", "Y": "J", "Z": "K"}
            if "R" in values:
                centre = _centre(before[first], before[second], place[first], place[second], values["R"], motion == 2)
            else:
                centre = tuple(before[axis] + values.get(offsets[axis], 0.0) for axis in (first, second))
            found.append(("arc", feed, motion == 2, plane, end, centre, int(values.get("P", 1))))
    return found


def _centre(x, y, to_x, to_y, radius, clockwise):
    chord = math.dist((x, y), (to_x, to_y))
    height = math.sqrt(max(0.0, radius**2 - (chord / 2) ** 2))
    side = 1 if clockwise == (radius < 0) else -1
    return (x + to_x) / 2 - side * height * (to_y - y) / chord, (y + to_y) / 2 + side * height * (to_x - x) / chord


def same(one, other, within=2e-5):
    """True if two lists of events are the same but for rounding."""
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(same(a, b, within) for a, b in zip(one, other))
    if isinstance(one, float) and isinstance(other, (float, int)):
        return abs(one - other) <= within
    return one == other


def cut_points(found, sag=0.0005):
    """Points of the motions at feed, in X and Y: one polyline for each run of them."""
    runs, here = [], None
    for event in found:
        if event[0] == "word":
            continue
        if event[0] == "rapid":
            here = event[1]
            runs.append([])
            continue
        if not runs or not runs[-1]:
            runs.append([here[:2]] if here else [])
        if event[0] == "feed":
            runs[-1].append(event[2][:2])
            here = event[2]
        else:
            _, _, clockwise, plane, end, centre, _ = event
            assert plane == 17
            radius = math.dist(here[:2], centre)
            begin = math.atan2(here[1] - centre[1], here[0] - centre[0])
            sweep = (math.atan2(end[1] - centre[1], end[0] - centre[0]) - begin) * (-1 if clockwise else 1) % math.tau
            sweep = sweep if sweep > 1e-6 else math.tau
            count = max(2, math.ceil(sweep / (2 * math.acos(1 - min(0.5, sag / radius)))))
            for each in range(1, count + 1):
                angle = begin + (-1 if clockwise else 1) * sweep * each / count
                runs[-1].append((centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)))
            here = end
    return [run for run in runs if len(run) > 1]

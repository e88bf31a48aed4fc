"""Arcs of real programs: the step path against the true one."""

import pytest

import check_arcs
from true_path import compare, compare_file, report, split


@pytest.mark.parametrize("steps_per_m", [10_000, 40_000, pytest.param(320_000, marks=pytest.mark.slow)])
def test_gcode_of_the_corpus(corpus, steps_per_m, capsys):
    """All of the real files: no step farther off the line or arc asked for than arcs and their ends may be."""
    files = sorted(corpus.glob("*.gcode"))
    assert files
    for file in files:
        found = compare_file(file, steps_per_m)
        with capsys.disabled():
            print("\n" + report(file.name, steps_per_m, found), end="")
        assert found[0] and found[2] <= check_arcs.BOUND, found


def fitted(file):
    """A file's lines, those of its cuts in the plane made arcs that go through the next point, too, as CAM programs write
    them: the centre to four digits. Points close to each other give the tiniest of arcs."""
    from host_tools.programs import gcode_file

    lines = []
    points = []  # the cut so far: (x, y)

    def give():
        while len(points) > 2:
            (x, y), (through_x, through_y), (end_x, end_y) = points[:3]
            ax, ay, bx, by = through_x - x, through_y - y, end_x - x, end_y - y
            double = 2 * (ax * by - ay * bx)
            if abs(double) > 1e-9:
                i = (by * (ax * ax + ay * ay) - ay * (bx * bx + by * by)) / double
                j = (ax * (bx * bx + by * by) - bx * (ax * ax + ay * ay)) / double
                if abs(i) + abs(j) < 50:
                    lines.append(f"G{3 if double > 0 else 2}X{through_x:.4f}Y{through_y:.4f}I{i:.4f}J{j:.4f}")
                    del points[:1]
                    continue
            lines.append(f"G1X{through_x:.4f}Y{through_y:.4f}")
            del points[:1]
        lines.extend(f"G1X{x:.4f}Y{y:.4f}" for x, y in points[1:])
        points.clear()

    for _, line in gcode_file.read(file):
        text = line.decode()
        words = dict(split(text))
        if words.get("G") == 1 and "X" in words and "Y" in words and "Z" not in words:
            points.append((words["X"], words["Y"]))
        else:
            give()
            lines.append(text)
    give()
    return list(enumerate(lines, 1))


@pytest.mark.parametrize("name", ["cncjs_tball.gcode", "cncjs_jsdc.gcode"])
def test_arcs_through_the_points_of_the_corpus(corpus, name, capsys):
    """The engravings' points are 5 µm apart and more: hundreds of arcs of a step or two, and some that rounding turns round."""
    lines = fitted(corpus / name)
    assert sum("I" in text for _, text in lines) > 500
    for steps_per_m in (40_000, 320_000):
        found = compare(lines, [steps_per_m] * 3)
        with capsys.disabled():
            print("\n" + report(name + ", arcs fitted", steps_per_m, found), end="")
        assert found[2] <= check_arcs.BOUND, found

"""Traces: reading, measuring, and their pictures."""

import pytest

from host_tools.cli import plot as command
from host_tools.drawings import objects, plot
from host_tools.failure import Failure
from host_tools.sim.measure import Row, measure_drawing, read_trace

HEADER = "t_us,x,y,z,a,tool\n"


def rows_of(points):
    """The trace of an ideal machine that draws `points` from 0;0."""
    rows = [Row(0.0, 0, 0, 0)]
    x0 = y0 = 0
    t_us = 0.0
    for down, x1, y1 in points:
        count = max(abs(x1 - x0), abs(y1 - y0))
        for step in range(1, count + 1):
            t_us += 1000
            place = round(x0 + (x1 - x0) * step / count), round(y0 + (y1 - y0) * step / count)
            rows.append(Row(t_us, *place, 1000 if down else 0))
        x0, y0 = x1, y1
    rows.append(Row(t_us + 60000, x0, y0, 0))
    return rows


@pytest.mark.parametrize("name", list(objects.objects()))
def test_an_ideal_trace_is_exact(name):
    points = objects.objects()[name]
    result = measure_drawing(rows_of(points), points)
    assert not result.faults
    assert result.deviation <= 0.5
    assert result.steps == len(rows_of(points)) - 2


def test_what_comes_before_the_drawing_is_passed_over():
    points = [(False, 3, 0), (True, 3, 4)]
    homing = [Row(-9.0, 7, 1, 0), Row(-8.0, 6, 1, 0), Row(-7.0, 0, 0, 0)]
    result = measure_drawing(homing + rows_of(points)[1:], points)
    assert (result.steps, result.first, result.faults) == (7, 2, [])


def test_faults_are_named():
    points = [(False, 3, 0), (True, 3, 4)]
    rows = rows_of(points)
    rows[2].y = 1
    assert measure_drawing(rows, points).deviation == 1
    rows = rows_of(points)
    rows[5].tool = 0
    assert "pen is up" in measure_drawing(rows, points).faults[0]
    rows = rows_of(points)
    rows[-1].tool = 1000
    assert measure_drawing(rows, points).faults == ["ends with the pen down"]
    assert "commanded" in measure_drawing(rows_of(points[:1]), points).faults[0]
    assert "ends at" in measure_drawing(rows_of(points + [(True, 9, 4)]), points).faults[1]


def test_the_five_objects_have_their_point_counts():
    counts = {name: len(points) for name, points in objects.objects().items()}
    assert counts == {"square": 5, "triangle": 4, "spiral": 25, "text": 74, "circle": 50}
    for points in objects.objects().values():
        assert not points[0][0]
        assert all(0 <= x <= 4000 and 0 <= y <= 3000 for _, x, y in points)
        assert all(a[1:] != b[1:] for a, b in zip(points, points[1:]))


def test_a_trace_file_that_is_none_is_a_clear_error(tmp_path):
    with pytest.raises(Failure, match="cannot read trace"):
        read_trace(tmp_path / "none.csv")
    (tmp_path / "a.csv").write_text("x,y\n1,2\n")
    with pytest.raises(Failure, match="is not a trace"):
        read_trace(tmp_path / "a.csv")
    (tmp_path / "b.csv").write_text(HEADER + "0.000,0,0,0,0,0\n1.000,zero,0,0,0,0\n")
    with pytest.raises(Failure, match="line 3"):
        read_trace(tmp_path / "b.csv")


def test_strokes_follow_the_pen():
    rows = [Row(0, 0, 0, 0), Row(1, 10, 0, 0), Row(2, 10, 20, 1000), Row(3, 10, 30, 1000), Row(4, 0, 30, 0)]
    assert plot.strokes_of_trace(rows, (10, 10)) == [
        (False, [(0, 0), (1, 0)]), (True, [(1, 0), (1, 2), (1, 3)]), (False, [(1, 3), (0, 3)]),
    ]


def test_the_picture_has_dark_lines_where_the_pen_was_down(tmp_path):
    from matplotlib import image

    trace = tmp_path / "job.csv"
    trace.write_text(HEADER + "0.000,0,0,0,0,0\n1.000,100,0,0,0,0\n2.000,100,0,0,0,1000\n3.000,100,900,0,0,1000\n")
    command.plot(trace, out=None, board="plotter_2014", steps_per_mm="10")
    picture = image.imread(tmp_path / "job.png")[:, :, :3]
    assert picture.shape[0] > 500
    assert (picture.max(axis=2) < 0.3).sum() > 500


def drawn_by(monkeypatch, action):
    """Texts of the legend and the title of the picture that `action` saves, and its limits."""
    import matplotlib
    from matplotlib.figure import Figure

    matplotlib.use("Agg")
    seen = {}

    def savefig(figure, path, **_):
        axes = figure.axes[0]
        seen.update(labels=axes.get_legend_handles_labels()[1], title=axes.get_title(), x=axes.get_xlim(), y=axes.get_ylim())

    monkeypatch.setattr(Figure, "savefig", savefig)
    action()
    return seen


def test_a_picture_shows_table_page_and_time(tmp_path, monkeypatch):
    trace = tmp_path / "job.csv"
    trace.write_text(HEADER + "0.000,0,0,0,0,0\n1000000.000,100,0,0,0,0\n63500000.000,100,900,0,0,1000\n")
    seen = drawn_by(monkeypatch, lambda: command.plot(trace, None, "plotter_2014", None))
    assert seen["title"] == "job, 1:02 (62.5 s)"
    assert "table 400 × 300 mm" in seen["labels"]
    assert seen["x"][0] <= 0 and seen["x"][1] >= 400 and seen["y"][1] >= 300
    seen = drawn_by(monkeypatch, lambda: command.plot(trace, None, "plotter_2014", "10"))
    assert not any("table" in label for label in seen["labels"])
    seen = drawn_by(monkeypatch, lambda: plot.save_picture("a.png", [(True, [(1, 1), (2, 2)])], "t", (0, 0, 9, 8), (0, 1, 7, 6.5)))
    assert {"table 9 × 8 mm", "page 7 × 5.5 mm"} <= set(seen["labels"])


def test_steps_per_mm_that_are_none_are_refused(tmp_path):
    for text in ("ten", "1,2,3", "0", ""):
        with pytest.raises(Failure, match="--steps-per-mm"):
            command.plot(tmp_path / "job.csv", out=None, board="plotter_2014", steps_per_mm=text)


def test_lines_in_the_colours_of_their_order(tmp_path):
    from matplotlib.image import imread

    strokes = [(True, [(0, y), (9, y)]) for y in range(8)]
    plot.save_picture(tmp_path / "dark.png", strokes, "dark")
    plot.save_picture(tmp_path / "order.png", strokes, "order", order=True)
    dark, order = (imread(tmp_path / name)[..., :3] for name in ("dark.png", "order.png"))

    def count(picture):
        """Places of a vivid colour."""
        return int((picture.max(axis=2) - picture.min(axis=2) > 0.5).sum())

    assert count(order) > 3 * count(dark)


def test_a_trace_without_a_stroke_has_a_picture(tmp_path):
    trace = tmp_path / "still.csv"
    trace.write_text(HEADER + "0.000,0,0,0,0,0\n")
    strokes = plot.strokes_of_trace(read_trace(trace), (10, 10))
    for order in (False, True):
        plot.save_picture(tmp_path / "still.png", strokes, "still", order=order)
        assert (tmp_path / "still.png").stat().st_size > 1000

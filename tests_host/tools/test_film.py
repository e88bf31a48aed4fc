"""`passo film` and `passo watch`: films by their frames, the live view by its text for a running machine."""

import io

import numpy as np
import pytest
from PIL import Image
from rich.console import Console

from host_tools.cli import film as command
from host_tools.cli import watch
from host_tools.clients.grbl import GrblClient
from host_tools.drawings import film
from host_tools.failure import Failure
from running_router import Running

HEADER = "t_us,x,y,z,a,tool\n"


def trace_of(path, legs):
    """A trace of straight legs [(steps x, steps y, tool, microseconds a step)]."""
    rows, x, y, t = [(0.0, 0, 0, 0)], 0, 0, 0.0
    for to_x, to_y, tool, each in legs:
        count = max(abs(to_x - x), abs(to_y - y))
        for part in range(1, count + 1):
            t += each
            rows.append((t, x + (to_x - x) * part // count, y + (to_y - y) * part // count, tool))
        x, y = to_x, to_y
    path.write_text(HEADER + "".join(f"{t:.3f},{x},{y},0,0,{tool}\n" for t, x, y, tool in rows))
    return path


SQUARE = [(100, 0, 0, 1000), (100, 100, 1000, 1000), (0, 100, 1000, 1000), (0, 0, 1000, 1000)]


def count_of(picture, color):
    pixels = np.asarray(picture.convert("RGB")).astype(int)
    return int((np.abs(pixels - film._rgb_of(color)).max(axis=2) < 24).sum())


def test_a_film_grows_with_the_machine(tmp_path):
    trace = trace_of(tmp_path / "square.csv", SQUARE)
    command.film(trace, None, "plotter_2014", "10", 4.0, None, 10)
    picture = Image.open(tmp_path / "square.gif")
    assert picture.n_frames == 40 and picture.size == film.SIZE and picture.info["duration"] == 100
    drawn = []
    for number in range(40):
        picture.seek(number)
        drawn.append(count_of(picture, film._DOWN))
    assert all(later >= earlier - 150 for earlier, later in zip(drawn, drawn[1:]))  # the head hides a little of it
    assert drawn[8] < 200 and drawn[20] > 1500 and drawn[39] > 2.2 * drawn[20]


def test_a_film_as_mp4(tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    trace = trace_of(tmp_path / "square.csv", SQUARE)
    command.film(trace, tmp_path / "square.mp4", "plotter_2014", "10", 15.0, 0.2, 20)
    frames = imageio_ffmpeg.read_frames(str(tmp_path / "square.mp4"))
    about = next(frames)
    assert about["size"] == film.SIZE and about["fps"] == 20
    pictures = [Image.frombytes("RGB", film.SIZE, frame) for frame in frames]
    assert len(pictures) == pytest.approx(0.399 / 0.2 * 20, abs=1)
    assert count_of(pictures[-1], film._DOWN) > 2 * count_of(pictures[len(pictures) // 2], film._DOWN) > 1000


def test_speed_and_place_stand_in_the_film(tmp_path):
    moves = film.load_moves(trace_of(tmp_path / "line.csv", [(4000, 0, 1000, 500)]))
    painter = film.Painter(moves, (10, 10))
    number = int(np.searchsorted(moves.seconds, 1.0))
    assert painter._caption_text(1.0, number).endswith("12000 mm/min") and "X 199.9" in painter._caption_text(0.9995, number - 1)


@pytest.mark.parametrize("text, why", [
    ("x,y\n1,2\n", "not a trace"), (HEADER + "0,0,0,0,0,0\n1,2,3\n", "line 3: not a row"), (HEADER + "0,0,0,0,0,0\n5,a,0,0,0,0\n", "line 3"),
    (HEADER + "0,0,0,0,0,0\n", "nothing moves"), (HEADER + "0,0,0,0,0,0\nnan,1,0,0,0,0\n", "line 3"),
])  # fmt: skip
def test_a_trace_that_is_none(tmp_path, text, why):
    path = tmp_path / "trace.csv"
    path.write_text(text)
    with pytest.raises(Failure, match=why):
        command.film(path, None, "plotter_2014", "10", 4.0, None, 10)


def test_a_film_that_cannot_be(tmp_path):
    trace = trace_of(tmp_path / "square.csv", SQUARE)
    with pytest.raises(Failure, match="is a .gif or an .mp4"):
        command.film(trace, tmp_path / "film.avi", "plotter_2014", "10", 4.0, None, 10)
    with pytest.raises(Failure, match="frames is too long"):
        command.film(trace, None, "plotter_2014", "10", 4.0, 0.002, 20)
    with pytest.raises(Failure, match="cannot write"):
        command.film(trace, tmp_path / "none" / "film.gif", "plotter_2014", "10", 4.0, None, 10)
    with pytest.raises(Failure, match="cannot read trace"):
        command.film(tmp_path / "none.csv", None, "plotter_2014", "10", 4.0, None, 10)


def text_of(view):
    out = Console(file=io.StringIO(), width=120)
    out.print(view.as_panel())
    return out.file.getvalue()


def test_watch_shows_a_running_machine():
    with Running("real") as running:
        with GrblClient(running.line.name) as client:
            client.connect()
            client.command("$X")
            view, known, seen = watch.View("router"), {}, []
            for line in ("G21G90", "N12G1X4F1200", "N13Y4"):
                client.command(line)
            for _ in range(20_000):
                view.add_position(*watch._look_at_grbl(client, known))
                seen.append(dict(view._rows))
                if seen[-1]["state"] == "Idle" and len(seen) > 2:
                    break
        assert {"Run", "Idle"} <= {rows["state"] for rows in seen}
        assert {"12", "13"} & {rows["line"] for rows in seen} and seen[-1]["line"] == "-"
        assert max(float(rows["moves"].split()[0]) for rows in seen) > 600 and seen[-1]["machine"].startswith("X 4.000  Y 4.000")
        assert view.positions[0][0] < 4 and view.positions[-1] == (4.0, 4.0)
        assert "X 4.000  Y 4.000" in text_of(view) and "⣿" in text_of(view)


def test_the_map_shows_the_way():
    """A square: full lines at its four sides, nothing inside."""
    lines = watch.braille_map([(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)], 20, 10).splitlines()
    assert len(lines) == 10 and all(len(line) == 20 for line in lines)
    assert all(character != "⠀" for character in lines[0] + lines[-1])
    assert all(line[0] != "⠀" and line[-1] != "⠀" and set(line[1:-1]) == {"⠀"} for line in lines[1:-1])
    assert watch.braille_map([(3, 3)], 4, 2).count("⣿") == 1
    view = watch.View("x")
    for number in range(20_000):
        view.add_position([], (number, number % 7))
    assert len(view.positions) <= watch._MOST_PLACES and view.positions[-1] == (19_999, 19_999 % 7)

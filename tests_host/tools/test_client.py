"""The client of the plotter's language and the drawing of jobs, against a controller that shares no code with it."""

import random
import threading
import time

import pytest
from fake_plotter import FakePlotter, without_repeats

from host_tools.clients.plotter import Cancelled, PlotterClient, Refused
from host_tools.clients.serial_port import LinkError
from host_tools.failure import Failure
from host_tools.programs.job import Broken, Job, remaining_points
from host_tools.programs.journal import Journal

SQUARE = [(False, 644, 314), (True, 644, 454), (True, 884, 454), (True, 884, 314), (True, 644, 314)]


def as_packets(points):
    return [("l" if down else "m", x, y) for down, x, y in points]


def a_polyline(count, seed=1):
    chance = random.Random(seed)
    points = [(False, 10, 10)]
    while len(points) < count:
        point = (chance.random() < 0.8, chance.randrange(4000), chance.randrange(3000))
        if point[1:] != points[-1][1:]:
            points.append(point)
    return points


def test_the_square_of_2014_is_sent_byte_for_byte():
    expected = bytes.fromhex(
        "720000000072 6f000000006f 7303e800005e 6d0284013a2e 6c028401c6b9 6c037401c6aa 6c0374013a1e 6c0284013a2d"
        "650000000065"
    )
    with FakePlotter() as fake, PlotterClient(fake.path) as client:
        client.hello()
        client.origin()
        client.speed(1000)
        for point in SQUARE:
            client.point(*point)
        client.end(len(SQUARE))
        assert bytes(fake.received) == expected
        assert fake.objects == [as_packets(SQUARE)]
        assert (client.packets, client.resends) == (9, 0)


def test_spoiled_packets_are_sent_again_until_the_drawing_is_whole():
    points = a_polyline(150)
    with FakePlotter(torn_s=0.15, seed=5) as fake, PlotterClient(fake.path, timeout_s=0.3) as client:
        fake.fault_of_packets = 0.1
        Job(client, [points]).run()
        assert client.resends > 5
        assert [without_repeats(item) for item in fake.objects] == [as_packets(points)]


def test_lost_answers_cost_nothing_but_time():
    points = a_polyline(60)
    with FakePlotter(seed=3) as fake, PlotterClient(fake.path, timeout_s=0.1) as client:
        fake.lose_answers = 0.1
        Job(client, [points, SQUARE]).run()
        assert client.resends > 2
        assert [without_repeats(item) for item in fake.objects if item] == [as_packets(points), as_packets(SQUARE)]


def test_a_refusal_is_told_by_number_and_text():
    with FakePlotter() as fake, PlotterClient(fake.path, timeout_s=0.1) as client:
        with pytest.raises(Refused, match="LINE was refused: error 104, the point lies outside the machine's travel: move or scale the drawing"):
            client.point(True, 4001, 0)


def test_an_alarm_ends_a_drawing():
    with FakePlotter(points_per_s=1) as fake, PlotterClient(fake.path) as client:
        for point in SQUARE:
            client.point(*point)
        threading.Timer(0.2, setattr, (fake, "alarm", 209)).start()
        with pytest.raises(Refused, match="alarm 209") as refusal:
            client.end(len(SQUARE))
        assert refusal.value.number == 209


def test_no_answer_is_a_link_error():
    with FakePlotter() as fake, PlotterClient(fake.path, timeout_s=0.05) as client:
        fake.mute = True
        with pytest.raises(LinkError, match="no answer to REQUEST"):
            client.request()


def test_no_port_is_a_link_error():
    with pytest.raises(LinkError, match="cannot open port /dev/nowhere"):
        PlotterClient("/dev/nowhere")


def test_next_withheld_is_waited_for_and_not_sent_again():
    with FakePlotter(room=2) as fake, PlotterClient(fake.path, timeout_s=0.05) as client:
        threading.Timer(1.5, setattr, (fake, "room", 10)).start()
        begun = time.monotonic()
        for point in SQUARE:
            client.point(*point)
        assert time.monotonic() - begun > 1.4
        assert client.resends == 0
        client.end(len(SQUARE))
        assert fake.objects == [as_packets(SQUARE)]


def test_a_jog_that_happened_is_never_repeated():
    with FakePlotter() as fake, PlotterClient(fake.path, timeout_s=0.1) as client:
        fake.lose_answers = 1.0
        client.jog("UP")
        assert bytes(fake.received).count(bytes.fromhex("380000000038")) == 1
        assert client.status()["y"] == 10


def test_the_log_has_a_line_a_packet_and_an_answer(tmp_path):
    log = tmp_path / "wire.log"
    with FakePlotter() as fake, PlotterClient(fake.path, log=log) as client:
        client.point(False, 644, 314)
    lines = [line.split(" ", 1)[1] for line in log.read_text().splitlines()]
    assert lines == [
        "> MOVE [109, 2, -124, 1, 58, 46]      6d 02 84 01 3a 2e",
        "< NEXT [110]                          6e",
    ]


def test_cancel_is_noticed_while_waiting():
    with FakePlotter(points_per_s=1) as fake, PlotterClient(fake.path) as client:
        for point in SQUARE:
            client.point(*point)
        threading.Timer(0.2, client.cancel).start()
        with pytest.raises(Cancelled):
            client.end(len(SQUARE))
        assert client.stop()["state"] == "idle"


def test_what_remains_begins_with_the_last_point_drawn():
    assert remaining_points(SQUARE, 0) == (SQUARE, 0)
    assert remaining_points(SQUARE, 2) == ([(False, 644, 454), *SQUARE[2:]], 1)
    assert remaining_points(SQUARE + SQUARE, 5) == (SQUARE, 0)
    assert remaining_points(SQUARE, 5) == ([], 0)


def strokes(points):
    """Every line drawn with the pen down, as (from, to)."""
    return [(a[1:], b[1:]) for a, b in zip(points, points[1:]) if b[0] == "l" and a[1:] != b[1:]]


@pytest.mark.parametrize("losses", [0.0, 0.03])
def test_a_drawing_broken_off_again_and_again_is_continued_exactly(tmp_path, losses):
    objects = [a_polyline(40, seed) for seed in range(3)]
    path = tmp_path / "journal"
    drawn = []
    breaks = 0
    for attempt in range(30):
        with FakePlotter(points_per_s=60, seed=attempt) as fake, PlotterClient(fake.path, timeout_s=0.1) as client:
            fake.lose_answers = losses
            journal = Journal(path, "same", 1000)
            if attempt:
                journal.resume_from_file()
            if attempt < 8:
                threading.Timer(0.55, client.cancel).start()
            try:
                Job(client, objects, journal).run()
                finished = True
            except Broken:
                breaks += 1
                finished = False
            drawn += [strokes(points) for points in fake.objects + fake.stopped]
        if finished:
            break
    assert finished and breaks > 2
    wanted = [stroke for points in objects for stroke in strokes(as_packets(points))]
    done = [stroke for part in drawn for stroke in part]
    assert set(done) == set(wanted)
    if not losses:
        assert done == wanted


@pytest.mark.parametrize("room", [10000, 30])
def test_an_unplugged_board_costs_a_second_of_drawing(tmp_path, room):
    """Whether all points are stored before the drawing begins, or it is drawn while they arrive."""
    points = a_polyline(300)
    journal = Journal(tmp_path / "journal", "same", 1000)
    seen = []
    with FakePlotter(points_per_s=60, room=room) as fake, PlotterClient(fake.path, timeout_s=0.1) as client:
        fake.streams = True
        job = Job(client, [points], journal)

        def progress(number, drawn):
            seen.append((drawn, Journal(journal.path, "same", 1000)))
            seen[-1][1].resume_from_file()
            if drawn > 100:
                fake.unplug()

        with pytest.raises(LinkError):
            job.run(progress)
        done = len(fake.drawn_points())
    assert all(drawn == kept.drawn for drawn, kept in seen)
    again = Journal(journal.path, "same", 1000)
    again.resume_from_file()
    kept = again.drawn
    assert 100 < kept <= done < kept + 100
    assert job.progress_text() == f"{kept} of 300 points"
    with FakePlotter() as fake, PlotterClient(fake.path) as client:
        Job(client, [points], again).run()
        lead = points[kept][0]  # a line goes on from the point before it
        assert fake.objects[0][lead:] == as_packets(points)[kept:]


def test_a_journal_that_cannot_be_written_any_more_is_said_once_and_the_drawing_goes_on(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    told = []
    with FakePlotter() as fake, PlotterClient(fake.path) as client:
        journal = Journal(folder / "journal", "same", 1000)
        journal.check_writable()
        folder.rmdir()
        Job(client, [SQUARE, SQUARE], journal, told.append).run()
        assert fake.objects == [as_packets(SQUARE)] * 2
    assert len(told) == 1 and "cannot be written" in told[0]


def test_a_journal_is_tried_before_anything_moves(tmp_path):
    Journal(tmp_path / "journal", "one", 1000).save_progress(3, 4)
    Journal(tmp_path / "journal", "two", 1000).check_writable()
    kept = Journal(tmp_path / "journal", "one", 1000)
    assert kept.is_begun() and (kept.object, kept.drawn) == (0, 0)
    kept.resume_from_file()
    assert (kept.object, kept.drawn) == (3, 4)
    assert not Journal(tmp_path / "journal", "two", 1000).is_begun()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["journal"]
    for path in (tmp_path / "none" / "journal", tmp_path):
        with pytest.raises(Failure, match="cannot be written: .*; --journal names another place"):
            Journal(path, "one", 1000).check_writable()


def test_continuing_something_else_is_refused(tmp_path):
    Journal(tmp_path / "journal", "one", 1000).save_progress(3, 4)
    with pytest.raises(Failure, match="cannot continue: the drawing or its placement"):
        Journal(tmp_path / "journal", "two", 1000).resume_from_file()
    with pytest.raises(Failure, match="nothing to continue"):
        Journal(tmp_path / "none", "two", 1000).resume_from_file()
    (tmp_path / "bad").write_text("{")
    with pytest.raises(Failure, match="cannot be read"):
        Journal(tmp_path / "bad", "two", 1000).resume_from_file()

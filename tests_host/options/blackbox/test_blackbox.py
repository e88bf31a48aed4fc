"""Black boxes of machines that come to grief on the virtual board: each is replayed from its files alone, and goes the same way to the step."""

import copy

import pytest
from black_boxes import CAUSES, COMBINED, Doomed, amid, parked, pieces

from host_tools import boards
from host_tools.cli.blackbox import report_lines
from host_tools.failure import Failure
from host_tools.programs.blackbox import HALTED, LOGGED, Box, pack_files, unpack_files
from host_tools.programs.timeline import board_clock, draw_timeline, lines_of
from host_tools.sim.blackbox import Replay
from passo import errors
from passo.config.boardfile import check

WHY = {"watchdog": "reset", "door_then_reset": "end", "crash": "end", "plotter_stop": "end"}
ALARMS = {
    "limit": errors.ALARM_HARD_LIMIT, "emergency_stop": errors.ALARM_HARD_LIMIT, "starved_link": errors.ALARM_HOST_LOST,
    "reset_amid_an_arc": errors.ALARM_RESET, "interlock": errors.ALARM_INTERLOCK, "probe_missed": errors.ALARM_PROBE_MISSED,
    "probe_touched_then_reset": errors.ALARM_RESET, "power_cut": errors.ALARM_POWER,
    "soft_limit": errors.ALARM_SOFT_LIMIT,
}  # fmt: skip


def replayed(files):
    """(box, replay) of the files as somebody else gets them."""
    box = Box.from_files(unpack_files(pack_files(files)))
    return box, Replay(box, box.settings).run()


@pytest.mark.parametrize("cause", CAUSES)
def test_the_replay_goes_the_same_way_to_the_step(cause):
    files, path = CAUSES[cause]()
    box, replay = replayed(files)
    assert box.why == WHY.get(cause, "alarm") and replay.faults == []
    assert ALARMS.get(cause) in [None, *(row.value for row in box.rows if row.kind == LOGGED)]
    played = replay.path
    assert len(played) > 500
    if box.why == "reset":  # the place of the end is not known: the way goes on to the end of the orders
        assert any(path[at:] == played[: len(path) - at] for at, place in enumerate(path) if place == played[0])
    else:
        assert path[-len(played) :] == played


def of_axes(path, plays, end):
    """Return the axes' places, up to `end`, from the path of motors with backlash: an axis stands while its motor crosses the play."""
    taken, before, found = [0] * len(plays), path[0], []
    for motors in path:
        taken = [max(0, min(play, there + at - was)) for play, there, at, was in zip(plays, taken, motors, before)]
        before = motors
        axes = [at - there for at, there in zip(motors, taken)]
        if not found or found[-1] != axes:
            found.append(axes)
    by = [at - there for at, there in zip(found[-1], end)]
    return [[at - shift for at, shift in zip(axes, by)] for axes in found]


@pytest.mark.parametrize("what", COMBINED)
def test_the_replay_of_what_else_a_machine_may_have(what):
    files, path = COMBINED[what]()
    box, replay = replayed(files)
    played = replay.path
    assert box.why == "alarm" and replay.faults == [] and len(played) > 5000
    if box.board.get("backlash"):
        assert any(box.start().backlash_taken)
        path = of_axes(path, [round(um * axis["steps_per_m"] / 1e6) for um, axis in zip((40, 50, 20), box.board["axes"])], played[-1])
    assert path[-len(played) :] == played


def test_ways_of_parking_are_not_replayed():
    """The list shows them, and the replay says why it stops."""
    files, _ = parked()
    box = Box.from_files(files)
    assert "door on" in "\n".join(lines_of(box))
    with pytest.raises(Failure, match="has parked"):
        Replay(box, box.settings)


def test_a_step_more_or_less_is_found(monkeypatch):
    """The test of the test: a box whose stop is a step off its way, and one with another line, are not followed."""
    files, _ = CAUSES["emergency_stop"]()
    box = Box.from_files(files)
    stop = [row for row in box.rows if row.kind == HALTED][-1]
    stop.position[0] += 1000
    assert Replay(box, box.settings).run().faults
    box = Box.from_files(files)
    before = box.text
    box.text = before.replace(b"G1X3", b"G1X2")
    assert before != box.text and Replay(box, box.settings).run().faults


def test_it_is_off_unless_asked_for_and_off_by_a_word():
    assert check(boards.load("router_3axis")).get("blackbox") is None
    board = check({**copy.deepcopy(boards.load("router_3axis")), "blackbox": False})
    assert "blackbox" not in board["additions"].features and not board["additions"].box


def test_the_text_slides_and_the_newest_is_kept():
    """Some 20 kB of lines: the text has the lines taken last, and those in the queue; all of it fits."""
    doomed = Doomed()
    doomed.stream(pieces(900), amid(doomed, 60_000))
    doomed.press("stop")
    files, path = doomed.boxed()
    box, replay = replayed(files)
    assert box.base > 6144 and 3000 < len(box.text) <= 6144 and replay.faults == []
    assert path[-len(replay.path) :] == replay.path and len(replay.path) > 3000


def test_nothing_is_written_twice():
    """A prompt asked for after an alarm shows the alarm's box, not one of the prompt."""
    doomed = Doomed()
    doomed.stream(pieces(), amid(doomed, 3000))
    doomed.press("stop")
    doomed.machine.run_ms(2000)
    assert [why for why, _, _ in doomed.boxes()] == ["alarm"]
    doomed.machine.app.stop()
    assert [why for why, _, _ in doomed.boxes()] == ["alarm"]


def test_nothing_is_written_while_it_moves():
    """A soft limit comes to its stand first: flash stops the interrupts that make words."""
    doomed = Doomed()
    doomed.machine.send(b"$20=1\n")
    links = doomed.machine.app.controller.features["links"]
    written, keep = [], links._keep
    queue = doomed.machine.app.controller.queue

    def kept(why, *data):
        written.append(queue.still())
        keep(why, *data)

    links._keep = kept
    doomed.stream([*pieces(60), b"G1X400\n"])
    doomed.machine.run_ms(4000)
    assert written == [True]


def test_what_people_read(tmp_path):
    files, _ = CAUSES["door_then_reset"]()
    box, replay = replayed(files)
    text = "\n".join([*lines_of(box), *report_lines(box, replay)])
    for wanted in ("door on", "door off", "hold", "reset, Ctrl-X", "stood at X", "G1X", "> $SLP", "the same way"):
        assert wanted in text, wanted
    draw_timeline(tmp_path / "timeline.png", box, replay)
    draw_timeline(tmp_path / "alone.png", box)
    assert (tmp_path / "timeline.png").stat().st_size > 20_000


@pytest.mark.parametrize("cause", ["soft_limit", "plotter_stop", "starved_link"])
def test_the_picture_has_the_virtual_board_where_the_board_was(cause):
    """A replay begins at the end of a queue of up to 15 s, and waits for a host that has died as long as it can: its own times are seconds off."""
    box, replay = replayed(CAUSES[cause]()[0])
    of = board_clock(box, replay)
    times = of([row[0] for row in replay.rows]).tolist()
    assert times == sorted(times)
    for row in box.samples:
        if row.ms < replay.snapshot.ms:
            continue
        near = [list(place[: len(row.position)]) for ms, (_, *place) in zip(times, replay.rows) if abs(ms - row.ms) < 5]
        assert row.position in near, (row, near[:3])


@pytest.mark.parametrize(
    "name, data, wanted",
    [
        ("blackbox.bin", b"passo blackbox 1 rp2 alarm\n", "not a whole one"),
        ("blackbox.bin", b"what?", "no black box"),
        ("board.py", b"BOARD = open('/etc/passwd')\n", "the board file beside"),
        ("board.py", b"import os\n", "the board file beside"),
        ("board.py", b"BOARD = {'name': 'x'}\n", "the board file beside"),
    ],
)
def test_files_that_are_none_are_refused(name, data, wanted):
    """A file that somebody sends is data: its board file is read, and does not run."""
    files, _ = CAUSES["plotter_stop"]()
    with pytest.raises(Failure, match=wanted):
        Box.from_files({**files, name: data})
    with pytest.raises(Failure, match="passo blackbox has written"):
        unpack_files(b"PK no")

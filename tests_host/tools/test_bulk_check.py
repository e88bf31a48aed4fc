"""The report of `passo check` on a job, computed from arrays of words, beside a look at each edge of the pins; and its memory."""

import platform
import subprocess

import numpy as np
import pytest
from host_tools.prove.gcode_jobs import all_jobs
from running_router import Running

from host_tools import boards, interpreter
from host_tools.build import unix_compiled
from host_tools.build.tree import unix_tree
from host_tools.cli import check
from host_tools.clients.grbl import GrblClient
from host_tools.failure import Failure
from host_tools.sim import job as job_module
from host_tools.sim.job import VirtualJob, strip_guards
from host_tools.sim.job_runner import Resting
from host_tools.sim.track import SPACING_MM, SPEED_TICKS, TICKS_PER_S, Rows, Track

JOBS = all_jobs()
needs_micropython = pytest.mark.skipif(interpreter.micropython_command() is None, reason="there is no MicroPython")


class Edges(Resting):
    """A world that follows each edge of the pins of a STEP/DIR or coil machine."""

    def __init__(self, board, layout, drive, scale):
        Resting.__init__(self, board)
        self.layout, self.drive, self.scale = layout, drive, scale
        self.by_height = len(scale) > 2 and not board["spindle"]["laser"]
        axes = layout.axes
        self.place, self.low, self.high = [0] * axes, [0] * axes, [0] * axes
        self.before = drive.levels() if drive else 0
        self.steps = self.last = 0
        self.fastest = [0.0] * axes
        self.window = 0, [0] * axes
        self.speeds = 0
        self.points = [(False, (0.0,) * axes)]

    def attach(self, tick, names, levels):
        self.inverted = levels

    def edges(self, tick, levels, changed):
        levels ^= self.inverted
        moved = False
        for axis in range(self.layout.axes):
            if self.drive:
                step = self.drive.step_between(axis, self.before, levels & (self.layout.tool_mask - 1))
            else:
                rises = (changed & levels) >> axis & 1
                step = rises * (1 if levels >> (self.layout.motors + axis) & 1 else -1)
            if step:
                moved = True
                self.place[axis] += step
                self.low[axis] = min(self.low[axis], self.place[axis])
                self.high[axis] = max(self.high[axis], self.place[axis])
        self.before = levels & (self.layout.tool_mask - 1)
        if moved:
            self.steps += 1
            self.last = tick
            self.draw(bool(levels & self.layout.tool_mask))
            if tick - self.window[0] >= SPEED_TICKS:
                self.measure(tick)

    def draw(self, lit):
        here = tuple(place / scale for place, scale in zip(self.place, self.scale))
        lowered = here[2] < 0 if self.by_height else lit
        kind, last = self.points[-1]
        if kind != lowered:
            self.points += [(lowered, last), (lowered, here)]
        elif max(abs(a - b) for a, b in zip(here, last)) >= SPACING_MM - 1e-9:
            self.points.append((lowered, here))

    def measure(self, tick):
        minutes = (tick - self.window[0]) / TICKS_PER_S / 60
        self.speeds += 1
        for axis, (now, then) in enumerate(zip(self.place, self.window[1])):
            self.fastest[axis] = max(self.fastest[axis], abs(now - then) / self.scale[axis] / minutes)
        self.window = tick, self.place[:]


def by_edges(name, lines):
    """The same job, byte by byte and edge by edge."""
    from passo.app import App
    from passo.config.boardfile import check as checked
    from passo.machine_builder import make_drive
    from passo.ports.virtual import VirtualPort

    board = checked(strip_guards(boards.load(name)))
    board["links"] = [{**board["links"][0], "protocol": "grbl"}]
    layout, drive, _ = make_drive(board)
    scale = [axis["steps_per_m"] / 1000 for axis in board["axes"]]
    world = Edges(board, layout, None if layout.kind == "step_dir" else drive, scale)
    port = VirtualPort(board, world)
    app = App(board, port)
    line = port.serial(board["links"][0])
    answered = sent = 0
    line.incoming = b"$X\n$20=0\n"
    for _ in range(100):
        app.cycle()
    line.outgoing = b""
    begun = port.now
    lines = list(lines)
    waiting = []
    while lines or waiting:
        while lines and sum(waiting) + len(lines[0]) < 120:
            waiting.append(len(lines[0]) + 1)
            line.incoming += lines.pop(0) + b"\n"
            sent += 1
        app.cycle()
        said = line.outgoing
        line.outgoing = b""
        assert b"error" not in said and b"ALARM" not in said, said
        answered += said.count(b"ok")
        del waiting[: said.count(b"ok")]
    while not app.controller.queue.still():
        app.cycle()
    return world, begun


def assert_same(job, world, begun):
    track = job.track
    assert (track.steps, track.position.tolist()) == (world.steps, world.place)
    assert job.seconds == pytest.approx((world.last - begun) / TICKS_PER_S, abs=0.02)
    assert [round(a * b) for a, b in zip(job.low, world.scale)] == world.low
    assert [round(a * b) for a, b in zip(job.high, world.scale)] == world.high
    assert track.fastest == pytest.approx(world.fastest, rel=0.05, abs=20)
    drawn = [(kind, tuple(place)) for kind, places in track.strokes for place in places.tolist()]
    assert [kind for kind, _ in drawn] == [kind for kind, _ in world.points]
    assert np.allclose([place for _, place in drawn], [place for _, place in world.points])


def plain(lines):
    return [line.replace(" ", "").encode() for line in lines]


@pytest.mark.parametrize("board, name", [
    ("router_3axis", "relief"), ("router_3axis", "drilling"), ("plotter_2014", "tiny"), ("mill_2004", "reversals"),
    ("mks_dlc32", "reversals"),
])  # fmt: skip
def test_the_same_as_edge_by_edge(board, name):
    """In this process and under MicroPython; STEP/DIR, coils, axes reversed."""
    lines = plain(JOBS[name][1])
    world, begun = by_edges(board, lines)
    assert world.steps > 100
    runs = [True, False] if interpreter.micropython_command() else [True]
    for inside in runs:
        job = VirtualJob(board, inside=inside)
        job.run(list(enumerate(lines, 1)))
        assert not job.errors
        assert_same(job, world, begun)


def test_a_board_with_flash_and_radio(tmp_path):
    """Its jobs, its journal and its network take no part."""
    file = tmp_path / "kept.py"
    more = {"journal": {"every_ms": 500}, "jobs": {"language": "grbl"}, "network": {"host": "passo"}}
    file.write_text(f"BOARD = {({**boards.load('router_3axis'), **more})!r}\n")
    for inside in [True, False] if interpreter.micropython_command() else [True]:
        job = VirtualJob(str(file), inside=inside)
        job.run(enumerate([b"G1X2F600"], 1))
        assert not job.errors and job.high[0] == 2


def test_a_pen_on_a_servo(tmp_path):
    file = tmp_path / "pen.py"
    board = boards.load("laser_xy")
    pen = {"tool": {"pin": 6, "on_ms": 420, "off_ms": 120}, "servo": {"pin": 7, "up_us": 1800, "down_us": 1200, "up_ms": 100, "down_ms": 400}}
    file.write_text(f"BOARD = {({**board, 'spindle': {'max_rpm': 1000}, **pen})!r}\n")
    for inside in [True, False] if interpreter.micropython_command() else [True]:
        job = VirtualJob(str(file), inside=inside)
        job.run(enumerate([b"M3S1000", b"G1X2F600", b"M5"], 1))
        assert not job.errors and job.high[0] == 2 and job.seconds > 0.42 + 0.2  # the pen goes down, then the line


@needs_micropython
@pytest.mark.parametrize("name", ["laser_raster", "smooth", "units", "slow"])
def test_the_same_under_both_interpreters(name):
    board, lines = JOBS[name]
    found = []
    for inside in (True, False):
        job = VirtualJob(board, inside=inside)
        job.run(enumerate(plain(lines), 1))
        found.append(job)
    one, other = found
    assert one.seconds == other.seconds and one.track.steps == other.track.steps > 50
    assert one.track.fastest == other.track.fastest and np.array_equal(one.track.samples, other.track.samples)
    assert one.errors == other.errors == []
    for (kind, places), (kind_too, places_too) in zip(one.track.strokes, other.track.strokes, strict=True):
        assert kind == kind_too and np.array_equal(places, places_too)


def test_notes_come_under_both_interpreters():
    lines = [b"G1X2F600", b"$H", b"E1", b"X4M0", b"G38.2Z-1F300", b"G1X0"]
    runs = [True, False] if interpreter.micropython_command() else [True]
    for inside in runs:
        job = VirtualJob("router_3axis", inside=inside)
        job.run(enumerate(lines, 1))
        assert [row[:2] for row in job.errors] == [(3, "E1")]
        assert (job.skipped, job.pauses, job.probes) == ([(2, "$H")], [(4, "X4M0")], [(5, "G38.2Z-1F300")])
        assert job.low == [0, 0, -1] and job.high == [4, 0, 0]


def test_lines_that_fail_end_the_job():
    def lines():
        yield 1, b"G1X2F600"
        raise Failure("line 2: that is no program")

    for inside in (True, False):
        with pytest.raises(Failure, match="^line 2: that is no program$"):
            VirtualJob("router_3axis", inside=inside).run(lines())


@needs_micropython
def test_a_firmware_that_ends_is_a_failure(monkeypatch):
    monkeypatch.setattr(interpreter, "micropython_command", lambda: [*interpreter.python(), "-c", "raise SystemExit('no room')"])
    with pytest.raises(Failure, match="MicroPython has ended: no room"):
        VirtualJob("router_3axis")


@needs_micropython
def test_the_firmware_is_looked_up_once_a_process(monkeypatch):
    asked = []
    monkeypatch.setattr(unix_compiled, "unix_tree", lambda: asked.append(1) or unix_tree())
    unix_compiled.firmware_for.cache_clear()
    for _time in range(3):
        VirtualJob("router_3axis").run([(1, b"G4P0.01")])
    assert len(asked) == 1


@needs_micropython
def test_the_firmware_starts_compiled_where_it_can_and_from_its_sources_elsewhere(monkeypatch):
    found = []
    for can in (True, False):
        if not can:
            monkeypatch.setattr(unix_compiled, "can_load", lambda said, told: False)
        unix_compiled.firmware_for.cache_clear()
        job = VirtualJob("router_3axis")
        job.run(enumerate([b"G21G90", b"G1X9Y4F1500", b"G2X5I-2F900", b"G1X99999"], 1))
        folder, arguments = unix_compiled.firmware_for(tuple(interpreter.micropython_command()), job_module.job_runner.__file__)
        kinds = {path.suffix for path in folder.rglob("*") if path.is_file()}
        assert kinds == ({".mpy"} if arguments[0] == "-m" else {".py"})
        found.append((arguments[0] == "-m", job.seconds, job.track.steps, job.errors, job.track.samples.tolist()))
    unix_compiled.firmware_for.cache_clear()
    (compiled, *one), (other_compiled, *other) = found
    assert compiled == (platform.machine() == "x86_64") and not other_compiled
    assert one == other and one[1] > 50


def test_which_compiled_code_a_micropython_loads():
    told = "MicroPython v1.29.0 on 2026-08-29; mpy-cross emitting mpy v6.3"
    assert unix_compiled.can_load("2822\n", told)
    assert not unix_compiled.can_load("2822", told.replace("6.3", "6.2"))
    assert not unix_compiled.can_load("2822", told.replace("6.3", "7.3"))
    assert not unix_compiled.can_load("774", told)  # another processor
    assert not unix_compiled.can_load("", told) and not unix_compiled.can_load("0", told)


def test_many_errors_are_counted_and_few_are_kept(monkeypatch):
    monkeypatch.setattr(job_module, "MOST_NOTES", 5)
    job = VirtualJob("router_3axis", inside=True)
    job.run((number, b"E1") for number in range(1, 31))
    assert job.error_count == 30 and [row[0] for row in job.errors] == [1, 2, 3, 4, 5]


def test_a_path_that_is_too_long_is_thinned_and_stays_true():
    """Ends of strokes stay; all points kept are places of the whole path; the array does not grow."""
    from passo.config.boardfile import check as checked
    from passo.machine_builder import make_drive

    board = checked(boards.load("router_3axis"))
    layout, _, _ = make_drive(board)
    whole, thin = Track(layout, None, [320, 320, 400], False), Track(layout, None, [320, 320, 400], False)
    thin._path = Rows(5, np.int32, 200)
    thin._path.add_rows(np.array([[1, 0, 0, 0, 0]]))
    thin._measured = Rows(4, np.int64, 50)
    thin._measured.add_rows(np.zeros((1, 4), np.int64))
    right, left = 1 | 8, 1
    for leg in range(40):
        tool = layout.tool_mask if leg % 2 else 0
        levels = (right if leg % 2 else left) | tool
        words = np.full(6400, 1000 << layout.bits | levels, np.uint32)
        for track in (whole, thin):
            track.add_words(leg * 6_400_000, words)
    assert len(thin._path.all_rows()) <= 400 < 2000 < len(whole._path.all_rows())
    assert len(thin._measured.all_rows()) <= 100 < 500 < len(whole._measured.all_rows())
    places = {tuple(place) for _, stroke in whole.strokes for place in stroke.tolist()}
    assert all(tuple(place) in places for _, stroke in thin.strokes for place in stroke.tolist())
    assert [kind for kind, _ in thin.strokes] == [kind for kind, _ in whole.strokes]
    farthest = max(abs(one[0] - other[0]).max() for (_, one), (_, other) in zip(thin.strokes, whole.strokes))
    assert farthest <= thin._apart[0] / 320
    assert thin.fastest == whole.fastest and thin.steps == whole.steps
    assert thin.samples[:, 1].max() == pytest.approx(whole.samples[:, 1].max(), rel=0.02)


def test_strokes_that_are_too_many_are_joined(monkeypatch):
    """The long ones stay, in their kind; their number is bounded, and bounds, steps and speeds are the same."""
    from host_tools.sim import track as track_module
    from passo.config.boardfile import check as checked
    from passo.machine_builder import make_drive

    layout, _, _ = make_drive(checked(boards.load("router_3axis")))
    tracks = [Track(layout, None, [320, 320, 400], False) for _ in range(2)]
    long = []
    for number, most in enumerate((10_000, 100)):
        monkeypatch.setattr(track_module, "MOST_STROKES", most)
        tracks[number]._path = Rows(5, np.int32, 1000)
        tracks[number]._path.add_rows(np.array([[1, 0, 0, 0, 0]]))
        for leg in range(1500):
            steps = 6400 if leg % 100 == 50 else 320 + 7 * (leg % 5)
            tool = layout.tool_mask if leg % 2 or steps == 6400 else 0
            if steps == 6400 and not number:
                long.append((tracks[number].position[0] + 3200) / 320)
            words = np.full(steps, 1000 << layout.bits | 1 | 8 | tool, np.uint32)
            tracks[number].add_words(tracks[number].last_tick + 1000, words)
    whole, joined = tracks
    assert len(whole.strokes) > 1400 and len(joined.strokes) < 300 and len(joined._path.all_rows()) <= 1500
    kinds = [kind for kind, _ in joined.strokes]
    assert all(one != other for one, other in zip(kinds, kinds[1:]))
    for middle in long:
        (kind,) = [kind for kind, rows in joined.strokes if rows[0, 0] <= middle < rows[-1, 0]]
        assert kind
    assert (joined.high, joined.steps, joined.fastest) == (whole.high, whole.steps, whole.fastest)


def test_check_as_stream_will_meet_the_machine(tmp_path, capsys):
    """The check uses the machine's own travel, offsets and place: a job that fits at one place of the workpiece is refused at another."""
    file = tmp_path / "job.gcode"
    file.write_bytes(b"G21G90\nG1X100F5000\nX0\n")
    with Running("fast") as running:
        with GrblClient(running.line.name) as client:
            client.connect()
            client.command("$H", 60)
            for line in ("G21", "G10L2P1X150", "$110=3000", "G53G0X20Y10"):
                client.command(line)
            client.wait_idle()
        check.check(file, "router_3axis", None, None, running.line.name)
        said = capsys.readouterr().out
        assert "20.000 …   250.000 mm, up to 3000 mm/min" in said and "Y          10.000 …    10.000" in said
        file.write_bytes(b"G21G90\nG1X100F5000\nX290\n")
        with pytest.raises(Failure, match="line 3, X290: alarm 2"):
            check.check(file, "router_3axis", None, None, running.line.name)
        with pytest.raises(Failure, match="give one of them"):
            check.check(file, "router_3axis", None, "1,2,3", running.line.name)


MEASURE = """
import resource, sys
from pathlib import Path
from host_tools.cli.check import check
check(Path(sys.argv[1]), "router_3axis", Path(sys.argv[2]) if sys.argv[2:] else None, None)
print("kB", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def _relief(path, count):
    from math import cos, sin

    with open(path, "w") as out:
        out.write("G21 G90\nG0 Z1\nG1 Z0 F400\n")
        for number in range(count):
            row, column = divmod(number, 1000)
            x = 0.2 * (column if row % 2 == 0 else 999 - column)
            out.write(f"G1 X{x:.3f} Y{row % 600 * 0.3:.3f} Z{0.4 * sin(x) * cos(row * 0.6) - 0.5:.3f} F2250\n")


@pytest.mark.slow
def test_memory_is_flat_from_2_000_to_200_000_lines(tmp_path, show):
    used = {}
    for count in (2_000, 32_000, 200_000):
        _relief(tmp_path / "relief.gcode", count)
        for picture in ([], [tmp_path / "relief.png"]):
            said = subprocess.run(
                [*interpreter.python(), "-c", MEASURE, tmp_path / "relief.gcode", *picture], capture_output=True, text=True
            )
            assert said.returncode == 0, said.stderr
            used[count, bool(picture)] = [int(part) / 1024 for part in said.stdout.split("kB")[1].split()]
    rows = [f"{count} lines, {'with' if drawn else 'without'} a picture: {mb}" for (count, drawn), mb in used.items()]
    show("memory of passo check in MB: itself, its largest child", "\n".join(rows))
    assert used[200_000, False][0] < used[2_000, False][0] * 1.05
    assert used[200_000, True][0] < used[2_000, True][0] * 1.4
    assert used[200_000, True][1] < used[2_000, True][1] * 1.05


@pytest.mark.parametrize("name", ["router_3axis", "laser_xy"])
def test_what_a_full_queue_leaves_out_changes_nothing(name, monkeypatch):
    """While the queue is full only the player goes on: words, times and errors are those of a run with every cycle."""
    z = "Z" if name == "router_3axis" else "S"
    lines = [b"G21G90", b"G1X20Y20F%d" % 1500]
    for number in range(450):
        x, y = 20 + 5 * np.cos(number / 25), 20 + 5 * np.sin(number / 25)
        lines.append(f"G1X{x:.3f}Y{y:.3f}{z}{1 + number % 3 / 10:.1f}".encode())
        lines += {120: [b"M3S500"], 240: [b"G4P0.3"], 300: [b"G1X9999999"], 360: [b"M0"], 420: [b"G2X15Y20I-5J0F9000"]}.get(number, [])
    found = []
    for full in (job_module.job_runner._FULL, 1 << 20):
        monkeypatch.setattr(job_module.job_runner, "_FULL", full)
        job = VirtualJob(name, inside=True)
        words, take = [], job.track.add_words
        monkeypatch.setattr(job.track, "add_words", lambda tick, block: (words.append((tick, block.copy())), take(tick, block)))
        job.run(enumerate(lines, 1))
        found.append((words[0][0], np.concatenate([block for _, block in words]).tolist(), job.errors, job.pauses, job.seconds))
    one, other = found
    assert one == other and len(one[1]) > 10000 and one[2] and one[3]

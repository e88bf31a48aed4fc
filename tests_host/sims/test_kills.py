"""The link, the PC's program, the main loop, the power killed at random moments: the same is cut as if nothing had happened."""

import io

import pytest

from host_tools.cli import lead_in
from host_tools.clients.grbl import GrblClient
from host_tools.failure import Failure
from host_tools.programs import gcode_file
from kill_jobs import JOBS, Job
from kills import KINDS, Bench, Course, Flash, Killed, Pc, kill_of, killed, kills_of, resume_file

THOUSAND = 1000
EACH = -(-THOUSAND // len(JOBS))
BEFORE = KINDS[:6]  # of the seeds below
# Seeds that have found something, and what.
FOUND = {
    "stored": ["s stored 23"],  # a stored job on a link that is watched ended the main loop; a silent PC was lost while a spindle spun up
    "laser": ["s laser 7"],
}


def wrong(results):
    return [f"{kill}: {text}; {story}" for kill, text, story in results if text]


@pytest.mark.parametrize("name", JOBS)
def test_killed(name):
    number = list(JOBS).index(name)
    kills = kills_of(2, f"few {name}", 2 * number) + [kill_of(seed, BEFORE[int(seed.split()[-1]) % 6], BEFORE) for seed in FOUND.get(name, ())]
    results = killed(JOBS[name], kills)
    assert len(results) == len(kills) and not wrong(results)


@pytest.mark.parametrize("name", ["lines", "laser"])
def test_a_supply_that_fails_with_a_warning_loses_nothing(name):
    """The place is written while the capacitors last: nothing is cut twice."""
    results = killed(JOBS[name], [kill_of(f"warned {name}", "fail", ["fail"])])
    assert len(results) == 1 and not wrong(results)


@pytest.mark.slow
@pytest.mark.parametrize("name", JOBS)
def test_killed_a_thousand_times(name):
    results = killed(JOBS[name], kills_of(EACH, f"thousand {name}"))
    assert len(results) == EACH and not wrong(results)


class Interrupted:
    """A program that is cut off at a share of its time, on a board that goes on alone."""

    def __init__(self, text, tmp_path, begun_s, kind="process", **changes):
        self.course = Course(Job(text, **changes), tmp_path)
        self.pc = self.course.pc
        with self.pc:
            self.course.begin()
            self.pc.kills = [(self.course.bench.machine.now_ms() + 1000 * begun_s, kind)]
            self.pc.strike = lambda _: self.pc.die()
            with pytest.raises(Killed):
                self.course.run()
        self.course.bench.alone()

    def resume(self, yes=True):
        self.pc.revive(self.course.bench)
        with self.pc:
            resume_file(self.course.path, yes=yes)
            self.course.bench.machine.settle()

    def place(self):
        return self.course.bench.machine.app.controller.position()


SQUARE = b"G21G90\nG1Z-1F1500\nG1X10F1500\nY10\nX0\nY0\nM30\n"


def test_a_program_that_had_not_begun_begins_where_it_would_have(tmp_path):
    """The power goes before its first line; the machine homes, and relative lines still lead from where it stood."""
    bench = Bench(Job(b"G91G21\nG1X3Y2F900\nM30\n"), Flash(tmp_path))
    path = tmp_path / "job.nc"
    path.write_bytes(bench.job.text)
    pc = Pc(bench)
    with pc:
        with GrblClient("memory") as client:
            client.connect()
            client.command("$H", 600)
            client.command("G90G0X5Y4Z-2")
            client.command("G4P0")
            lead_in.announce_program(client, gcode_file.read(path), path.name)
        stood = bench.machine.app.controller.position()
        after = bench.reboot()
        pc.revive(after)
        resume_file(path, home=True, yes=True)
        after.machine.settle()
    assert after.machine.app.controller.position() == [stood[0] + 3 * 320, stood[1] + 2 * 320, stood[2]]


def test_what_is_left_of_a_line_is_that_line_to_the_journal(tmp_path):
    """Interrupted once more amid it, the program is gone on with there."""
    long = Interrupted(b"G21G90\nG1Z-1F1500\nG1X20F400\nY5\nM30\n", tmp_path, 1.2)
    first = long.place()[0]
    now_ms = int(long.course.bench.machine.now_ms())
    long.pc.kills = [(at_ms, None) for at_ms in range(now_ms, now_ms + 20_000, 50)]
    long.pc.strike = lambda _: long.pc.die() if long.place()[0] > first + 300 else None
    with pytest.raises(Killed):
        long.resume()
    long.pc.kills = []
    long.course.bench.alone()
    second = long.place()
    long.course.bench.machine.send(b"$JR\n")
    long.course.bench.machine.run_ms(50)
    assert first + 300 < second[0] < 6400
    assert b"|3|2|%d,0,-400]" % second[0] in long.course.bench.machine.take()
    long.resume()
    assert long.place() == [6400, 1600, -400]


@pytest.mark.parametrize("framed", [False, True])
def test_a_line_that_another_program_has_not_ended_is_not_carried_out(framed, tmp_path):
    """The cable fails amid `X22`: `X2` has come."""
    job = Job(SQUARE)
    job.of_link = lambda: {"frames": framed}
    bench = Bench(job, Flash(tmp_path))
    pc = Pc(bench)
    with pc:
        with GrblClient("memory") as client:
            client.command("$X")
            client._write_bytes(b"G1F600X2")
            bench.machine.run_ms(100)
            pc.dead = True  # its port is never closed in order
        pc.revive(bench)
        with GrblClient("memory") as client:
            assert client.framed == framed
            assert client.command("$G")[0].startswith("[GC:")
            assert bench.machine.app.controller.position() == [0, 0, 0]


def test_a_machine_that_stopped_in_order_is_gone_on_with_where_it_stands(tmp_path):
    """A host is lost: alarm 250, and the position is kept. Nothing homes."""
    square = Interrupted(SQUARE, tmp_path, 1.0)
    assert square.course.bench.machine.app.controller.state == "alarm"
    switched = []
    square.course.bench.machine.plant.listen(lambda *change: switched.append(change))
    square.resume()
    assert square.place() == [0, 0, -400] and not switched


@pytest.mark.parametrize("stopped", ["nobody", "no", "Ctrl-C"])
def test_the_tool_stays_up_and_the_spindle_goes_off_unless_somebody_agrees(stopped, tmp_path, monkeypatch):
    def answer(*_):
        assert square.course.bench.machine.plant.tool, "it is asked with the spindle on"
        if stopped == "Ctrl-C":
            raise KeyboardInterrupt
        return False

    square = Interrupted(b"M3S1000\n" + SQUARE, tmp_path, 1.5)
    if stopped != "nobody":
        monkeypatch.setattr(lead_in, "operator_agrees", answer)
    with pytest.raises(Failure):
        square.resume(yes=False)
    square.course.bench.machine.settle()
    assert square.place()[2] == 0 and not square.course.bench.machine.plant.tool


class Operator(io.StringIO):
    """Looks at the machine for a while, then types."""

    def __init__(self, text, pc, looks):
        super().__init__(text)
        self._pc = pc
        self.looks = looks

    def isatty(self):
        return True

    def select(self, *_):
        self.looks -= 1
        if self.looks < 0:
            return [self], [], []
        self._pc.sleep(0.3)
        return [], [], []


@pytest.mark.parametrize("typed", ["y", "n"])
def test_a_board_that_minds_its_host_waits_for_the_operator(typed, tmp_path, monkeypatch):
    square = Interrupted(b"M3S1000\n" + SQUARE, tmp_path, 1.5)
    operator = Operator(typed + "\n", square.pc, 30)
    monkeypatch.setattr(lead_in, "sys", type("", (), {"stdin": operator}))
    monkeypatch.setattr(lead_in, "select", operator)
    if typed == "y":
        square.resume(yes=False)
        assert square.place() == [0, 0, -400]
    else:
        with pytest.raises(Failure, match="spindle and coolant are off"):
            square.resume(yes=False)
    assert operator.looks == -1 and not square.course.bench.machine.plant.tool


def test_numbers_of_its_own(tmp_path):
    """Lines are sent with their numbers in the file; the values of N words, and repeated ones, do not matter."""
    lines = [b"N%d%s" % (10 * number, line) for number, line in enumerate(SQUARE.split(), 3)]
    square = Interrupted(b"\n".join(lines) + b"\n", tmp_path, 1.5, lost="go_on")
    square.resume()
    assert square.place() == [0, 0, -400]
    same = Interrupted(b"".join(b"N7%s\n" % line for line in SQUARE.split()), tmp_path, 1.5)
    same.resume()
    assert same.place() == [0, 0, -400]


@pytest.mark.parametrize(("change", "said"), [
    (b"G10L2P1X5\n", "relies on G54, which the program changes"),
    (b"G10L20P1X0\n", "relies on G54, which the program changes"),
    (b"G10L2P2X5\n", None),
    (b"G28.1\n", None),
])  # fmt: skip
def test_offsets_that_the_program_changes_behind_its_place(change, said, tmp_path):
    """The board has read the line that changes them before the lines ahead of it have been played."""
    text = b"G21G90\nG1Z-1F1500\nG1X10F1500\nY10\n" + change + b"X0\nY0\nM30\n"
    square = Interrupted(text, tmp_path, 0.5)
    if said:
        with pytest.raises(Failure, match=said):
            square.resume()
    else:
        square.resume()
        assert square.place() == [0, 0, -400]


@pytest.mark.parametrize(("text", "said"), [
    (b"G21G91\nG1X5Y5F600\nG1X10\nG1Y10\nM30\n", "where X stood when the program began is not known"),
    (b"G21G90\nG92X0\nG1X5Y5F300\nM30\n", "where X stood when the program began is not known"),
    (b"G21G90\nG1X5Y5F300\nG1X7\nM30\n", None),
])  # fmt: skip
def test_where_it_began_is_not_known(text, said, tmp_path):
    square = Interrupted(b"G1Z-1F600\n" + text, tmp_path, 0.8)
    if said:
        with pytest.raises(Failure, match=said):
            square.resume()
    else:
        square.resume()


def test_a_machine_that_only_checks_is_not_gone_on_with(tmp_path):
    square = Interrupted(SQUARE, tmp_path, 1.5, lost="go_on")
    square.course.bench.machine.send(b"$C\n")
    square.course.bench.machine.run_ms(50)
    with pytest.raises(Failure, match="its state is Check"):
        square.resume()

"""Jobs that wait for one another: the next one begins by itself only if no tool is to be changed in between."""

import pytest

from host_tools.page.orders import PanelOrders
from host_tools.panel import job_facts
from host_tools.panel.store import Store, gcode_lines
from panel_desk import Desk
from passo import errors

JOBS = {"plain.gcode": "G21G91\nG0X1\n", "one.gcode": "G21G91\nT1M6\nG0X1\n", "again.gcode": "G21G91\nT1M6\nG0Y1\n", "two.gcode": "G21G91\nT2M6\nG0Y1\n",
        "wrong.gcode": "G21G91\nG0X1\nG77\n"}  # fmt: skip


class Bench:
    def __init__(self, folder, facts=job_facts.gcode_facts):
        self.desk = made = Desk()
        self.store = Store(folder / "jobs", gcode_lines, facts=facts)
        for name, text in JOBS.items():
            assert self.store.put_job(name, text) == 0
        made.store, made.api = self.store, PanelOrders(made.machine, self.store)

    def ask(self, what, **more):
        return self.desk.order("queue", what=what, **more)

    def put(self, *names):
        for name in names:
            assert self.ask("add", name=name + ".gcode") == 0

    @property
    def state(self):
        return self.desk.machine.state["queue"]

    def run_ms(self, ms):
        """The operator puts each tool in."""
        for _ in range(ms // 50):
            self.desk.run_ms(50)
            self.desk.api.poll()
            if self.desk.machine.state["state"] == "Hold" and self.desk.machine.state["why"]:
                assert self.desk.order("resume") == 0

    def done(self):
        """(jobs left, why it waits, the tool) once nothing runs."""
        self.run_ms(4000)
        return [name[:-6] for name in self.state["jobs"]], self.state["waits"], self.state["tool"]


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


def test_jobs_of_one_tool_follow_one_another(bench):
    bench.put("one", "plain", "again")
    before = bench.desk.place()
    assert bench.ask("run") == 0 and bench.state["on"]
    assert bench.done() == ([], "", "") and not bench.state["on"]
    assert [now - then for now, then in zip(bench.desk.place(), before)][:2] == [640, 320]


def test_another_tool_is_asked_for(bench):
    bench.put("one", "two", "plain")
    assert bench.ask("run") == 0
    assert bench.done() == (["two", "plain"], "tool", "T2")
    bench.run_ms(2000)
    assert bench.state["jobs"] == ["two.gcode", "plain.gcode"], "it does not begin without a word"
    assert bench.ask("run") == 0
    assert bench.done() == ([], "", "")


def test_a_job_that_fails_or_is_ended_stops_the_queue(bench):
    bench.put("wrong", "plain")
    assert bench.ask("run") == 0
    assert bench.done() == (["plain"], "", "") and not bench.state["on"]
    assert bench.desk.machine.state["job"]["how"] == "failed"
    assert bench.ask("run") == 0
    assert bench.desk.order("abort") == 0
    bench.put("plain")
    assert bench.done() == (["plain"], "", "") and not bench.state["on"]


def test_a_language_without_tools_asks_each_time(tmp_path):
    bench = Bench(tmp_path, facts=None)
    bench.put("plain", "plain")
    assert bench.ask("run") == 0
    assert bench.done() == (["plain"], "asks", "")


def test_it_is_put_in_order_and_emptied(bench):
    bench.put("one", "two", "plain")
    assert bench.ask("down", at=0, name="one.gcode") == 0 and bench.ask("up", at=2, name="plain.gcode") == 0
    assert [name[:-6] for name in bench.state["jobs"]] == ["two", "plain", "one"]
    assert bench.ask("remove", at=0, name="two.gcode") == 0
    assert bench.ask("remove", at=0, name="two.gcode") == errors.NO_SUCH_JOB, "another page was first"
    assert bench.ask("clear") == 0 and bench.state["jobs"] == []
    assert bench.ask("run") == errors.NO_SUCH_JOB
    assert bench.ask("add", name="none.gcode") == errors.NO_SUCH_JOB and bench.ask("sing") == errors.ORDER_FIELD
    assert bench.ask("up", at=70, name="one.gcode") == errors.ORDER_FIELD
    bench.put(*["plain"] * 50)
    assert bench.ask("add", name="plain.gcode") == errors.JOB_SIZE


def test_what_is_in_it_may_go(bench):
    """A job that is deleted meanwhile is named, and the others wait until it is out of the queue."""
    bench.put("plain", "two", "one")
    (bench.store._folder / "two.gcode").unlink()
    assert bench.ask("run") == 0
    assert bench.done() == (["two", "one"], "gone", "")
    assert bench.ask("run") == errors.NO_SUCH_JOB
    assert bench.ask("remove", at=0, name="two.gcode") == 0 and bench.ask("run") == 0
    assert bench.done() == ([], "", "")


def test_nobody_at_the_machine(bench):
    """If the board wants the operator there, the next job does not begin by itself."""
    bench.put("plain", "plain")
    assert bench.ask("run") == 0
    bench.desk.machine.presence_error = lambda: errors.PRESENCE
    assert bench.done() == (["plain"], "asks", "")
    page = {"do": "queue", "what": "run"}
    assert bench.desk.api.answer_order(page, True, remote=True)["error"] == errors.PRESENCE

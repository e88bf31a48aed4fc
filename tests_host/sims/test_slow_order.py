"""Work that takes a moment is done beside the panel's loop: no order waits for it, STOP above all, and orders that come meanwhile count."""

import asyncio
import json
import threading

import pytest

from host_tools.page.orders import PanelOrders
from host_tools.panel import job_facts
from host_tools.panel.panel import FOLDER
from host_tools.panel.server import Server
from host_tools.panel.store import Store, gcode_lines
from panel_desk import Desk
from panel_process import PanelProcess
from passo import errors

JOB = "G21G91\nF3000\n" + "G1X1\nG1X-1\n" * 1000
PIECE = 30_000
CURVES = '<svg xmlns="http://www.w3.org/2000/svg" width="180mm" height="100mm" viewBox="0 0 180 100">{}</svg>'.format("".join(
    f'<path d="M{5 + n % 40 * 4} {5 + n // 40 * 2}c1 3 2 -3 3 0" fill="none" stroke="black"/>' for n in range(1600)))


@pytest.fixture
def desk(tmp_path):
    made = Desk()
    made.store = Store(tmp_path / "jobs", gcode_lines, facts=job_facts.gcode_facts)
    for name in ("one.gcode", "two.gcode"):
        assert made.store.put_job(name, "G21G91\nG1X5F3000\n") == 0
    made.api = PanelOrders(made.machine, made.store)
    return made


def begin(desk, do, **fields):
    """(the answer so far, its work's result): the work is done, and its result not yet seen."""
    answer = desk.api.begin({"do": do, **fields}, True)
    return answer, answer["error"].work()


@pytest.mark.parametrize("do, fields", [("run", {"name": "one.gcode"}), ("queue", {"what": "run"})])
def test_a_job_that_is_being_read_does_not_begin_behind_stop(desk, do, fields):
    assert desk.order("queue", what="add", name="one.gcode") == 0
    before, begun = desk.place(), begin(desk, do, **fields)
    assert desk.order("stop") == 0
    assert desk.api.finish(*begun)["error"] == errors.STOPPED
    desk.settle()
    assert desk.place() == before
    assert desk.api.finish(*begin(desk, do, **fields))["error"] == 0
    desk.settle()
    assert desk.place() != before


def test_a_slow_drawing_holds_run_of_its_own_job_only(desk, tmp_path):
    """Another job runs meanwhile; the one that the drawing becomes waits for it, and is the new one."""
    over, svg = threading.Event(), "map.svg"

    def made(name, text):
        assert not name.endswith(".svg") or over.wait(30)
        return (name + ".gcode" if name.endswith(".svg") else name), text

    desk.api.store = store = Store(tmp_path / "jobs", gcode_lines, made, facts=job_facts.gcode_facts)
    assert store.put_job(svg + ".gcode", "G21G91\nG1X1F3000\n") == 0
    server = Server(desk.api, "A" * 16, {"127.0.0.1"}, str(FOLDER))

    def later(do, **fields):
        return desk.api.begin({"do": do, **fields}, True)["error"]

    async def play():
        piece = later("job_part", name=svg, at=0, text="G21G91\nG1X7F3000\n", last=True)
        slow = [asyncio.ensure_future(server.result_of(work)) for work in (piece, later("job_about", name="one.gcode"))]
        await asyncio.sleep(0)
        for do, fields in (("run", {}), ("queue", {"what": "add"})):
            found = await asyncio.wait_for(server.result_of(later(do, name="two.gcode", **fields)), 20)
            assert b"G1X5F3000" in str(found).encode()
        own = asyncio.ensure_future(server.result_of(later("run", name=svg + ".gcode")))
        await asyncio.sleep(0.1)
        assert not own.done() and not any(each.done() for each in slow)
        over.set()
        assert b"G1X7F3000" in (await asyncio.wait_for(own, 20))[1][1]
        assert await slow[0] == 0 and (await slow[1])["lines"] == 2

    try:
        asyncio.run(play())
    finally:
        over.set()


def test_what_has_begun_meanwhile_is_looked_at(desk):
    begun = begin(desk, "run", name="one.gcode")
    assert desk.order("run", name="two.gcode") == 0
    assert desk.api.finish(*begun)["error"] == errors.BUSY
    desk.settle()


def test_the_next_of_a_queue_that_is_being_read_does_not_begin_behind_stop(desk):
    works = []
    desk.machine.beside = lambda work, then: works.append((work, then))
    for name in ("one.gcode", "two.gcode"):
        assert desk.order("queue", what="add", name=name) == 0
    assert desk.order("queue", what="run") == 0
    while not works:
        desk.run_ms(50)
        desk.api.poll()
    assert desk.machine.state["queue"]["on"]
    before, (work, then) = desk.place(), works[0]
    assert desk.order("stop") == 0
    then(work())
    desk.settle()
    assert desk.place() == before and not desk.machine.state["queue"]["on"]


def test_a_loop_that_has_stood_is_no_board_that_is_silent(desk):
    """Only a question that stays unanswered for silent_ms says so: a loop that stood for longer has asked nothing."""
    machine, told = desk.machine, []
    machine.wire.write = told.append
    desk.run_ms(0)
    machine.report({"state": "idle", "substate": "", "fields": {"MPos": "0,0,0", "FS": "0,0"}})
    now = desk.now_ms() + 10 * machine.silent_ms
    machine.poll(now)
    assert machine.state["link"] and told
    machine.poll(now + machine.silent_ms)
    assert machine.state["link"]
    machine.poll(now + machine.silent_ms + 1)
    assert not machine.state["link"]


@pytest.mark.unmeasured
@pytest.mark.xdist_group("panel")
def test_a_drawing_is_made_while_a_job_runs(tmp_path):
    """Lines of the job go on, and another page is answered, until the job that the drawing becomes is there."""
    with PanelProcess(tmp_path) as panel:
        page, other = panel.page().ready(), panel.page()
        page.put("work.gcode", JOB)
        assert page.order("run", name="work.gcode")["error"] == 0
        for at in range(0, len(CURVES) - PIECE, PIECE):
            assert page.order("job_part", name="drawing.svg", at=at, text=CURVES[at : at + PIECE])["error"] == 0
        page.socket.send(page.message({"do": "job_part", "name": "drawing.svg", "at": at + PIECE, "text": CURVES[at + PIECE :], "last": True}))
        asked, lines = page.count, []

        def answered():
            message = page.hear()
            if message["t"] == "state":
                lines.append(message["line"])
            return message.get("id") == asked

        others = 0
        while not answered():
            others += other.order("jobs")["t"] == "jobs"
        assert others > 5 and len(set(lines)) > 2, (others, lines)  # of a loop that waits: 1 and 2
        page.socket.send(page.message({"do": "job_part", "name": "again.svg", "at": 0, "text": CURVES[:PIECE], "last": True}))
        page.socket.send(f"{page.count + 1}.{'0' * 64}." + json.dumps({"do": "jobs", "id": page.count + 1}))
        assert page._find(lambda message: message["t"] == "answer")["id"] == page.count + 1, "the refusal must have the number of its order"
        assert page._find(lambda message: message.get("id") == page.count)["error"] == errors.DRAWING
        assert other.order("stop")["error"] == 0
        assert ["drawing.svg.gcode"] == [name for name, _ in other.order("jobs")["jobs"] if "drawing" in name]

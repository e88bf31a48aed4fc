"""A router and a laser on an emulated Pico W with Passo's UF2: pages open, lines streamed over USB, stored jobs and journal, all at once.

`make uf2 CHIP=rp2040_w` builds it; without one of this source these tests skip, and say so. Connections come over a UART in the place of the
radio: the memory of its driver and lwIP lies outside of MicroPython's heap, and this UF2 has taken it from the heap.
"""

import gzip
import sys
from pathlib import Path

import pytest
from air import RADIO, Air, Page
from check_jobs import stored_form
from emulated import uf2  # noqa: F401
from umqtt_here import UMQTT, needs_umqtt

from host_tools import boards
from host_tools.build.frozen import compile_beside
from host_tools.build.pages import texts_of
from host_tools.emulator.binary import Unavailable
from host_tools.emulator.frozen import find_frozen, frozen_machine
from host_tools.emulator.heap import Heap
from host_tools.emulator.queries import Asking
from passo import errors
from passo.protocols.plotter.host import COMMANDS, packet

pytestmark = pytest.mark.slow
BROKER_SOCKET = Path(__file__).with_name("broker_socket.py")
LEAST = 45_000  # bytes free, at any time
LEAST_TOLD = 40_000  # the same with umqtt, what it says, and the texts of alarms
LINES = 3000
JOB_BYTES = 4000
SLOWER = 230_400  # bytes come: the interrupt that makes words may last longer than 32 of them at full pace
# In front of main.py, which is frozen.
_RADIO = b"""
import sys
import uart_radio
sys.modules["passo.web.radio"] = uart_radio
"""


@pytest.fixture(scope="session")
def frozen_w(uf2):  # noqa: F811
    """The UF2. The test skips, loudly, where there is none."""
    try:
        return find_frozen("rp2040_w")
    except Unavailable as reason:
        print(f"\nNOT TESTED WITH PASSO'S UF2 FOR THE PICO W: {reason}", file=sys.__stderr__)
        pytest.skip(f"NOT TESTED WITH PASSO'S UF2 FOR THE PICO W: {reason}")


def on_the_air(board, uf2, boot=_RADIO, more=None):
    """(machine, air) of a board file, by name or as a table, with this radio. `more`: {path: text} of other modules."""
    files = {"boot.py": boot, **compile_beside("rp2040_w", {RADIO.name: RADIO.read_text(), **(more or {})})}
    machine = frozen_machine(board if isinstance(board, dict) else boards.load(board), uf2, files, trace=None).boot()
    machine.pico.console.expect(b"code in", 8_000_000)
    machine.run_ms(300)
    return machine, Air(machine, SLOWER)


def streamed(board):
    """Lines to and fro, at the speed the axes of the board file do."""
    laser = board["spindle"]["laser"]
    head = [b"$X\n", b"G21G91G94\n", b"M4S0F6000\n" if laser else b"M3S12000\n", b"G1F6000\n"]
    there = [b"G1X0.4Y0.3S%d\n" % (100 + line % 800) if laser else b"G1X0.4Y0.3Z-0.02\n" for line in range(20)]
    back = [line.replace(b"X0.4Y0.3", b"X-0.4Y-0.3").replace(b"Z-0.02", b"Z0.02") for line in there]
    return head + (there + back) * (LINES // 40)


@pytest.mark.parametrize("board", ["router_pico_w", "laser_pico_w"])
def test_all_at_once(frozen_w, board, show):
    machine, air = on_the_air(board, frozen_w)
    begun = Heap(machine.pico, True)
    sender = Asking(machine, machine.board["links"][0]["name"])
    sender.stream_lines(streamed(machine.board))
    pages = [Page(air), Page(air)]
    for page in pages:
        page.until(lambda page=page: page.state.get("state") == "Run", 10_000)
    pushed, since = [page.pushes for page in pages], machine.now_ms()
    heaps, took, asked = [], [], []
    for name in ("/", "/panel.js", "/") * 3:
        body, ms = air.answer(air.get(name), 8000)
        assert gzip.decompress(body) == texts_of(machine.board)[name[1:] or "index.html"]
        took.append(ms)
        asked.append(sender.ask_status())
        answer, _ = pages[0].order("log")
        assert answer["log"] == [], "no word is late, no memory is wanting"
        heaps.append(Heap(machine.pico, True))
        for page in pages:
            page.look()
    assert pages[0].state["state"] == "Run", "all the while"
    passed = (machine.now_ms() - since) / 1000
    pushes = [(page.pushes - before) / passed for page, before in zip(pages, pushed)]
    least, piece = min(heap.free for heap in heaps), min(heap.largest for heap in heaps)
    show(
        f"{board} on a Pico W, two pages open, lines streamed over USB",
        f"{begun.free} of {begun.total} bytes free before ({begun.largest} in one piece), {least} at least ({piece} in one piece) over {passed:.1f} s; {sender.said.count(b'ok')} lines; files in "
        f"{min(took):.0f} to {max(took):.0f} ms; `?` within {max(asked):.1f} ms; {pushes[0]:.1f} and {pushes[1]:.1f} states a second",
    )
    assert b"error" not in sender.said and least >= LEAST and min(pushes) >= 2
    assert not machine.plant.errors


@needs_umqtt
def test_a_broker_is_told_beside_two_pages_and_stops_the_machine(frozen_w, show):
    board = boards.load("router_pico_w")
    modules = {BROKER_SOCKET.name: BROKER_SOCKET.read_text(), "umqtt/simple.py": (UMQTT / "umqtt" / "simple.py").read_text()}
    without, _air = on_the_air(board, frozen_w)
    board["network"] = {**board["network"], "broker": "192.168.4.9"}
    machine, air = on_the_air(board, frozen_w, _RADIO + b'import broker_socket\nsys.modules["socket"] = broker_socket\n', modules)
    begun, before = Heap(machine.pico, True), Heap(without.pico, True)
    sender = Asking(machine, machine.board["links"][0]["name"])
    sender.stream_lines(streamed(machine.board))
    pages = [Page(air), Page(air)]
    for page in pages:
        page.until(lambda page=page: page.state.get("state") == "Run", 10_000)
    heaps = [Heap(machine.pico, True)]
    looked_ms = machine.now_ms()

    def look():
        nonlocal looked_ms
        if machine.now_ms() - looked_ms > 1000:
            heaps.append(Heap(machine.pico, True))
            looked_ms = machine.now_ms()
        return pages[0].state["state"]

    pages[0].until(lambda: look() == "Alarm", 30_000)
    answer, _ = pages[0].order("log")
    assert errors.WORDS_LATE not in answer["log"]
    least, piece = min(heap.free for heap in heaps), min(heap.largest for heap in heaps)
    show(
        "router_pico_w on a Pico W that tells a broker, two pages open, lines streamed over USB",
        f"{before.free} bytes free without the broker, {begun.free} with it, {least} at least ({piece} in one piece); STOP came from the broker",
    )
    assert least >= LEAST_TOLD and not machine.plant.errors


def job_of(language):
    if language == "grbl":
        return b"G21G91F3000\n" + b"".join(b"G1X%.2fY%.2fS%d\n" % (at % 7 / 50, at % 5 / 40, at % 900) for at in range(JOB_BYTES // 16))
    points = [packet(COMMANDS["LINE"], 100 + at % 7, 100 + at % 5) for at in range(JOB_BYTES // 6)]
    return packet(COMMANDS["MOVE"], 100, 100) + b"".join(points) + packet(COMMANDS["END"])


@pytest.mark.parametrize("board", ["laser_pico_w", "plotter_page"])
def test_a_job_is_uploaded_while_two_pages_look_on(frozen_w, board, show):
    machine, air = on_the_air(board, frozen_w)
    begun, start = Heap(machine.pico, True), machine.plant.position[:2]
    pages = [Page(air), Page(air)]
    page, heaps = pages[0], []
    for each in pages:
        each.until(lambda each=each: each.state.get("link"))
    assert page.order("give", to="page")[0]["error"] == 0
    page.until(lambda: page.state["owner"] == "page")
    data = job_of(machine.board["jobs"]["language"])

    def look():
        heaps.append(Heap(machine.pico, True))
        pages[1].look()

    took = page.upload("PART", data, stored_form(data), look)
    page.stored("end", "PART")
    page.until(lambda: page.state["job"] and page.state["job"]["how"] == "kept")
    page.order("unlock")
    page.stored("run", "PART")
    page.until(lambda: page.state["job"]["how"] == "run")
    look()
    page.until(lambda: page.state["job"]["how"] == "done", 60_000)
    look()
    least, piece = min(heap.free for heap in heaps), min(heap.largest for heap in heaps)
    show(
        f"{board} on a Pico W, two pages open, a job of {len(data)} bytes uploaded and run",
        f"{begun.free} of {begun.total} bytes free before ({begun.largest} in one piece), {least} at least ({piece} in one piece); "
        f"a piece in {min(took):.0f} to {max(took):.0f} ms",
    )
    if board == "plotter_page":
        gone = [at - before for at, before in zip(machine.plant.position, start)]  # unlocked, so from where it stood
        assert [at - 100 for at in gone] == [(JOB_BYTES // 6 - 1) % 7, (JOB_BYTES // 6 - 1) % 5]
    assert least >= LEAST and not machine.plant.errors

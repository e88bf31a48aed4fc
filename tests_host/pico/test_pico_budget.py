"""The build's estimate of a Pico's heap on stock MicroPython, against the free bytes when the main loop begins (host_tools/build/budget.py)."""

import copy

import pytest
from air import UART_BYTES, Air, files, pico_w
from emulated import READY, RUN, uf2  # noqa: F401
from test_pico_flash import LIMIT_MS

from host_tools import boards
from host_tools.build.budget import JOB_KB, PICO_KB, PICO_W_KB, heap_kb
from host_tools.emulator.heap import Heap
from host_tools.emulator.machine import EmulatedMachine, files_of
from passo.config.boardfile import check

MORE = {
    "plotter_2014": {"jobs": {"language": "plotter"}, "journal": {"every_ms": 500}},
    "lpt_router": {"jobs": {"language": "pulses"}},
    "router_ballscrew": {"blackbox": True},
}
NAMES = [name for name in boards.names() if boards.load(name)["chip"] == "rp2040" and not boards.load(name).get("network")]


def taken_kb(board, uf2):
    files = dict(files_of(board))
    assert files["main.py"].count(RUN) == 1
    files["main.py"] = files["main.py"].replace(RUN, READY + RUN)
    machine = EmulatedMachine(board, files, uf2=uf2, trace=None).boot()
    console = machine.pico.console
    machine.run_until(lambda: b"ready" in console.text, LIMIT_MS, 1000)
    heap = Heap(machine.pico)
    assert round(heap.total / 1000) == PICO_KB
    return (heap.total - heap.free) / 1000


@pytest.mark.parametrize(
    "name, more", [pytest.param(name, more, marks=() if name == "plotter_2014" and not more else pytest.mark.slow)
                   for name in NAMES for more in (False, True) if not more or name in MORE],
)  # fmt: skip
def test_the_build_counts_what_a_start_takes(name, more, uf2, show):
    board = {**boards.load(name), **(copy.deepcopy(MORE[name]) if more else {})}
    counted, taken = heap_kb(check(copy.deepcopy(board))), taken_kb(board, uf2)
    show(f"{name}, heap on stock MicroPython", f"{counted} kB counted, {taken:.1f} taken")
    assert taken - 3 <= counted - JOB_KB * bool(board.get("jobs")) <= taken + 4


@pytest.mark.slow
@pytest.mark.parametrize("name, kind", [("torch_pico_w", "http"), ("torch_pico_w", "page"), ("plotter_pico_w", "page")])
def test_and_on_a_pico_w(name, kind, show):
    """A UART stands in the place of the radio; its buffers are not counted."""
    board = {**boards.load(name), "network": {"host": "passo"}}
    board["links"] = [board["links"][0], {"name": kind, "port": kind, "protocol": board["links"][0]["protocol"]}]
    counted = heap_kb(check(copy.deepcopy(board)))
    machine = EmulatedMachine(board, files(board), uf2=pico_w(), trace=None).boot()
    machine.run_until(lambda: b"code in" in machine.pico.console.text, LIMIT_MS, 1000)
    machine.run_ms(300)
    heap = Air(machine).collected()
    assert round(heap.total / 1000) == PICO_W_KB and b"Error" not in machine.pico.console.text
    taken = (heap.total - heap.free - UART_BYTES) / 1000
    show(f"{name} with {kind} on a Pico W, heap on stock MicroPython", f"{counted} kB counted, {taken:.1f} taken")
    assert taken - 3 <= counted <= taken + 4

"""The page and its API served by an emulated Pico W, while three axes step: connections come over a UART in the place of the radio.

What this does not show: the radio, its driver and lwIP, whose memory lies outside MicroPython's heap.
"""

import gzip

import pytest

from air import Air, Page, files, pico_w
from host_tools.build.pages import PAGES
from host_tools.emulator.heap import Heap
from host_tools.emulator.machine import EmulatedMachine
from passo.protocols.torch import protocol as torch
from test_pico_network import LATEST_US, LEAST_FREE, RATE, Z_TOO, network_board
from test_pico_torch import steps_of, until_up

STEPS = 8000


@pytest.mark.slow
def test_the_page_while_three_axes_step(show):
    """Files, states five times a second to two pages, answers to orders, and STOP without a key: no step is late."""
    board = network_board()
    board["links"][1] = {"name": "page", "port": "page", "protocol": "torch"}
    board["memory"] = "lean"
    machine = EmulatedMachine(board, files(board, "protocols/torch/protocol.py", Z_TOO), uf2=pico_w(), start=(1000, 9000, 1000)).boot()
    air = Air(machine)
    until_up(machine)
    machine.send(torch.frame("CONNECT"))
    machine.run_ms(70)
    air.say(b"G", 0)
    machine.run_ms(100)
    alone = Heap(machine.pico)
    pages = [Page(air), Page(air)]
    for page in pages:
        page.until(lambda page=page: page.state.get("link"))
    known = len(machine.trace.rows()) - 1
    pushed = [page.pushes for page in pages]
    machine.send(torch.move(STEPS, RATE, STEPS, -RATE))
    begun = machine.now_ms()
    took = {"/": [], "/panel.js": [], "order": []}
    while machine.now_ms() < begun + 1e3 * STEPS / RATE - 300:
        for name, found in took.items():
            if name == "order":
                answer, ms = pages[0].order("log")
                assert answer["log"] == []
            else:
                body, ms = air.answer(air.get(name), 4000)
                assert gzip.decompress(body) == (PAGES / (name[1:] or "index.html")).read_bytes()
            found.append(ms)
    for page in pages:
        page.look()
    pushes = [page.pushes - before for page, before in zip(pages, pushed)]
    passed = machine.now_ms() - begun
    moving = pages[0].state["state"]
    machine.run_ms(600)
    air.say(b"G", 0)
    machine.run_ms(100)
    served = Heap(machine.pico)
    pages[0].look()
    worst = 0
    rows = machine.trace.rows()[known:]
    for axis in range(3):
        times = steps_of(rows, axis)
        assert len(times) == STEPS
        worst = max(worst, *[abs(us - times[0] - i * 1e6 / RATE) for i, us in enumerate(times)])
    show(
        "The page on a Pico W, three axes stepping",
        f"{alone.free} bytes free without clients, {served.free} with two pages ({served.largest} in one piece); {pushes} pushes in {passed:.0f} ms; "
        + ", ".join(f"{name} {min(found):.0f} to {max(found):.0f} ms" for name, found in took.items())
        + f"; steps at most {worst:.1f} us off",
    )
    assert served.free >= LEAST_FREE
    assert worst < LATEST_US and moving == "Run"
    for page, count in zip(pages, pushes):
        assert count >= 4 * passed / 1000
    assert not machine.plant.errors

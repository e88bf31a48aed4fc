"""The page and its API served by an emulated Pico W, while three axes step: connections come over a UART in the place of the radio.

The tests leave out the radio, its driver and lwIP, whose memory lies outside MicroPython's heap.
"""

import gzip
import json

import pytest

from air import Air, Page, files, pico_w
from host_tools import boards
from host_tools.build.pages import texts_of
from host_tools.emulator.machine import EmulatedMachine
from host_tools.emulator.sender import NEXT
from passo.protocols.plotter.host import COMMANDS, packet
from passo.protocols.torch import protocol as torch
from test_pico_network import LATEST_US, LEAST_FREE, RATE, Z_TOO, network_board
from test_pico_torch import until_up, worst_us

STEPS = 20_000
POINTS = 600
ROUNDS = 4
WINDOW = 4
AGAIN_MS = 100


@pytest.mark.slow
def test_the_page_while_three_axes_step(show):
    """Files, states five times a second to two pages, answers to orders, and STOP without a key: no step is late."""
    board = network_board()
    board["links"][1] = {"name": "page", "port": "page", "protocol": "torch"}
    machine = EmulatedMachine(board, files(board, "protocols/torch/protocol.py", Z_TOO), uf2=pico_w(), start=(1000, 40_000, 1000)).boot()
    air = Air(machine)
    until_up(machine)
    machine.send(torch.frame("CONNECT"))
    machine.run_ms(70)
    alone = air.collected()
    pages = [Page(air), Page(air)]
    for page in pages:
        page.until(lambda page=page: page.state.get("link"))
    known = len(machine.trace.rows()) - 1
    pushed = [page.pushes for page in pages]
    machine.send(torch.move(STEPS, RATE, STEPS, -RATE))
    begun = machine.now_ms()
    took = {"/": [], "/panel.js": [], "order": []}
    while machine.now_ms() < begun + 1e3 * STEPS / RATE - 2500:
        for name, found in took.items():
            if name == "order":
                answer, ms = pages[0].order("log")
                assert answer["log"] == []
            else:
                body, ms = air.answer(air.get(name), 4000)
                assert gzip.decompress(body) == texts_of(board)[name[1:] or "index.html"]
            found.append(ms)
    for page in pages:
        page.look()
    pushes = [page.pushes - before for page, before in zip(pages, pushed)]
    passed = machine.now_ms() - begun
    assert passed < 1e3 * STEPS / RATE and pages[0].state["state"] == "Run"
    machine.run_ms(1e3 * STEPS / RATE - passed + 300)
    served = air.collected()
    pages[0].look()
    worst = worst_us(machine.trace.rows()[known:], STEPS, RATE)
    show(
        "The page on a Pico W, three axes stepping",
        f"{alone.free} bytes free without clients, {served.free} with two pages ({served.largest} in one piece); {pushes} pushes in {passed:.0f} ms; "
        + ", ".join(f"{name} {min(found):.0f} to {max(found):.0f} ms" for name, found in took.items())
        + f"; steps at most {worst:.1f} us off",
    )
    assert served.free >= LEAST_FREE
    assert worst < LATEST_US
    for page, count in zip(pages, pushes):
        assert count >= int(5 * passed / 1000)
    machine.send(torch.move(STEPS, RATE, 0, RATE))
    machine.run_ms(200)
    begun = machine.now_ms()
    number = air.ask("POST /stop HTTP/1.1\r\nHost: passo.local\r\n\r\n")
    body, ms = air.answer(number)
    machine.run_ms(300)
    last = machine.trace.rows()[-1][0] / 1000
    show("STOP without a key", f"answered in {ms:.0f} ms, the last step {last - begun:.0f} ms behind the request")
    assert json.loads(body)["error"] == 0 and 0 < last - begun < 200
    assert not machine.plant.errors


def points_s(machine):
    """Points a second that a plotter takes over its cable, at full speed. A STOP drops the stored points now and then."""
    took = 0
    for _ in range(ROUNDS):
        took += points_ms(machine)
        machine.send(packet(COMMANDS["STOP"]))
        machine.run_ms(60)
        machine.take()
    return ROUNDS * POINTS * 1000 / took


def points_ms(machine):
    sent = heard = 0
    begun = told = machine.now_ms()
    while heard < POINTS:
        if machine.now_ms() > told + AGAIN_MS:  # lost lines are sent again
            sent, told = heard, machine.now_ms()
        while sent < POINTS and sent < heard + WINDOW:
            machine.send(packet(COMMANDS["LINE"], 100 + sent % 1000, 100 + sent // 2))
            sent += 1
        machine.run_ms(1)
        answers = machine.take().count(NEXT)
        if answers:
            heard, told = heard + answers, machine.now_ms()
        assert machine.now_ms() < begun + 20_000, (heard, bytes(machine.pico.console.text[-400:]))
    return machine.now_ms() - begun


@pytest.mark.slow
def test_pages_that_look_on_cost_a_stream_little(show):
    """Points a second of a plotter that is sent to at full speed, without pages and with two that are pushed the state."""
    board = {**boards.load("plotter_pico_w"), "network": {"host": "passo"}, "store_points": 2 * POINTS}
    cable = {**board["links"][0], "baud": 115_200}
    board["links"] = [cable, {"name": "page", "port": "page", "protocol": "plotter"}]
    machine = EmulatedMachine(board, files(board), uf2=pico_w(), trace=None).boot()
    machine.run_until(lambda: b"code in" in machine.pico.console.text, 5000)
    machine.run_ms(300)
    air = Air(machine)
    alone = points_s(machine)
    pages = [Page(air), Page(air)]
    for page in pages:
        page.until(lambda page=page: page.state.get("link"))
    before = [page.pushes for page in pages]
    begun = machine.now_ms()
    watched = points_s(machine)
    passed = machine.now_ms() - begun
    for page in pages:
        page.look()
    pushes = [page.pushes - count for page, count in zip(pages, before)]
    show(
        "points a second of a plotter on a Pico W, without pages and with two",
        f"{alone:.0f}, {watched:.0f}: {watched / alone:.3f}; pushes {pushes} in {passed:.0f} ms; {air.collected().free} bytes free",
    )
    assert watched >= 0.9 * alone and min(pushes) >= int(5 * passed / 1000)

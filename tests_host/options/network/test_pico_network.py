"""The board's HTTP server on an emulated Pico W, while three axes step: connections come over a UART in the place of the radio.

The tests leave out the radio, its driver and lwIP, whose memory lies outside MicroPython's heap.
"""

import json

import pytest

from air import Air, files, pico_w
from host_tools import boards
from host_tools.emulator.heap import Heap
from host_tools.emulator.machine import EmulatedMachine
from passo.protocols.torch import protocol as torch
from test_pico_torch import until_up, worst_us


LEAST_FREE = 25_000  # bytes, with two clients
RATE = 4000  # steps/s
STEPS = 4000
LATEST_US = 11  # steps of axes that run on their own may share a word
Z_TOO = (
    ("        return Run(steps, ((abs(x_speed), 1000), (abs(y_speed), 1000)), AT_REST)",
     "        return Run(steps + steps[:1], ((abs(x_speed), 1000), (abs(y_speed), 1000), (abs(x_speed), 1000)), AT_REST)"),
)  # fmt: skip


def network_board():
    """The torch on a Pico W with a third axis, which goes as X does."""
    board = boards.load("torch_pico_w")
    x, y = board["axes"]
    board["axes"] = [{**x, "pins": [2, 5]}, {**y, "pins": [3, 6]}, {**x, "name": "z", "pins": [4, 7]}]
    board["tool"] = {"pin": 8}
    return board


def events(data):
    return [json.loads(line[6:]) for line in data.split(b"\n") if line.startswith(b"data: ") and line.endswith(b"}")]


@pytest.mark.slow
def test_a_page_while_three_axes_step(show):
    board = network_board()
    machine = EmulatedMachine(board, files(board, "protocols/torch/protocol.py", Z_TOO), uf2=pico_w(), start=(1000, 5000, 1000)).boot()
    air = Air(machine)
    until_up(machine)
    machine.send(torch.frame("CONNECT"))
    machine.run_ms(70)
    air.say(b"G", 0)
    machine.run_ms(100)
    alone = Heap(machine.pico)
    pages = [air.get("/EVENTS"), air.get("/EVENTS")]
    machine.run_ms(300)
    air.look()
    pushed = len(events(air.heard[pages[0]]))
    known = len(machine.trace.rows()) - 1
    machine.send(torch.move(STEPS, RATE, STEPS, -RATE))
    # Requests one after the other, and two pages that the position is pushed to, while all three axes step.
    begun = machine.now_ms()
    latencies = {"/INFO?json": [], "/torch.js": [], "/INFO": []}
    while machine.now_ms() < begun + 1e3 * STEPS / RATE:
        for path, found in latencies.items():
            found.append(air.answer(air.get(path))[1])
    machine.run_ms(400)
    air.look()
    air.say(b"G", 0)
    machine.run_ms(100)
    served = Heap(machine.pico)
    machine.take()
    machine.send(torch.passo(torch.STATUS_OF))
    machine.run_ms(30)
    status = torch.answer_from(machine.take())[1]
    rows = machine.trace.rows()[known:]
    places = [each["px"] for each in events(air.heard[pages[0]])[pushed:]]
    worst = worst_us(rows, STEPS, RATE)
    passed = machine.now_ms() - begun
    show(
        "HTTP on a Pico W, three axes stepping",
        f"{alone.free} bytes free without clients, {served.free} with two pages ({served.largest} in one piece); {len(places)} pushes in "
        f"{passed:.0f} ms; answers "
        + ", ".join(f"{path} {min(found):.0f} to {max(found):.0f} ms" for path, found in latencies.items())
        + f"; steps at most {worst:.1f} us off",
    )
    assert served.free >= LEAST_FREE
    assert worst < LATEST_US and status["error"] == 0 and (status["x"], status["y"]) == (STEPS, -STEPS)
    assert len(places) >= 5 * passed / 1000 - 1 and places == sorted(places) and len(set(places)) > 3
    assert len(events(air.heard[pages[1]])) >= 4
    assert not machine.plant.errors

"""A board with stored jobs and their journal, on which all kinds of orders come for long: its memory stays in one piece.

    PASSO_ORDERS=10000 pytest -s -o faulthandler_timeout=0 tests_host/pico/test_pico_memory_lasts.py

prints the largest piece as it goes on; it takes ten to twenty minutes of processor time a board. Without PASSO_ORDERS it is 300 orders a board.
"""

import base64
import os
import re

import pytest
from draws import Random
from emulated import uf2  # noqa: F401
from mixed_orders import job, mixed
from test_pico_frozen import frozen  # noqa: F401
from test_pico_frozen_w import frozen_w  # noqa: F401

from host_tools import boards
from host_tools.emulator.frozen import frozen_machine
from host_tools.emulator.heap import Heap
from host_tools.emulator.machine import EmulatedMachine, files_of
from host_tools.programs import stored_job

pytestmark = pytest.mark.slow
ORDERS = int(os.environ.get("PASSO_ORDERS", "300"))
UPLOADS, RESETS = 10, 50  # in 10 000 orders; fewer in fewer, but not below 3
EVERYTHING = {"journal": {"every_ms": 500}, "jobs": {"language": "grbl"}}
LEAST = {"router_3axis": 1000, "laser_xy": 1000, "mill_2004": 300}  # bytes in one piece, at any time: no order wants as many
LEAST_FROZEN = {"router_3axis": 16_000, "laser_xy": 16_000, "mill_2004": 6_000, "router_pico_w": 2000}
OUT_OF_MEMORY = (7, 159)
LOCKED = 9


class Sender:
    def __init__(self, board, machine):
        self.machine = machine.boot()
        self.random = Random(len(board["name"]))
        self.errors = {}
        self.largest = []  # (orders, bytes free, in one piece)
        self.orders = 0
        self.await_(rb"for help\]")
        self.ask(b"$X")

    def await_(self, pattern, limit_ms=20_000):
        self.machine.run_until(lambda: re.search(pattern, self.machine.replies_so_far()), limit_ms)
        return self.machine.take()

    def ask(self, line):
        self.orders += 1
        self.machine.send(line + b"\n")
        said = self.await_(rb"ok\r\n|error:\d+\r\n")
        error = re.search(rb"error:(\d+)", said)
        if error:
            number = int(error[1])
            self.errors[number] = self.errors.get(number, 0) + 1
            if number == LOCKED and line != b"$X":  # an order too many took it out of its travel
                self.reset()
        return said

    def still(self):
        said = b""
        while b"<Idle" not in said:
            self.machine.send(b"?")
            self.orders += 1
            said = self.await_(rb"<[^>]*>\r\n")
            self.machine.run_ms(20)

    def note(self):
        heap = Heap(self.machine.pico, True)
        self.largest.append((self.orders, heap.free, heap.largest))
        if "PASSO_ORDERS" in os.environ:
            print(self.orders, heap.free, heap.largest, flush=True)

    def order(self):
        stands, lines = mixed(self.random)
        if stands:
            self.still()
        for line in lines:
            self.ask(line)

    def reset(self):
        self.machine.send(b"\x18")
        self.await_(rb"for help\]")
        self.ask(b"$X")

    def upload(self):
        """A job is sent, run once or stopped, and deleted."""
        self.still()
        data = job(self.random)
        packed = stored_job.pack_job(data)
        name = self.random.choice((b"A", b"LONGER.GCODE"))
        self.ask(b"$FS=%s,grbl,%d,%08x,%d" % (name, len(data), stored_job.crc_of(data), len(packed)))
        for at in range(0, len(packed), 57):
            self.ask(b"$F:" + base64.b64encode(packed[at : at + 57]))
        self.ask(b"$FE")
        self.note()
        said = self.ask(b"$F=" + name)
        self.machine.run_ms(300)
        self.note()
        if b"error" in said or self.random.between(0, 1):
            self.reset()
        elif b"[MSG:Job" not in said + self.machine.replies_so_far():
            assert b" done]" in self.await_(rb"\[MSG:Job [A-Z.]+( done\]|: error)", 120_000)


@pytest.mark.parametrize("board", LEAST)
def test_after_many_orders_memory_is_in_as_large_a_piece(board, uf2, show):
    loaded = boards.load(board)
    loaded.update(EVERYTHING)
    lasts(loaded, EmulatedMachine(loaded, files_of(loaded), uf2=uf2, trace=None), LEAST[board], show)


@pytest.mark.parametrize("board", LEAST_FROZEN)
def test_the_same_with_passos_uf2(board, show, request):
    """Frames on each link, too: there is room."""
    loaded = boards.load(board)
    uf2 = request.getfixturevalue("frozen_w" if loaded.get("network") else "frozen")
    loaded.update(EVERYTHING, links=[dict(link, frames=link["port"] != "page") for link in loaded["links"]])
    lasts(loaded, frozen_machine(loaded, uf2, trace=None), LEAST_FROZEN[board], show)


def lasts(loaded, machine, bound, show):
    """Sends the orders; `bound`: bytes in one piece."""
    board = loaded["name"]
    sender = Sender(loaded, machine)
    sender.note()
    uploads, resets = max(3, ORDERS * UPLOADS // 10_000), max(3, ORDERS * RESETS // 10_000)
    for part in range(uploads * resets):
        while sender.orders < ORDERS * (part + 1) // (uploads * resets):
            sender.order()
        if part % resets == resets - 1:
            sender.upload()
        if part % uploads == uploads - 1:
            sender.reset()
        if part % 3 == 0:
            sender.note()
    sender.still()
    sender.note()
    least = min(largest for _, _, largest in sender.largest)
    show(
        f"{board}: memory over {sender.orders} orders, {uploads} uploads and {resets} resets",
        f"in one piece {sender.largest[0][2]} bytes at first, {least} at least, {sender.largest[-1][2]} at last; "
        f"free {sender.largest[0][1]} and {sender.largest[-1][1]}; errors {sender.errors}",
    )
    assert not set(OUT_OF_MEMORY) & set(sender.errors), sender.errors
    assert least >= bound
    # A reset amid a move leaves the machine where it is: over thousands of orders it may drift to an end.
    assert not [why for _, why in sender.machine.plant.errors if "hard end" not in why]

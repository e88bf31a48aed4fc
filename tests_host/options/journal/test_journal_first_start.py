"""A flash without the journal's files: the board answers first, and makes them at a stand, or as a job is announced."""

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages
from passo import errors
from passo.options.journal.control import unpack_record


class Missing(Pages):
    """Blocks that an erase makes, as those of port_rp2.py; `room`: the most of them."""

    def __init__(self, room=Pages.BLOCKS):
        Pages.__init__(self)
        self.made = []
        self._room = room

    def read(self, block, slot):
        return Pages.read(self, block, slot) if block in self.made else b""

    def write(self, block, slot, data):
        assert block in self.made
        Pages.write(self, block, slot, data)

    def erase_block(self, block):
        if block not in self.made:
            if len(self.made) == self._room:
                raise OSError(28)
            self.made.append(block)
        Pages.erase_block(self, block)

    def records(self):
        found = [unpack_record(self.read(block, slot)) for block in self.made for slot in range(self.SLOTS)]
        return [record for record in found if record]


def machine(pages):
    board = boards.load("router_3axis")
    board["journal"] = {"every_ms": 100}
    made = VirtualMachine(board, pages=pages, start=(3000, 3000, -3000), trace=None)
    made.run_ms(40)
    return made


def send(made, data, ms=60):
    made.take()
    made.send(data)
    made.run_ms(ms)
    return made.take().decode()


def test_the_first_answer_comes_before_a_block_is_made():
    pages = Missing()
    made = machine(pages)
    assert "<" in send(made, b"?", 20) and pages.made == []
    made.run_ms(6000)
    assert len(pages.made) == Pages.BLOCKS // 2, "half of them, one a second of the stand"


def test_a_job_that_comes_at_once_is_written_down():
    pages = Missing()
    made = machine(pages)
    assert "ok" in send(made, b"$X\n$JR=1234\n") and pages.made
    assert "ok" in send(made, b"G91\nN7 G1 X1 F600\n", 3000)
    assert pages.records()[-1][2:4] == (0x1234, 7)


@pytest.mark.parametrize("room", (0, 1))
def test_a_full_flash_is_logged_once_and_the_machine_goes_on(room):
    pages = Missing(room)
    made = machine(pages)
    made.run_ms(8000)
    log = made.app.controller.machine.log
    assert log.counts[errors.MEMORY] == 1 and len(pages.made) == room
    assert "ok" in send(made, b"$X\nG91\nN7 G1 X1 F600\n", 3000)

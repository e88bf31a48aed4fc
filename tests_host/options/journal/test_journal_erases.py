"""When the journal erases flash: never where bytes of a sender that counts may be on their way."""

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine
from host_tools.sim.pages import Pages
from passo.options.journal.control import pack_record, unpack_record

USED = 300  # slots: more than half


class Watched(Pages):
    """Notes when a block is erased, in ms of the machine's time."""

    def __init__(self, used):
        Pages.__init__(self)
        self.erased = []
        self.now_ms = lambda: 0
        for number in range(used):
            self.write(number // self.SLOTS, number % self.SLOTS, pack_record(number, 1, 7, number, [0, 0, 0, 0]))

    def erase_block(self, block):
        newest = max((unpack_record(self.read(each, slot)) or (-1,))[0] for each in range(self.BLOCKS) for slot in range(self.SLOTS))
        Pages.erase_block(self, block)
        kept = max((unpack_record(self.read(each, slot)) or (-1,))[0] for each in range(self.BLOCKS) for slot in range(self.SLOTS))
        assert kept == newest, "the newest record is gone"
        self.erased.append(self.now_ms())


def machine(used=USED, every_ms=100):
    board = boards.load("router_3axis")
    board["journal"] = {"every_ms": every_ms}
    pages = Watched(used)
    made = VirtualMachine(board, pages=pages, start=(3000, 3000, -3000), trace=None)
    pages.now_ms = made.now_ms
    made.run_ms(40)
    send(made, b"$X\nG91\n")
    return made, pages


def send(made, data, ms=60):
    made.take()
    made.send(data)
    made.run_ms(ms)
    return made.take().decode()


@pytest.mark.parametrize("pause_ms", [60, 400, 900])
def test_stands_amid_a_job_erase_nothing(pause_ms):
    """The machine runs dry, dwells, changes the spindle: the position is written, and no block erased."""
    made, pages = machine(used=200)
    assert "ok" in send(made, b"$JR=1234\n")
    pages.erased.clear()
    records = pages.data.count(b"\xff" * 32)
    for number in range(1, 330):
        said = send(made, b"N%d G1 X%s F3000\n" % (number, b"0.1" if number % 2 else b"-0.1"), pause_ms if number % 50 == 0 else 30)
        assert "ok" in said
    assert pages.erased == [] and pages.data.count(b"\xff" * 32) < records - 60
    made.run_ms(4000)
    assert pages.erased, "at rest"


def test_announcing_a_job_makes_room_before_it_is_answered():
    made, pages = machine()
    begun = made.now_ms()
    assert "ok" in send(made, b"$JR=1234\n", 20)
    assert len(pages.erased) == 2 and max(pages.erased) - begun < 20
    made.run_ms(5000)
    assert len(pages.erased) == 2


def test_at_rest_one_block_a_second():
    made, pages = machine()
    begun = made.now_ms()
    made.run_ms(5000)
    assert len(pages.erased) == 1, "then half are free"
    assert 890 < pages.erased[0] - begun < 1100
    made, pages = machine(used=4 * 128)
    made.run_ms(5000)
    assert len(pages.erased) == 2 and pages.erased[1] - pages.erased[0] >= 1000


def test_what_a_long_job_writes_gets_rarer_and_the_last_is_written():
    made, pages = machine(used=4 * 128 - 40)
    send(made, b"$JR=99\nN1 G1 X0.5 F600\n", 10)
    for number in range(2, 60):
        send(made, b"N%d G1 X0.1\n" % number, 120)
    send(made, b"N60 G1 X0.1\n", 4000)
    assert "[JOURNAL:00000099|60|" in send(made, b"$JR\n")
    newest = max((unpack_record(pages.read(block, slot)) for block in range(4) for slot in range(128) if unpack_record(pages.read(block, slot))), key=lambda record: record[0])
    assert newest[3] == 60 and newest[1] & 1

"""The power-fail input on the emulated Pico: how soon steps and tool end, and the place is in the flash."""

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from passo.options.journal.control import unpack_record
from passo.records import JOURNAL_BYTES, TICKS_PER_MS
from test_pico_jobs import ask, fast_router, ready

SLICE_US = 100
PROGRAM_MS = 3  # of a page at worst, by the data sheet of a W25Q16JV; 0.4 typical. The emulator's takes no time
MOST_MS = 50  # a line for the full parser takes 6 ms, a collection of garbage 30
UNDER_WAY = 20  # lines that the receive buffer holds


def board():
    made = {**boards.load("router_3axis"), "links": fast_router()["links"], "journal": {"every_ms": 1000, "power": "power"}}
    made["inputs"] = [*made["inputs"], {"name": "power", "pin": 22, "active": 0, "pull": "up"}]
    return made


class Newest:
    """The newest record of the journal, looked for where the first was found."""

    def __init__(self, pico):
        self._flash = pico.chip.flash
        image = bytes(self._flash)
        self._at = next(at for at in range(0, len(image), 4096) if unpack_record(image[at : at + JOURNAL_BYTES]))

    def read(self):
        found = None
        for at in range(self._at, self._at + 4096, JOURNAL_BYTES):
            record = unpack_record(bytes(self._flash[at : at + JOURNAL_BYTES]))
            if record is None:
                return found
            found = record


@pytest.mark.slow
def test_the_place_is_saved_while_the_capacitors_last(make_machine, show):
    machine = ready(make_machine(board()))
    took = []
    for trial, wait_ms in enumerate((433, 501, 557, 618, 674, 733, 790, 811)):
        job = 0x1000 + trial
        machine.plant.set_input(0, "power", False)
        machine.run_ms(20)
        ask(machine, b"$X")
        assert ask(machine, b"$JR=%x" % job) == b"ok\r\n"
        newest = newest if trial else Newest(machine.pico)
        back = b"-" if trial % 2 else b""
        lines = [b"N1M3S9000\n"] + [b"N%dG91G1X%s0.%dY%s0.1F4000\n" % (line, back, line % 9 + 1, back) for line in range(2, 300)]
        end_ms = machine.now_ms() + wait_ms + 700  # it begins once it knows the blocks that follow
        sent = 0
        machine.take()
        while machine.now_ms() < end_ms:
            said = bytes(machine.replies_so_far())
            assert b"error" not in said
            while sent < len(lines) and sent - said.count(b"ok") < UNDER_WAY:
                machine.send(lines[sent])
                sent += 1
            machine.run_ms(5)
        for _ in range(trial):
            machine.run_ms(1.3)
        assert machine.plant.tool and newest.read()[2] == job
        start = list(machine.plant.position)
        before = newest.read()[0]
        machine.plant.set_input(machine.now_ms() * TICKS_PER_MS, "power", True)
        cut_ms = machine.now_ms()
        dark_ms = None
        while newest.read()[0] == before:
            machine.pico.run(SLICE_US)
            if dark_ms is None and not machine.plant.tool:
                dark_ms = machine.now_ms() - cut_ms
            assert machine.now_ms() - cut_ms < 100
        saved_ms = machine.now_ms() - cut_ms
        there = list(machine.plant.position)
        assert there != start, "it was moving"
        machine.run_ms(50)
        assert machine.plant.position == there and not machine.plant.tool
        took.append((dark_ms if dark_ms is not None else saved_ms, saved_ms))
        record = newest.read()
        machine.settle()
        said = ask(machine, b"$JR")
        assert record[2] == job and ("|%d|" % record[3]).encode() in said
        assert b",".join(b"%d" % place for place in record[4][:3]) in said
    show("the power fails", f"steps and tool end within {max(took)[0]:.1f} ms, flash is written from {max(each[1] for each in took):.1f} ms on, "
         f"{len(took)} trials")  # fmt: skip
    assert max(saved for _, saved in took) + PROGRAM_MS <= MOST_MS

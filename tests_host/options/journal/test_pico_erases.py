"""Flash that is erased on the emulated Pico, at its typical and its longest times: a sender that counts loses no byte, and no watchdog barks.
"""

import re

import pytest
from emulated import uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator.flash_times import LONGEST, TYPICAL
from host_tools.emulator.machine import EmulatedMachine, files_of
from passo.options.journal.control import pack_record

BLOCKS, SLOTS, RECORD = 4, 128, 32
USED = 3 * SLOTS + 60  # of the slots: three blocks are erased
RX_BYTES = 512
ANSWER = re.compile(rb"(ok|error:\d+|ALARM:\d+)\r\n")
LINK = "serial"
pytestmark = [pytest.mark.on_a_copy, pytest.mark.xdist_group("erases")]


# A test that passes with the longest erases passes with typical ones.
@pytest.fixture(scope="module", params=[pytest.param(TYPICAL, id="typical", marks=pytest.mark.slow), pytest.param(LONGEST, id="longest")])
def machine(request, uf2):  # noqa: F811
    board = boards.load("router_3axis")
    board["journal"] = {"every_ms": 200}
    board["links"] = [link for link in board["links"] if link["name"] == LINK]
    files = dict(files_of(board))
    for block in range(BLOCKS):
        records = [pack_record(slot, 1, 7, slot, [0, 0, 0, 0]) for slot in range(block * SLOTS, min(USED, (block + 1) * SLOTS))]
        files[f"journal.{block}"] = b"".join(records).ljust(SLOTS * RECORD, b"\xff")
    made = EmulatedMachine(board, files, trace=None, start=(3000, 3000, -3000))
    made.pico.flash_times.set_times(**request.param)
    made.boot()
    made.run_until(made.is_listening, 15_000)
    made.run_ms(800)
    made.pico.flash_times.set_times(**request.param)
    return made


def stream(machine, lines, pauses=(), question_ms=0):
    """Send lines as a sender does that counts 512 bytes; `pauses`: {number of a line: ms before it}. Returns the answers."""
    said, sent, answered = b"", [], 0
    asked_ms = machine.now_ms()
    for number, line in enumerate(lines):
        if number in pauses:
            machine.run_ms(pauses[number])
        while sum(sent[answered:]) + len(line) > RX_BYTES:
            machine.run_ms(1)
            said += machine.take(LINK)
            answered = len(ANSWER.findall(said))
            if question_ms and machine.now_ms() - asked_ms > question_ms:
                asked_ms = machine.now_ms()
                machine.send(b"?", LINK)
            assert machine.now_ms() - asked_ms < 60_000
        machine.send(line, LINK)
        sent.append(len(line))
    end = machine.now_ms() + 20_000
    while answered < len(lines) and machine.now_ms() < end:
        machine.run_ms(5)
        said += machine.take(LINK)
        answered = len(ANSWER.findall(said))
    return ANSWER.findall(said)


def rests(machine, limit_ms):
    """Return its bytes up to the report after it stands and three blocks are erased."""
    end = machine.now_ms() + limit_ms
    said = b""
    while b"<Idle" not in said or machine.pico.flash_times.erased < 3:
        assert machine.now_ms() < end, (said, machine.pico.flash_times.erased)
        machine.run_ms(100)
        machine.send(b"?", LINK)
        machine.run_ms(40)
        said += machine.take(LINK)
    return said


def count(machine, pause_ms):
    """A job is announced with lines behind it, pauses until the machine runs dry, ends, and the next follows at once. Returns how many lines."""
    head = [b"$X\n", b"$JR=1234\n", b"$110=4000\n", b"G21G91\n"]
    moves = [b"N%d G1X0.5F3000\n" % number for number in range(1, 81)]
    more = [b"M30\n", b"$JR=77\n", b"G91\n"] + [b"N%d G1X-0.5F3000\n" % number for number in range(1, 21)] + [b"G10L2P1X0\n"] + [
        b"G1X-0.5F3000\n" for _ in range(20)
    ]
    lines = head + moves + more
    answers = stream(machine, lines, {30: pause_ms, 44: 60, 61: 400}, question_ms=150)
    assert answers == [b"ok"] * len(lines)
    assert b"<Idle|MPos:20.000,0.000,0.000|" in rests(machine, 3000)
    return len(lines)


def test_a_sender_that_counts_loses_nothing(machine, show):
    lines = count(machine, 60)
    show("erases while a sender counts", f"{machine.pico.flash_times.erased} of {machine.pico.flash_times.times['erase_us'] // 1000} ms, {lines} lines, none lost")


@pytest.mark.slow
@pytest.mark.parametrize("shift_ms", [1, 2, 3, 4, 5])
def test_it_loses_nothing_whenever_a_record_and_an_erase_follow_each_other(machine, shift_ms):
    """Bytes that came while the record was written are still unread when the erase begins."""
    count(machine, 60 + shift_ms)


def test_no_watchdog_barks(machine):
    """Three blocks in a row, settings on a full page, an erase at rest: it goes on, and has not been reset."""
    assert stream(machine, [b"$X\n", b"$JR=1\n", b"$120=200\n", b"$N0=G20\n", b"$I=a name\n"]) == [b"ok"] * 5
    rests(machine, 4000)
    machine.run_ms(500)  # a board that the watchdog has reset starts, or has said so
    machine.send(b"?", LINK)
    machine.run_ms(40)
    said = machine.take(LINK)
    assert b"<Idle" in said and b"Grbl" not in said

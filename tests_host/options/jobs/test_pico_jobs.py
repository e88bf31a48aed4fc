"""Stored jobs on the emulated Pico: uploaded over a UART, read from its flash while three axes step."""

import base64
import os
import re
from functools import lru_cache

import pytest
from dense_job import StepDigest, dense_job, fast_router, stream
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator.machine import files_of
from host_tools.programs import stored_job
from host_tools.sim.machine import VirtualMachine
from passo.options.journal.control import unpack_record

MISS_CYCLES = 50  # of the flash cache: 100 at 200 MHz
SMALL = b"G91\nG1X0.5Y0.2F3000\n\nG1X-0.5\nM30\n"


def with_journal():
    """The router on a UART, with a journal."""
    return {**boards.load("router_3axis"), "links": fast_router()["links"], "journal": {"every_ms": 100}}


def ask(machine, line):
    """Return the bytes up to the answer to a line."""
    machine.take()
    machine.send(line + b"\n")
    machine.run_until(lambda: b"ok\r\n" in machine.replies_so_far() or re.search(rb"error:\d+\r\n", machine.replies_so_far()))
    return machine.take()


def ready(machine):
    machine.run_until(lambda: b"for help]" in machine.replies_so_far())
    machine.run_ms(50)
    assert ask(machine, b"$X").endswith(b"ok\r\n")
    return machine


def test_a_job_is_uploaded_and_run(make_machine, show):
    machine = ready(make_machine(fast_router()))
    packed = stored_job.pack_job(SMALL)
    assert ask(machine, b"$FS=A,grbl,%d,%08x,%d" % (len(SMALL), stored_job.crc_of(SMALL), len(packed))) == b"ok\r\n"
    assert ask(machine, b"$F:" + base64.b64encode(packed)) == b"ok\r\n"
    assert ask(machine, b"$FE") == b"ok\r\n"
    assert b"[FILE:A|SIZE:%d|" % len(SMALL) in ask(machine, b"$F")
    start = list(machine.plant.position)
    ask(machine, b"$F=A")
    machine.run_until(lambda: b"[MSG:Job A done]\r\n" in machine.replies_so_far())
    assert [at - then for at, then in zip(machine.plant.position, start)] == [0, 64, 0]
    for _ in range(20):
        assert ask(machine, b"G1X5") == b"error:22\r\n"
    assert ask(machine, b"$LOG").endswith(b"[LOGGED:20x22]\r\nok\r\n"), "more than the UART's buffer holds"
    show("a job stored and run on the Pico", f"{machine.now_ms():.0f} emulated ms")


def read_ms(machine, count):
    """(bytes of a job of `count` lines, emulated ms from its start to its first step)."""
    lines = [b"G1X%d.%03dY%d.%03dF%d" % (n * 7 % 9, n * 373 % 1000, n * 5 % 7, n * 611 % 1000, 3000 + n) for n in range(count)]
    data = b"G91\nG1X0.5F3000\n" + b"\n".join(lines) + b"\n"
    packed = stored_job.pack_job(data)
    ask(machine, b"$FS=A,grbl,%d,%08x,%d" % (len(data), stored_job.crc_of(data), len(packed)))
    for at in range(0, len(packed), 54):
        ask(machine, b"$F:" + base64.b64encode(packed[at : at + 54]))
    assert ask(machine, b"$FE") == b"ok\r\n"
    start = list(machine.plant.position)
    ask(machine, b"$F=A")
    begin = machine.now_ms()
    for _ in range(3):
        machine.send(b"?")
        machine.run_ms(20)
    machine.run_until(lambda: machine.plant.position != start)
    took = machine.now_ms() - begin
    said = machine.take()
    machine.send(b"\x18")
    machine.run_until(lambda: b"error 157" in machine.replies_so_far())
    ask(machine, b"$X")
    return len(data), took, said


@pytest.mark.slow
def test_a_job_is_read_whole_before_it_begins(make_machine, show):
    """At most 2 s a megabyte; `?` is answered meanwhile, and tells how far it is."""
    machine = ready(make_machine(fast_router()))
    few, short, _ = read_ms(machine, 1000)
    many, long, said = read_ms(machine, 3000)
    assert re.search(rb"\|SD:\d+,A\?", said)
    rate = (long - short) * 1000 / (many - few)
    show("reading a stored job before it begins", f"{short:.0f} emulated ms for {few} bytes, {rate:.2f} s a megabyte more")
    assert rate < 2


@lru_cache
def streamed(data):
    """(digest, steps, of them at full speed, seconds) of a job that is streamed to the virtual board."""
    machine = VirtualMachine(fast_router(), trace=None)
    machine.send(b"$X\n")
    machine.settle()
    steps = StepDigest(machine.plant)
    stream(machine, data)
    return steps.digest(), steps.count, steps.at_speed, steps.seconds()


def run_from_flash(machine, limit_s):
    """The digest of the steps of the job BIG, up to its end. The word for steps that came late is not said."""
    steps = StepDigest(machine.plant)
    ask(machine, b"$F=BIG")
    machine.run_until(lambda: b"[MSG:Job BIG" in machine.replies_so_far(), 1000 * limit_s, slice_us=10_000)
    machine.settle()
    assert machine.take().endswith(b"[MSG:Job BIG done]\r\n")
    assert b"x109" not in ask(machine, b"$LOG")
    assert not machine.plant.errors
    return steps.digest()


@pytest.mark.slow
@pytest.mark.parametrize("run", (1, 2, 3))
def test_a_large_job_is_read_while_three_axes_step_at_50_khz(make_machine, show, run):
    """Tick by tick as it is streamed. PASSO_JOB_BYTES=1000000 and -o faulthandler_timeout=0: a megabyte, 98 s of motion, in a quarter of an hour
    and more for each run."""
    data = dense_job(int(os.environ.get("PASSO_JOB_BYTES", "40000")))
    wanted, count, at_speed, seconds = streamed(data)
    assert at_speed > 0.97 * count
    machine = make_machine(fast_router(), files={**files_of(fast_router()), "jobs/BIG.job": stored_job.job_file("grbl", data)}, trace=None)
    machine.pico.charge_flash(MISS_CYCLES)
    ready(machine)
    found = run_from_flash(machine, 2 * seconds + 10)
    show(f"a job of {len(data)} bytes from flash, run {run}", f"{count} words in {seconds:.1f} s, 0 late, {found[:16]}")
    assert found == wanted


@pytest.mark.slow
def test_the_journal_is_written_to_raw_flash_while_it_moves(make_machine, show):
    """Every step comes in time, and the file system, whose blocks it has, is whole after a power cut."""
    machine = ready(make_machine(with_journal()))
    assert ask(machine, b"$JR=1234") == b"ok\r\n"
    machine.send(b"N1G91G1X3F3000\nN2G1X3\nN3G1X-6\n")
    machine.run_ms(900)
    machine.settle()
    machine.take()
    assert b"x109" not in ask(machine, b"$LOG")
    assert b"[JOURNAL:00001234|3|1|0,0,0]" in ask(machine, b"$JR")
    files = machine.pico.files()
    data = files["journal.0"]
    found = [unpack_record(data[at : at + 32]) for at in range(0, 4096, 32) if data[at : at + 32] != b"\xff" * 32]
    assert [record[0] for record in found] == list(range(len(found))) and len(found) > 5
    assert found[-1][1:] == (1, 0x1234, 3, [0, 0, 0, 0])
    assert {record[3] for record in found} == {0, 1, 2, 3} and any(record[4][0] > 900 for record in found)
    show("records of the journal while three lines are stepped", str(len(found)))

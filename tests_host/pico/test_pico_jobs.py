"""Stored jobs on the emulated Pico: uploaded over a UART, read from its flash while three axes step."""

import base64
import hashlib

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator.machine import EmulatedMachine, written
from host_tools.programs import stored_job
from host_tools.sim.machine import VirtualMachine
from passo.config.job_store import first_line
from passo.control.job_journal import unpacked

LINE_MM = 2  # of each axis: 640 steps, in 13 ms
BYTES = 1_000_000
LINES = 60
SMALL = b"G91\nG1X0.5Y0.2F3000\n\nG1X-0.5\nM30\n"


def board():
    """A router whose axes all step at 50 kHz along a diagonal."""
    made = {**boards.load("router_3axis"), "jobs": {"language": "grbl"}, "memory": "lean"}
    made["links"] = [{"name": "serial", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl"}]
    made["axes"] = [{**axis, "steps_per_m": 320_000, "max_mm_min": 9375, "accel_mm_s2": 4000} for axis in made["axes"]]
    return made


def long_job(size=BYTES):
    """Lines of 40 bytes, to and fro on a diagonal in space, none like its neighbours; and where it ends after LINES of them."""
    lines = [b"G21G91G94F16238"]
    for number in range(LINES):
        far = LINE_MM + number * 7 % 10 / 10
        lines.append(b"N%06dG1X%.5fY%.5fZ%.5f" % (number + 2, *[far if number % 2 else -far] * 3))
    lines.append(b"M30")
    number = len(lines)
    while size > 0:
        number += 1
        lines.append(b"N%06dG1X%.5fY%.5fZ%.5f" % (number, number % 97 / 13, number % 89 / 17, number % 83 / 19))
        size -= len(lines[-1]) + 1
    return b"\n".join(lines) + b"\n"


def job_file(data):
    packed = stored_job.pack(data)
    return first_line("grbl", len(data), stored_job.crc(data), len(packed)) + packed


def ask(machine, line):
    """What is said up to the answer to a line."""
    machine.take()
    machine.send(line + b"\n")
    machine.run_until(lambda: b"ok\r\n" in machine.received() or b"error:" in machine.received())
    return machine.take()


def ready(machine):
    machine.run_until(lambda: b"unlock]" in machine.received())
    machine.run_ms(50)
    assert ask(machine, b"$X").endswith(b"ok\r\n")
    return machine


def digest(rows, start):
    """(of the steps, in ticks from the first one and from where the machine stood; how many rows)."""
    begun = round(rows[0][0] * 12.5)
    steps = [(round(row[0] * 12.5) - begun, *[at - then for at, then in zip(row[1:4], start)]) for row in rows]
    return hashlib.sha256(repr(steps).encode()).hexdigest(), len(steps)


def test_a_job_is_uploaded_and_run(make_machine, show):
    machine = ready(make_machine(board()))
    packed = stored_job.pack(SMALL)
    assert ask(machine, b"$FS=A,grbl,%d,%08x,%d" % (len(SMALL), stored_job.crc(SMALL), len(packed))) == b"ok\r\n"
    assert ask(machine, b"$F:" + base64.b64encode(packed)) == b"ok\r\n"
    assert ask(machine, b"$FE") == b"ok\r\n"
    assert b"[FILE:A|SIZE:%d|" % len(SMALL) in ask(machine, b"$F")
    start = list(machine.plant.position)
    ask(machine, b"$F=A")
    machine.run_until(lambda: b"[MSG:Job A done]" in machine.received())
    assert [at - then for at, then in zip(machine.plant.position, start)] == [0, 64, 0]
    show("a job stored and run on the Pico", f"{machine.now_ms():.0f} emulated ms")


@pytest.mark.slow
def test_a_megabyte_is_read_while_three_axes_step_at_50_khz(make_machine, tmp_path, show):
    """Its first LINES, from the board's file system of 1.4 MB: tick by tick as on the virtual board."""
    data = long_job()
    (tmp_path / "jobs").mkdir()
    (tmp_path / "jobs" / "BIG.job").write_bytes(job_file(data))
    virtual = VirtualMachine(board(), flash=tmp_path)
    virtual.send(b"$X\n")
    virtual.settle()
    start = list(virtual.plant.position)
    before = len(virtual.trace.rows())
    virtual.send(b"$F=BIG\n")
    virtual.run_until(lambda: virtual.plant.position != start, 1000)
    virtual.run_ms(LINES * 15)
    wanted = digest(virtual.trace.rows()[before:], start)
    files = {**written(board()), "jobs/BIG.job": job_file(data)}
    found = []
    for _ in range(3):
        machine = ready(make_machine(board(), files=files))
        start = list(machine.plant.position)
        before = len(machine.trace.rows())
        ask(machine, b"$F=BIG")
        machine.run_until(lambda: len(machine.trace.rows()) >= before + wanted[1], slice_us=100_000)
        found.append(digest(machine.trace.rows()[before : before + wanted[1]], start))
        machine.send(b"\x18")
        machine.run_ms(100)
        assert b"x109" not in ask(machine, b"$LOG")
    assert found == [wanted] * 3
    show("words from flash at 50 kHz on three axes", f"{wanted[1]}, three times the same")


@pytest.mark.slow
def test_the_journal_is_written_to_raw_flash_while_it_moves(make_machine, show):
    """No step is late for it, and the file system, whose blocks it has, is whole after a power cut."""
    made = {**boards.load("router_3axis"), "links": board()["links"], "journal": {"every_ms": 100}}
    machine = ready(make_machine(made))
    assert ask(machine, b"$JR=1234") == b"ok\r\n"
    machine.send(b"N1G91G1X3F3000\nN2G1X3\nN3G1X-6\n")
    machine.run_ms(900)
    machine.settle()
    machine.take()
    assert b"x109" not in ask(machine, b"$LOG")
    assert b"[JOURNAL:00001234|3|1|0,0,0]" in ask(machine, b"$JR")
    files = machine.pico.files()
    data = files["journal.0"]
    found = [unpacked(data[at : at + 32]) for at in range(0, 4096, 32) if data[at : at + 32] != b"\xff" * 32]
    assert [record[0] for record in found] == list(range(len(found))) and len(found) > 5
    assert found[-1][1:] == (1, 0x1234, 3, [0, 0, 0, 0])
    assert {record[3] for record in found} == {0, 1, 2, 3} and any(record[4][0] > 900 for record in found)
    show("records of the journal while three lines are stepped", str(len(found)))

"""Failures of stored jobs, on the emulated Pico: no room, torn uploads, power cuts, a PC that closes its port."""

import base64
import random

import pytest
from dense_job import fast_router
from emulated import uf2  # noqa: F401
from test_pico_jobs import ask, ready

from host_tools import boards
from host_tools.emulator.machine import EmulatedMachine, files_of
from host_tools.programs import stored_job

pytestmark = pytest.mark.slow
OLD = b"G91\nG1X0.5Y0.2F3000\nG1X-0.5\nM30\n"  # ends 64 steps along Y
OLD_STEPS = [0, 64, 0]
LOST_MS = 500


def new_job(seed, lines=3000):
    """Lines that deflate little."""
    chance = random.Random(seed)
    return b"F600\n" + b"".join(b"G1X%.4fY%.4f\n" % (chance.uniform(-99, 99), chance.uniform(-99, 99)) for _ in range(lines))


def begin(machine, name, data, packed, **changes):
    crc = changes.get("crc", stored_job.crc_of(data))
    return ask(machine, b"$FS=%s,grbl,%d,%08x,%d" % (name, len(data), crc, changes.get("stored", len(packed))))


def send(machine, packed):
    for first in range(0, len(packed), 54):
        assert ask(machine, b"$F:" + base64.b64encode(packed[first : first + 54])) == b"ok\r\n"


def store(machine, name, data, **changes):
    packed = stored_job.pack_job(data)
    assert begin(machine, name, data, packed, **changes) == b"ok\r\n"
    send(machine, packed)
    return ask(machine, b"$FE")


def runs(machine, name, steps=None):
    """Run a job to its end; `steps`: by how many it has to move, on each axis."""
    start = list(machine.plant.position)
    ask(machine, b"$F=" + name)
    machine.run_until(lambda: b"[MSG:Job %s done]" % name in machine.replies_so_far())
    machine.settle()
    if steps:
        assert [at - then for at, then in zip(machine.plant.position, start)] == steps


def free(machine):
    return int(ask(machine, b"$F").rpartition(b"[FREE:")[2].partition(b"]")[0])


@pytest.fixture
def machine_of(uf2):
    machines = []

    def make(board, files, image=None):
        machine = EmulatedMachine(board, files=files, uf2=uf2, trace=None)
        machines.append(machine)
        if image is not None:
            pico = machine.pico
            pico.chip.flash[pico._files_at : pico._files_at + len(image)] = image
        machine.boot()
        if machine.board["links"][0]["port"] != "usb":
            return ready(machine)
        machine.run_until(lambda: b"code in" in machine.pico.console.text)  # the last words of the start
        machine.run_ms(300)
        assert ask(machine, b"$X").endswith(b"ok\r\n")
        return machine

    yield make
    for machine in machines:
        machine.close()


def test_no_upload_that_fails_loses_a_job(machine_of, show):
    """Full flash, fewer bytes than announced, a wrong CRC-32, bytes that are no job, the same name twice, delete while it runs,
    power cuts amid an upload: the stored jobs run as before."""
    board = fast_router()
    firmware = files_of(board)
    room = free(machine_of(board, firmware))
    machine = machine_of(board, {**firmware, "fill": bytes(room - 16_384)})
    assert store(machine, b"A", OLD) == b"ok\r\n"
    left = free(machine)
    new = new_job(1)
    packed = stored_job.pack_job(new)
    assert left < len(packed), (left, len(packed))
    assert begin(machine, b"B", new, packed) == b"error:152\r\n"
    assert begin(machine, b"A", new, packed) == b"error:152\r\n"
    small = new_job(2, 400)
    assert store(machine, b"B", small, crc=1) == b"error:151\r\n"
    assert begin(machine, b"A", small, stored_job.pack_job(small)) == b"ok\r\n"
    assert ask(machine, b"$FE") == b"error:156\r\n"
    picture = bytes(range(256))
    assert begin(machine, b"A", small, picture) == b"ok\r\n"
    send(machine, picture)
    assert ask(machine, b"$FE") == b"error:151\r\n"
    runs(machine, b"A", OLD_STEPS)
    assert free(machine) == left
    assert store(machine, b"B", small) == b"ok\r\n" and store(machine, b"B", small + b"G4P0\n") == b"ok\r\n"
    assert ask(machine, b"$F").count(b"[FILE:") == 2
    ask(machine, b"$F=B")
    machine.run_ms(100)
    assert ask(machine, b"$FD=B") == b"error:112\r\n"
    machine.send(b"\x18")
    machine.run_ms(300)
    ask(machine, b"$X")
    assert b"[FILE:B|SIZE:%d|" % (len(small) + 5) in ask(machine, b"$F")
    assert ask(machine, b"$FD=B") == b"ok\r\n" and b"FILE:B" not in ask(machine, b"$F")
    chance = random.Random(3)
    for _ in range(2):  # each time from the files that the cut before has left
        assert begin(machine, b"A", small, stored_job.pack_job(small)) == b"ok\r\n"
        data = stored_job.pack_job(small)
        send(machine, data[: chance.randrange(54, len(data) - 54, 54)])
        machine.send(b"$F:" + base64.b64encode(data[-54:]) + b"\n")
        machine.pico.run(chance.randrange(100_000))
        machine = machine_of(board, firmware, machine.pico.image())
        runs(machine, b"A", OLD_STEPS)
        assert free(machine) == left
    show("uploads refused and torn", "the job of before runs")


def test_a_pc_that_closes_its_port_is_a_host_that_is_lost(machine_of, show):
    """DTR goes: nothing that the board says blocks it, the link's watchdog holds the machine, and the upload under way leaves what
    was there. DTR comes back: the machine answers, and goes on."""
    board = {**fast_router(), "links": boards.load("router_3axis")["links"]}
    board["links"][0] = {**board["links"][0], "lost": "pause", "lost_ms": LOST_MS}
    machine = machine_of(board, files_of(board))
    assert store(machine, b"A", OLD) == b"ok\r\n"
    port = machine.pico.usb._cdc
    packed = stored_job.pack_job(new_job(4))
    assert begin(machine, b"A", new_job(4), packed) == b"ok\r\n"
    send(machine, packed[:540])
    port.set_control_lines(dtr=False, rts=False)
    machine.run_ms(1500)
    port.set_control_lines(dtr=True, rts=True)
    machine.run_ms(50)
    runs(machine, b"A", OLD_STEPS)
    machine.send(b"G91\nG1X200F6000\n?")
    said_ms = machine.now_ms()
    machine.run_ms(400)
    resets = machine.pico.usb.connections
    port.set_control_lines(dtr=False, rts=False)
    before = -1
    while machine.wiring.edge_count != before:
        before = machine.wiring.edge_count
        machine.send(b"?", "serial")  # another link's questions are no sign of life
        machine.run_ms(20)
    stood_ms = machine.now_ms() - said_ms
    assert LOST_MS < stood_ms < LOST_MS + 200
    machine.take("serial")
    machine.send(b"?", "serial")
    machine.run_ms(50)
    assert b"<Hold:0|" in machine.take("serial")
    machine.run_ms(3000)
    assert machine.pico.usb.connections == resets  # no reset by the watchdog
    port.set_control_lines(dtr=True, rts=True)
    machine.take()
    machine.send(b"?")
    machine.run_ms(50)
    assert b"<Hold:0|" in machine.take()
    start = list(machine.plant.position)
    machine.send(b"~")
    machine.run_ms(200)
    assert machine.plant.position[0] > start[0]
    machine.send(b"\x18")
    machine.run_ms(100)
    assert b"x118" in ask(machine, b"$LOG")
    show("stand after the last byte of a PC that has closed its port", f"{stood_ms:.0f} ms, lost_ms {LOST_MS}")

"""Pulse codes on the emulated Pico: as many a second as the language asks for, and the words of the golden file."""

from random import Random
from statistics import median

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools import boards
from host_tools.build.tree import select_modules
from host_tools.emulator.pico import EmulatedPico
from passo.protocols.pulses.protocol import ACK, CREDIT, WINDOW, frame
from test_digest import CHECKS, PICO_PULSES, ROOT, golden_of_gcode, hex_of
from test_pico_digest import compiled

LIMIT_US = 30_000_000
BYTE_US = 1e7 / 230_400
AT_LEAST = 4000  # codes a second
# As of a circle: runs of one and two codes. At 3750 mm/min a step of 12.5 µm takes 200 µs, a diagonal 283.
TEXT = "[+3750" + "AAGAGAAG" * 50 + "CCGCGCCG" * 50


@pytest.fixture
def machine(make_machine):
    """A router whose drivers are faster than those of 2009."""
    board = boards.load("lpt_router")
    board["step_program"]["interval_us"] = 100
    board["drive"]["pulse_us"] = 3
    board["links"][0]["baud"] = 230400
    return make_machine(board)


def send_file(machine, data):
    """Send the bytes of a file, no more under way than the board's credit allows. Returns what it has answered."""
    heard = bytearray()
    sent = 0
    while sent < len(data):
        room = min(WINDOW + heard.count(ACK) * CREDIT - sent, CREDIT)
        machine.send(data[sent : sent + room])
        sent += room
        machine.run_ms(2)
        heard.extend(machine.take())
    return heard


def test_streamed_codes(machine, show):
    heard = bytearray()

    def until(word, limit_ms=6000):
        end = machine.now_ms() + limit_ms
        while word not in heard:
            assert machine.now_ms() < end, bytes(heard)
            machine.run_ms(2)
            heard.extend(machine.take())

    until(b"ready\n")
    data = TEXT.encode()
    machine.send(frame("stream", len(data)) + b"\n")
    until(b"ok\n")
    heard.clear()
    assert b"error" not in send_file(machine, data)
    machine.send(frame("end"))
    until(b"end\n")
    rows = machine.trace.rows()
    rows = rows[-800:]
    assert [rows[-1][axis] - rows[0][axis] for axis in (1, 2)] == [549, 550]
    rate = 799e6 / (rows[-1][0] - rows[0][0])
    show("pulse codes streamed to the Pico", f"{rate:.0f} a second")
    assert rate >= AT_LEAST
    assert max(after[0] - before[0] for before, after in zip(rows, rows[1:])) < 300  # nothing was waited for
    assert not machine.plant.errors


@pytest.mark.slow
def test_live_speed(machine, show):
    """From the last byte of the command on the wire to another interval on the pins."""
    file = b"[" + b"A" * 3499

    def ask(data, answer=b"ok"):
        machine.take()
        machine.send(data)
        machine.run_until(lambda: answer in machine.replies_so_far(), 3000)

    machine.run_until(lambda: b"ready" in machine.replies_so_far(), 3000)
    ask(frame("load", len(file)) + b"\n")
    machine.take()
    assert b"error" not in send_file(machine, file)
    ask(frame("end"))
    ask(frame("speed", 1200))
    ask(frame("run"))
    random = Random(5)
    delays = []
    for speed in (2400, 700, 3600, 1500, 3000, 900, 2000, 1100, 2700, 600):
        machine.run_ms(random.uniform(40, 60))
        data = frame("speed", speed)
        known = len(machine.trace.rows())
        machine.send(data)
        sent_us = machine.now_ms() * 1000 + len(data) * BYTE_US
        machine.run_ms(60)
        us = [row[0] for row in machine.trace.rows()[known:]]
        wanted = 750_000 / speed
        delays.append(next(at for at, after in zip(us, us[1:]) if abs(after - at - wanted) < 3) - sent_us)
    show("another speed, live on the Pico", f"on the pins after {', '.join(f'{us / 1000:.1f}' for us in delays)} ms")
    assert median(delays) < 15_000 and sorted(delays)[-2] < 20_000  # now and then garbage is collected in between


@pytest.mark.slow
def test_the_pico_makes_the_words_of_the_golden_file(uf2, show):
    sources = {path.as_posix(): ROOT / "firmware" / path for path in select_modules(boards.load("lpt_router"))}
    files = compiled({**sources, "digest.py": CHECKS / "digest.py"})
    files["boards/__init__.py"] = b""
    files["boards/lpt_router.py"] = boards.path("lpt_router").read_bytes()
    files["job.hex"] = hex_of(PICO_PULSES).encode()
    pico = EmulatedPico(files=files, uf2=uf2).boot()
    before = pico.cycle
    code = "import gc\ngc.threshold(16000)\nimport digest\ndigest.main(['job.hex', 'lpt_router'])"
    said = pico.exec(code, limit_us=LIMIT_US).split()
    assert said == golden_of_gcode()["pico_pulses"]
    show("digest of a step program on the Pico", f"{said[1]} words in {(pico.cycle - before) / 125e6:.2f} emulated s")


@pytest.mark.slow
def test_bits_of_the_port_on_the_pins(make_machine):  # noqa: F811
    """The tool's bit disabled, X's pulse inverted, by lines: on the pads of the chip."""
    board = boards.load("lpt_router")
    board["step_program"].update({"port_pins": [8, 5, 2, 6, 3, 7, 4, 9], "port_bits": "7654321-", "port_invert": 0x04})
    machine = make_machine(board)
    tool, x_step, y_step = (machine.pico.record_edges(pin) for pin in (8, 2, 3))
    heard = bytearray()

    def until(word):
        for _ in range(200):
            if word in heard:
                return
            machine.run_ms(10)
            heard.extend(machine.take())
        raise AssertionError(bytes(heard))

    until(b"ready")
    machine.send(b"{load}[+2000(AAC)]{end}")
    until(b"ok 8")
    machine.send(b"{run}")
    until(b"end")
    assert 1 not in [state for _, state in tool]
    assert [state for _, state in x_step][-5:] == [1, 0, 1, 0, 1]  # it rests high
    assert [state for _, state in y_step if state == 1] == [1] and y_step[-1][1] == 0

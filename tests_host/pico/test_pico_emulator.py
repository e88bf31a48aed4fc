"""The emulated Pico itself: the effect of the patches, the file system, resets, and the wires to the plant."""

import pytest
from emulated import make_machine, pico, uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator import pio
from host_tools.emulator.console import RemoteError
from host_tools.emulator.pads import RELEASED
from host_tools.emulator.pico import MAIN_US, EmulatedPico

CYCLES_PER_US = 125


def intervals(edges):
    return [after[0] - before[0] for before, after in zip(edges, edges[1:])]


def test_code_files_and_errors(uf2):
    files = {"main.py": b"import room.a\nprint('main', room.a.X)", "room/a.py": b"X = 5\n", "empty/b.txt": b""}
    pico = EmulatedPico(files=files, uf2=uf2).boot()
    assert pico.files() == files
    pico.console.send(b"\r")  # text printed before USB was up comes with the next output
    pico.console.expect(b"main 5\r\n")
    assert pico.exec("print(6 * 7)") == "42\r\n"
    with pytest.raises(RemoteError, match="ZeroDivisionError"):
        pico.exec("1 / 0")
    pico.exec("with open('new.txt', 'w') as file: file.write('kept')")
    assert pico.files()["new.txt"] == b"kept"
    assert pico.power_cycle().exec("print(open('new.txt').read())") == "kept\r\n"


def test_the_processor_is_not_kept_busy_by_usb(pico):
    before = pico.cycle
    pico.exec("for i in range(10000): pass")
    assert (pico.cycle - before) / CYCLES_PER_US < 60_000, "46 ms of loop, and the REPL's own"


def test_the_same_calls_give_the_same_cycles(uf2):
    runs = []
    for _ in range(2):
        pico = EmulatedPico(uf2=uf2).boot()
        edges = pico.record_edges(2)
        pico.exec("from machine import Pin\np = Pin(2, Pin.OUT)\nfor i in range(50): p.toggle()")
        runs.append((edges, pico.cycle))
    assert runs[0] == runs[1] and len(runs[0][0]) == 51


# --- PIO

CLOCKED = """
import rp2, time
from machine import Pin
@rp2.asm_pio(set_init=rp2.PIO.OUT_LOW)
def fast():
    wrap_target()
    set(pins, 1)
    set(pins, 0) [2]
    wrap()
@rp2.asm_pio(sideset_init=rp2.PIO.OUT_LOW)
def slow():
    nop().side(1)
    nop().side(0)
a = rp2.StateMachine(4, fast, freq=125_000_000, set_base=Pin(6))
b = rp2.StateMachine(0, slow, freq=76_800, sideset_base=Pin(8))
b.active(1)
time.sleep_ms(3)
b.active(0)
a.active(1)
a.active(0)
"""


def test_pio_runs_by_the_clock_asleep_and_awake(pico):
    fast, slow = pico.record_edges(6), pico.record_edges(8)
    pico.exec(CLOCKED)
    assert set(intervals(fast)[2:-1]) == {1, 3}
    periods = intervals(slow)[2:-1]
    assert set(periods) == {1627, 1628}
    assert sum(periods) / len(periods) == pytest.approx(125e6 / 76_800, abs=0.01)


PLAYED = """
import array, rp2, time
from machine import Pin
@rp2.asm_pio(out_init=(rp2.PIO.OUT_LOW,) * 3, out_shiftdir=rp2.PIO.SHIFT_RIGHT)
def play():
    wrap_target()
    pull(block)
    out(pins, 3)
    out(x, 29)
    mov(y, isr)
    label("high")
    jmp(x_dec, "on")
    label("on")
    jmp(y_dec, "high") [7]
    label("wait")
    jmp(pin, "wait")
    nop() [3]
    jmp(x_dec, "wait")
    wrap()
guard = Pin(9, Pin.IN, Pin.PULL_DOWN)
machine = rp2.StateMachine(0, play, freq=125_000_000, out_base=Pin(2), jmp_pin=guard)
words = array.array("I", ((i * 37 % 20 + 10) * 20 << 3 | i & 7 for i in range(200)))
dma = rp2.DMA()
dma.config(read=words, write=machine, count=200, ctrl=dma.pack_ctrl(inc_write=False, treq_sel=0))
machine.put(25)
machine.exec("pull()")
machine.exec("mov(isr, osr)")
machine.active(1)
dma.active(1)
time.sleep_ms(2)
machine.active(0)
machine.exec("mov(isr, x)")
machine.exec("push(noblock)")
print(machine.get(), machine.tx_fifo(), dma.count)
machine.active(1)
time.sleep_ms(2)
"""


def test_delay_loops_run_through_ahead_are_as_if_stepped(uf2, monkeypatch):
    runs = []
    for skipping in (True, False):
        monkeypatch.setattr(pio.TimedPio, "skipping", skipping)
        pico = EmulatedPico(uf2=uf2).boot()
        edges = [pico.record_edges(gpio) for gpio in (2, 3, 4)]

        def pulse(pico=pico):
            pico.drive_pin(9, 1)
            pico.call_at(pico.cycle + 777, lambda: pico.drive_pin(9, 0))

        for number in range(5):
            pico.call_at(pico.cycle + (12_000 + 611 * number) * CYCLES_PER_US, pulse)
        runs.append((pico.exec(PLAYED), edges, pico.cycle))
    assert runs[0] == runs[1]
    assert int(runs[0][0].split()[0]) > 0 and int(runs[0][0].split()[2]) > 0, "it was frozen inside a word"


# --- pins

PINS = """
from machine import Pin
out, pin = Pin(2, Pin.OUT), Pin(5, Pin.IN, Pin.PULL_UP)
out.on()
print(out.value(), pin.value())
edges = 0
def heard(pin):
    global edges
    edges += 1
pin.irq(heard, Pin.IRQ_FALLING | Pin.IRQ_RISING, hard=True)
"""


def test_pins_have_two_sides(pico):
    edges = pico.record_edges(2)
    assert pico.exec(PINS) == "1 1\r\n"
    for level in (0, 0, 1, 0, None, None):
        pico.drive_pin(5, level)
        pico.run(100)
    assert pico.exec("print(edges, pin.value())") == "4 1\r\n"
    pico.hard_reset()
    assert [state for _, state in edges] == [0, 1, RELEASED]


# --- UART

def test_uart_at_the_pace_of_the_wire(pico):
    wire = pico.uart(0)
    pico.exec("from machine import UART, Pin\nu = UART(0, 57600, tx=Pin(0), rx=Pin(1), rxbuf=512)")
    sent = bytes(range(256))
    before = pico.cycle
    end = wire.feed(sent, 57600)
    assert (end - before) / 125e6 == pytest.approx(256 * 10 / 57600, abs=1e-6)
    pico.run(50_000)
    assert pico.exec("data = u.read()\nprint(data == bytes(range(256)))") == "True\r\n"
    pico.exec("u.write(data)\nu.flush()")
    gaps = [(b - a) / CYCLES_PER_US for a, b in zip(wire.stamps, wire.stamps[1:])]
    assert wire.drain() == sent and wire.overruns == 0
    assert sum(gaps) / len(gaps) == pytest.approx(10e6 / 57600, rel=0.002) and max(gaps) < 180
    for value in sent:
        pico.chip.uart[0].feed_byte(value)
    assert wire.overruns == 256 - 32, "the FIFO has room for 32"


# --- resets

def test_causes_of_a_reset(pico):
    def cause():
        return pico.exec("import machine\nprint(machine.reset_cause())")

    assert cause() == "1\r\n"
    pico.console.start("import machine\nmachine.reset()")
    pico.await_reset()
    assert cause() == "3\r\n"
    pico.console.start("from machine import WDT\nWDT(timeout=100)\nimport time\nwhile True: time.sleep_ms(10)")
    before = pico.now_us
    pico.await_reset()
    assert 100_000 < pico.now_us - MAIN_US - before < 130_000
    assert cause() == "3\r\n"
    pico.hard_reset()
    assert cause() == "1\r\n"


# --- wiring

STEPPING = """
import time
from machine import Pin
coils = [Pin(n, Pin.OUT) for n in (2, 3, 4, 5)]
tool, barrier = Pin(10, Pin.OUT), Pin(14, Pin.IN)
HALF = (1, 3, 2, 6, 4, 12, 8, 9)
def step(phase):
    for coil, pin in enumerate(coils):
        pin.value(HALF[phase & 7] >> coil & 1)
    time.sleep_us(200)
for phase in range(21):
    step(phase)
tool.on()
time.sleep_ms(80)
tool.off()
for phase in range(20, -41, -1):
    step(phase)
    if phase == 0:
        print("off", barrier.value())
print("on", barrier.value())
"""


def test_pins_move_the_plant_and_its_barriers_are_seen(make_machine, tmp_path):
    vcd = tmp_path / "pins.vcd"
    board = boards.load("plotter_2014")
    machine = make_machine(board, {}, vcd=vcd, start=(0, 500))
    assert machine.pico.exec(STEPPING) == "off 0\r\non 1\r\n"
    machine.run_ms(100)
    assert machine.plant.position == [-40, 500] and machine.plant.errors == []
    rows = machine.trace.rows()
    assert {row[1] for row in rows if row[5] == 1000} == set(range(20, -41, -1)), "let go, the pen takes 60 ms to rise"
    assert max(row[1] for row in rows) == 20 and rows[-1][1:] == (-40, 0, 0, 0, 0), "unhomed, the start is 0"
    machine.close()
    text = vcd.read_text()
    assert " x_s1 $end" in text and " barrier_x $end" in text and text.count("\n") > 100

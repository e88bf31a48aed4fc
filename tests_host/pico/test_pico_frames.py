"""How long the ESP32's kernel of frames takes, counted on the one processor that is emulated here.

An ESP32 at 240 MHz has 960 cycles a frame. MicroPython makes much the same code for Xtensa as for Thumb: an operation is one
instruction or two, an array's element four or five, and the file is of nearly the same length; it lies in RAM on both. Half as
many cycles again as on the RP2040 are assumed. Nobody has measured it on an ESP32.
"""

from emulated import uf2  # noqa: F401

from host_tools.build.tree import compile_module, unix_tree
from host_tools.emulator.pico import EmulatedPico

KERNEL = "passo/ports/esp32/frames_viper.py"
XTENSA_CYCLES = 1.5  # for one of the RP2040's
ESP32_CYCLES = 240_000_000 // 250_000  # a frame
BLOCK = 256
PREPARE = """
from array import array
from time import ticks_diff, ticks_us
import frames_viper as kernel
def zeros(count):
    return array("i", [0] * count)
def begin(ticks):
    global state, words, starts, table, frames
    state, starts, table, frames = zeros(18), zeros(512), zeros(256), zeros(256)
    words = array("I", [ticks << 7 | 7] * 512)
    state[kernel.MASK], state[kernel.BITS], state[kernel.HEAD], state[kernel.PULSES] = 511, 7, 1 << 20 if ticks else 0, 7
    state[kernel.PULSE_FRAMES], state[kernel.KEEP], state[kernel.REST] = 1, -8, kernel.ON_A_FRAME
def took(count):
    since = ticks_us()
    for _ in range(40):
        kernel.make(frames, 0, 0, count, state, words, starts, table)
    print(ticks_diff(ticks_us(), since))
"""
CYCLES_A_US = 125


def cycles(pico, count):
    """Of a call for `count` frames, from forty of them."""
    return int(pico.exec("took(%d)" % count)) * CYCLES_A_US / 40


def test_three_axes_at_60_khz_fit(uf2, tmp_path, show):  # noqa: F811
    compile_module(unix_tree() / KERNEL, tmp_path / "frames_viper.mpy", "armv6m", KERNEL)
    for architecture in ("armv6m", "xtensawin"):
        compile_module(unix_tree() / KERNEL, tmp_path / f"{architecture}.mpy", architecture, KERNEL)
    sizes = [(tmp_path / f"{architecture}.mpy").stat().st_size for architecture in ("armv6m", "xtensawin")]
    assert sizes[1] < 1.3 * sizes[0], "code for Xtensa is no longer as long"
    code = (tmp_path / "frames_viper.mpy").read_bytes()
    files = {"frames_viper.mpy": code, "passo/__init__.py": b"", "passo/records.py": b"COUNT_MASK = 0x1FFFFFFF\n"}
    pico = EmulatedPico(files=files, uf2=uf2).boot()
    pico.exec(PREPARE)
    found = []
    for what, ticks in (("at rest", 0), ("three axes in step, 60 kHz", 208), ("a word every other frame, the most", 100)):
        pico.exec("begin(%d)" % ticks)
        found.append((what, cycles(pico, BLOCK) / BLOCK))
    lines = ["%-36s %6.1f cycles a frame, %4.1f %% of an ESP32" % (what, n, 100 * XTENSA_CYCLES * n / ESP32_CYCLES) for what, n in found]
    show("frames of the I2S, on an RP2040", "\n".join(lines + ["bytes: %d for Thumb, %d for Xtensa" % tuple(sizes)]))
    assert [XTENSA_CYCLES * n < ESP32_CYCLES * part for (_, n), part in zip(found, (1 / 8, 1 / 3, 1 / 2))] == [True] * 3

"""The player of an ESP32 whose motors hang on 74HC595 shift registers: an I2S shifts out the levels of all of them 250 000
times a second, by DMA. Neither garbage collection nor Wi-Fi moves an edge.

    ring ─► make() ─► block of 256 frames ─► the driver's 16 blocks ─► SER of the registers; WS latches them
                                                                       └─► PCNT counts frames: words_played()

Frames: 16-bit stereo, both halves the same 16 bits, so that their order in memory does not matter. I2S (Philips) sends bits one
clock behind WS, whose rising edge is the registers' latch: it finds bits 15 … 1 of the left half in the first 15
outputs. QA of the first chip is bit 1. An edge is on the frame nearest to its word's time: 2 µs off at most.

The driver is in the mode that asyncio uses: write() copies a block or says that there is no room, and nothing waits. With an
irq() a task of its own would copy later, and a block handed to a full queue would be lost without a word.
Blocks are whole ones of the driver's: a part of one would be played with zeros behind it.

16 blocks, 16.4 ms, are on their way: the next pump() may come 11 ms later than usual without a delay of any edge. If the heap is PSRAM a
collection takes 22 ms and more: there are 32 blocks, and pump() may come 27 ms late. If it takes longer, the driver sends zeros: no step,
tool off. Less than two blocks before that the I2S is closed and opened: the words not played by then begin again after 17 ms (33), at their
speed, and `under_runs` counts one. No step is lost, no interval is shorter.

halt() closes the I2S: the clock ends inside a frame, and words are counted by the frames latched. The registers keep their
levels for the time that opening it again takes, less than a millisecond, or are cut off by `enable`; then zeros come.
Measure on silicon whether a first frame of the driver's own goes before ours: FIRST_FRAMES (docs/inside/silicon.md).
"""

import select
from array import array
from time import ticks_diff, ticks_us

import micropython
from esp32 import PCNT
from machine import I2S, Pin, mem32
from micropython import const

from passo.ports.esp32 import frames_viper
from passo.ports.esp32.chip import input_register
from passo.records import COUNT_MASK

RATE = const(250_000)
BLOCK = const(256)  # frames: the driver's own
_BLOCKS = const(16)  # in the driver's memory, 1 kB each
_PSRAM_BLOCKS = const(32)  # in a heap of PSRAM
FIRST_FRAMES = const(0)  # frames that the chip sends before the first of its memory
_MARGIN = const(512)  # frames: nearer to its end the driver may be reading what is being written
_LONGEST_US = const(1000)  # between two looks, for each block: then the driver has sent zeros, and the counter has not gone round yet
_COUNTS = const(32_000)  # the pulse counter begins again there
_INPUT_ENABLE = const(1 << 9)


def frame_of(output):
    """Return the bits of a frame for one output of the register."""
    bits = 0x20002 << output
    return bits - (1 << 32) if bits >> 31 & 1 else bits


class I2sPlayer:
    """`outputs`: of the word's bits, lowest first; `invert`: mask of the bits whose electrical level is the opposite;
    `section`: `shift` of the board file; `psram`: the heap is in it, and a collection takes longer. Methods as in virtual_player.py."""

    def __init__(self, ring, layout, outputs, pulse_ticks, invert, section, psram=False):
        if invert & (layout.pulse_mask | layout.tool_mask):
            raise ValueError("a frame of zeros would step: with shift registers $2 has to be 0, and the tool not inverted")
        pulse_frames = -(-pulse_ticks // frames_viper.FRAME_TICKS)
        self.min_word_ticks = 2 * pulse_frames * frames_viper.FRAME_TICKS
        self.under_runs = 0
        self._blocks = _PSRAM_BLOCKS if psram else _BLOCKS
        self._ring = ring
        self._layout = layout
        self._pins = [Pin(section[key]) for key in ("clock", "latch", "data")]
        self._enable = Pin(section["enable"], Pin.OUT, value=1) if section["enable"] >= 0 else None
        self._frames = array("i", [0] * BLOCK)
        self._starts = array("i", [0] * ring.size)
        self._table = array("i", [0] * 256)
        state = self._state = array("i", [0] * frames_viper.FIELDS)
        state[frames_viper.MASK] = ring.mask
        state[frames_viper.BITS] = layout.bits
        state[frames_viper.PULSES] = layout.pulse_mask
        state[frames_viper.PULSE_FRAMES] = pulse_frames
        state[frames_viper.REST] = frames_viper.ON_A_FRAME
        state[frames_viper.IDLE] = 1
        keep = -1
        for bit in range(len(outputs)):
            frame = frame_of(outputs[bit])
            half, index = divmod(bit, 7)
            for levels in range(128):
                if levels >> index & 1:
                    self._table[128 * half + levels] |= frame
            if invert >> bit & 1:
                state[frames_viper.FLIP] |= frame
            if layout.pulse_mask >> bit & 1:
                keep &= ~frame
        state[frames_viper.KEEP] = keep
        self._playing = self._held = self._pending = self._running = False
        self._input = input_register(section["latch"])
        self._head = 0  # of the ring, as start() saw it
        self._frame = 0  # latched so far, modulo 2²⁹
        self._poll = select.poll()
        # Before the I2S, which makes an output of the pin again; then only its input is switched on behind the driver's back.
        self._counter = PCNT(0, pin=self._pins[1], rising=PCNT.INCREMENT, max=_COUNTS, value=0)
        self._counter.start()
        self._open()

    # Machine code from here: callbacks come between two bytecodes, and none may come in the middle of these.

    @micropython.native
    def _open(self):
        """Open the I2S and switch its writes to never wait; count latched frames from here."""
        clock, latch, data = self._pins
        self._i2s = I2S(
            0, sck=clock, ws=latch, sd=data, mode=I2S.TX, bits=16, format=I2S.STEREO, rate=RATE, ibuf=4 * BLOCK * self._blocks
        )
        self._poll.register(self._i2s, select.POLLOUT)
        self._poll.poll(0)  # asking so switches the driver to writes that never wait
        self._poll.unregister(self._i2s)
        mem32[self._input] = mem32[self._input] | _INPUT_ENABLE
        self._counter.value(0)
        self._last = 0
        self._looked_us = ticks_us()
        # All blocks are sent as zeros first. Ours begin with one that only shows directions and outputs again.
        state = self._state
        state[frames_viper.FRAME] = self._frame + FIRST_FRAMES + BLOCK * self._blocks & COUNT_MASK
        state[frames_viper.HEAD] = state[frames_viper.NEXT]
        frames_viper.make(self._frames, 0, 0, BLOCK, state, self._ring.words, self._starts, self._table)
        self._pending = True
        self._running = True

    @micropython.native
    def _shut(self):
        """End the frames at once; the latched ones count, the rest is to be made again."""
        self._running = False
        self._i2s.deinit()
        self._look()
        state = self._state
        state[frames_viper.NEXT] = state[frames_viper.PLAYED]
        state[frames_viper.LEFT] = state[frames_viper.FALL] = state[frames_viper.RUNS] = 0
        state[frames_viper.IDLE] = 1
        state[frames_viper.REST] = frames_viper.ON_A_FRAME
        state[frames_viper.LEVELS] = state[frames_viper.SHOWN] & ~self._layout.pulse_mask

    @micropython.native
    def _look(self):
        """Count the frames latched, and the words that they have shown."""
        count = self._counter.value()
        latched = count - self._last
        if latched < 0:  # back to zero at its limit; or without that event, which is the driver's to enable, 16 bits gone round
            latched += _COUNTS if count >= 0 else 65_536
        self._frame = self._frame + latched & COUNT_MASK
        self._last = count
        self._looked_us = ticks_us()
        frame = self._frame
        if self._pending:  # frames that the driver has not got are not played, however many zeros it has sent
            handed = self._state[frames_viper.FRAME] - BLOCK & COUNT_MASK
            if frame - handed & COUNT_MASK < COUNT_MASK >> 1:
                frame = handed
        frames_viper.advance(self._state, self._ring.words, self._starts, frame)

    def pump(self):
        """Hand the driver as many blocks as it takes. For a timer's callback, every 2 ms. Raises OSError if it takes a part of a block."""
        if not self._running:
            return  # halt() is under way in the main loop
        state = self._state
        late = ticks_diff(ticks_us(), self._looked_us) > _LONGEST_US * self._blocks
        self._look()
        handed = state[frames_viper.FRAME] - (BLOCK if self._pending else 0)
        ahead = handed - self._frame & COUNT_MASK
        if late or not _MARGIN <= ahead <= (self._blocks + 1) * BLOCK:
            self.under_runs += 1
            self._shut()
            self._open()
        if self._enable is not None:
            self._enable.value(0)
        state[frames_viper.HEAD] = self._ring.head if self._playing else state[frames_viper.NEXT]
        while True:
            if not self._pending:
                frames_viper.make(self._frames, 0, 0, BLOCK, state, self._ring.words, self._starts, self._table)
                self._pending = True
            written = self._i2s.write(self._frames)
            if not written:
                return
            if written != 4 * BLOCK:
                raise OSError("the I2S took a part of a block")
            self._pending = False

    def start(self):
        """Play what is published, from the next pump() on. True if frames had run out of words meanwhile."""
        if self._held:
            return False
        head = self._ring.head
        dry = self._playing and head != self._head == self._state[frames_viper.NEXT] and self._state[frames_viper.IDLE] == 1
        self._head = head
        self._playing = True
        return dry

    def hold(self, on):
        self._held = on

    def stop(self):
        self._playing = False
        self._shut()
        self._open()

    def halt(self):
        """No further edge: the clock ends, then zeros come. The other levels come back behind them."""
        self._playing = self._running = False
        self._i2s.deinit()
        if self._enable is not None:
            self._enable.value(1)  # until the next pump(), when the registers hold zeros
        self._shut()
        self._state[frames_viper.LEVELS] &= ~self._layout.tool_mask
        self._open()

    def busy(self):
        """Return True while words are left to play or the last one's ticks still run."""
        if not self._playing:
            return False
        self._look()
        return self._state[frames_viper.PLAYED] != self._ring.head or self._state[frames_viper.RUNS] != 0

    def words_played(self):
        """Return the words whose levels have been latched, modulo 2²⁹."""
        self._look()
        return self._state[frames_viper.PLAYED]

    def rest(self, levels):
        """Show `levels`, 17 ms later (PSRAM: 33). Only while not busy."""
        self._state[frames_viper.LEVELS] = self._state[frames_viper.SHOWN] = levels

    def close(self):
        """Hand over nothing more: within 17 ms (33) the registers show zeros, and stay so."""
        self._playing = self._running = False

    def output(self, number, level):
        """An output of the register that is no motor's: 17 ms later (33)."""
        frame = frame_of(number)
        flip = self._state[frames_viper.FLIP]
        self._state[frames_viper.FLIP] = flip | frame if level else flip & ~frame

"""An ESP32 for the tests: `machine` and `time` in virtual microseconds, pins that a world is wired to, soft callbacks.

    chip = fake_esp32.chip                  # one for all, as there is one `machine`; chip.reset() before each test
    port_module = fake_esp32.port           # passo.ports.esp32.port, imported with the fakes in place
    chip.wire(world, pins, layout)
    chip.stall(20_000)                      # 20 ms in which no callback comes: a garbage collection

Every question for the time takes a microsecond. Callbacks come while the main loop sleeps, in the order of their timers,
each once however often its timer has gone off meanwhile, and never inside each other. Runs under CPython and MicroPython.
"""

import sys

import micropython

_MASK = 0x3FFFFFFF
_BASE = 0x3FF44000
_MACHINE = "Generic ESP32 module with ESP32"
INPUT_ONLY = (34, 39)


class Chip:
    def __init__(self):
        self.reset()

    def reset(self):
        self.now = 0
        self.timers = {}
        self.uarts = {}
        self.level = {}  # of each pin by number
        self.out = set()
        self.irqs = {}
        self.edges = []  # (µs, levels) of the wired pins after each change
        self.watchdog = None
        self.pwm = {}
        self.cause = 1
        self.frames = 0  # latched by shift registers, ever
        self.register = 0  # their outputs, QA of the first chip lowest
        self.i2s = None
        self.input_enabled = set()
        self._world = None
        self._inside = False
        self._inputs = {}

    # --- time

    def ticks_us(self):
        self.now += 1
        return self.now & _MASK

    def ticks_ms(self):
        self.now += 1
        return self.now // 1000 & _MASK

    def sleep_ms(self, ms):
        end = self.now + ms * 1000
        while True:
            timer = self._next()
            if timer is None or timer.due > end:
                break
            self.now = max(self.now, timer.due)
            timer.due += timer.period
            if timer.due <= self.now:  # its call stands in the queue already
                timer.due = self.now + 1
            self._inside = True
            timer.callback(timer)
            self._inside = False
        self.now = max(self.now, end)
        if self.watchdog is not None and self.now > self.watchdog.end:
            raise SystemExit("the watchdog has reset the chip")

    def stall(self, us):
        """Time in which nothing runs."""
        self.now += us

    def _next(self):
        first = None
        for timer in self.timers.values():
            if timer.callback is not None and (first is None or timer.due < first.due):
                first = timer
        return first

    # --- pins

    def wire(self, world, pins, layout):
        """`pins` of the word's bits go to the world's edges(); its inputs answer by name: see name_inputs()."""
        self._world, self._wired = world, pins
        self.edges = [(self.now, self.levels())]
        world.attach(0, layout.pin_names, self.levels())

    def name_inputs(self, board):
        self._inputs = {item["pin"]: item["name"] for item in board["inputs"]}

    def wire_register(self, world, outputs, layout):
        """`outputs` of the shift registers, of the word's bits, go to the world's edges()."""
        self._world, self._wired, self._outputs = world, (), outputs
        self.edges = [(self.now * 25 // 2, 0)]
        world.attach(0, layout.pin_names, 0)

    def latch(self, tick, register):
        """The registers show other levels from `tick` on."""
        self.register = register & 0x7FFF
        if self._world is None:
            return
        levels = 0
        for bit in range(len(self._outputs)):
            levels |= (register >> self._outputs[bit] & 1) << bit
        before = self.edges[-1][1]
        if levels != before:
            self.edges.append((tick, levels))
            self._world.edges(tick, levels, levels ^ before)

    def levels(self):
        levels = 0
        for bit in range(len(self._wired)):
            levels |= self.level.get(self._wired[bit], 0) << bit
        return levels

    def drive(self, changes):
        """{pin: level} at once; pins that are no outputs keep what they have."""
        for pin, level in changes.items():
            if pin in self.out:
                self.level[pin] = level
        if self._world is None or not self._wired:
            return
        levels = self.levels()
        before = self.edges[-1][1]
        if levels != before:
            self.edges.append((self.now, levels))
            self._world.edges(self.now * 25 // 2, levels, levels ^ before)

    def read(self, pin):
        if self.i2s is not None:
            self.i2s.run()
        if pin in self.out:
            return self.level.get(pin, 0)
        if self._world is not None and pin in self._inputs:
            return self._world.input(self.now * 25 // 2, self._inputs[pin])
        return self.level.get(pin, 0)


chip = Chip()


class Pin:
    IN, OUT, PULL_UP, PULL_DOWN, IRQ_RISING, IRQ_FALLING = 1, 3, 2, 1, 1, 2

    def __init__(self, number, mode=None, pull=None, value=None):
        if number in (20, 24, 28, 29, 30, 31) or not 0 <= number <= 39:
            raise ValueError("invalid pin")
        self.number = number
        if mode == Pin.OUT:
            if INPUT_ONLY[0] <= number <= INPUT_ONLY[1]:
                raise ValueError("pin can only be input")
            chip.out.add(number)
        elif mode == Pin.IN:
            chip.out.discard(number)
        if value is not None:
            chip.drive({number: value})

    def value(self, level=None):
        if level is None:
            return chip.read(self.number)
        chip.drive({self.number: 1 if level else 0})

    def irq(self, handler=None, trigger=3):
        chip.irqs[self.number] = handler


class Mem32:
    """GPIO's set and clear registers; and IO_MUX, of which only the input's bit is there."""

    def __getitem__(self, address):
        return 1 << 9 if address in chip.input_enabled else 0

    def __setitem__(self, address, value):
        if 0x3FF49000 <= address < 0x3FF49100:
            chip.input_enabled.add(address) if value >> 9 & 1 else chip.input_enabled.discard(address)
            return
        assert 0 <= value < 1 << 32
        register = address - _BASE
        assert register in (0x08, 0x0C, 0x14, 0x18), hex(address)
        first = 32 if register >= 0x14 else 0
        level = 1 if register in (0x08, 0x14) else 0
        chip.drive({first + bit: level for bit in range(32) if value >> bit & 1})


class I2S:
    """The transmitter as MicroPython 1.26 to 1.28 drive it: blocks of 256 frames in a ring, each sent, zeroed and queued to be
    written again; of a full queue the oldest is forgotten. DMA reads 64 frames ahead of the pins.

    Philips format: bits come a clock behind WS, whose rising edge, between the halves, latches the registers."""

    TX, STEREO = 1, 1
    BLOCK, AHEAD = 256, 64

    def __init__(self, number, sck=None, ws=None, sd=None, mode=None, bits=0, format=None, rate=0, ibuf=0):
        assert number == 0 and mode == I2S.TX and bits == 16 and format == I2S.STEREO and rate == 250_000
        assert chip.i2s is None, "not closed"
        self._blocks = [[0] * I2S.BLOCK for _ in range(max(2, ibuf // (4 * I2S.BLOCK)))]
        self._queue = []
        self._writing = None  # number of the block being written
        self._at = 0
        self._reading = 0  # count of the block that DMA has begun
        self._sending = [self._blocks[0][:], None]  # as it was when DMA began it; the one before
        self._sent = 0  # frames
        self._last = None  # frame; the first is latched in any case: the registers kept what they had
        self._opened = chip.now
        self._asyncio = False
        self.torn = 0  # writes into a block that DMA was reading
        self._mux = {17: 0x3FF49050, 13: 0x3FF49038}.get(ws.number)
        if self._mux in chip.input_enabled:
            chip.input_enabled.discard(self._mux)  # the driver makes an output of the pin, and of nothing else
        chip.i2s = self

    def run(self):
        """All frames whose time has come."""
        end = (chip.now - self._opened) // 4
        while self._sent < end:
            turn = self._reading * I2S.BLOCK
            # Up to where DMA begins another block, or to the end.
            limit = turn + I2S.BLOCK - I2S.AHEAD
            if self._sent >= limit:
                self._next_block()
                continue
            self._show(min(end, limit))

    def _show(self, until):
        sent = self._sent
        last = self._last
        block = self._reading
        while sent < until:
            data = self._sending[0] if sent >= block * I2S.BLOCK else self._sending[1]
            frame = data[sent % I2S.BLOCK]
            sent += 1
            if frame != last:
                chip.latch((self._opened + sent * 4) * 25 // 2, ((last or 0) >> 16 & 0xFFFF) << 15 | (frame & 0xFFFF) >> 1)
                last = frame
                # Outputs from 15 on get this frame's right half with the next latch; none is in use.
        chip.frames += until - self._sent
        self._sent, self._last = until, last

    def _next_block(self):
        number = self._reading % len(self._blocks)
        self._blocks[number] = [0] * I2S.BLOCK
        if len(self._queue) == len(self._blocks) - 1:
            self._queue.pop(0)
        self._queue.append(number)
        self._reading += 1
        self._sending = [self._blocks[self._reading % len(self._blocks)][:], self._sending[0]]

    def write(self, data):
        assert self._asyncio, "it would wait"
        assert chip.i2s is self, "closed"
        self.run()
        written = 0
        while written < len(data):
            if self._writing is None or self._at == I2S.BLOCK:
                if not self._queue:
                    break
                self._writing = self._queue.pop(0)
                self._at = 0
            if self._writing == self._reading % len(self._blocks):
                self.torn += 1
            count = min(I2S.BLOCK - self._at, len(data) - written)
            for i in range(count):
                self._blocks[self._writing][self._at + i] = data[written + i] & 0xFFFFFFFF
            self._at += count
            written += count
        return 4 * written

    def deinit(self):
        if chip.i2s is self:
            self.run()
            assert not self.torn
            chip.i2s = None


class PCNT:
    INCREMENT = 1

    def __init__(self, number, pin=None, rising=0, max=0, value=None):
        assert rising == PCNT.INCREMENT and max == 32_000
        self._from = chip.frames
        self._on = False
        self.wraps = max  # 65536: the limit's event is not enabled

    def start(self):
        self._on = True

    def value(self, value=None):
        if chip.i2s is not None:
            chip.i2s.run()
            assert self._on and chip.i2s._mux in chip.input_enabled, "nothing to count"
        count = (chip.frames - self._from) % self.wraps
        if value is not None:
            self._from = chip.frames
        return count - 65_536 if count >= 32_768 else count


class Poll:
    def register(self, stream, events):
        self._stream = stream

    def poll(self, timeout):
        self._stream._asyncio = True

    def unregister(self, stream):
        self._stream = None


class Timer:
    PERIODIC, ONE_SHOT = 1, 0

    def __init__(self, number):
        assert 0 <= number < 4
        self.callback = None
        self.due = self.period = 0
        chip.timers[number] = self

    def init(self, mode=1, period=0, freq=0, callback=None):
        assert mode == Timer.PERIODIC and (period > 0) != (freq > 0)
        self.period = period * 1000 or 1_000_000 // freq
        self.due = chip.now + self.period
        self.callback = callback

    def deinit(self):
        self.callback = None


class UART:
    def __init__(self, number, baud, tx=None, rx=None, rxbuf=0, txbuf=0, timeout=0, timeout_char=0):
        assert number in (1, 2) and isinstance(tx, Pin) and isinstance(rx, Pin)
        self.incoming = self.outgoing = b""
        chip.uarts[number] = self

    def any(self):
        return len(self.incoming)

    def readinto(self, buffer, count=-1):
        if count < 0:
            count = len(buffer)
        data = self.incoming[:count]
        self.incoming = self.incoming[count:]
        buffer[: len(data)] = data
        return len(data) or None

    def write(self, data):
        self.outgoing += bytes(data)

    def deinit(self):
        pass


class WDT:
    def __init__(self, timeout=5000):
        assert timeout >= 1000, "in whole seconds"
        self.timeout = timeout * 1000
        chip.watchdog = self
        self.feed()

    def feed(self):
        self.end = chip.now + self.timeout


class PWM:
    def __init__(self, pin, freq=0, duty_u16=0):
        chip.pwm[pin.number] = duty_u16
        self._pin = pin.number

    def duty_u16(self, duty):
        chip.pwm[self._pin] = duty


class Module:
    """A module of these names; a class, because MicroPython cannot make modules."""


def _module(**names):
    module = Module()
    for name in names:
        setattr(module, name, names[name])
    return module


def ticks_diff(after, before):
    return ((after - before + 0x20000000) & _MASK) - 0x20000000


def ticks_add(ticks, delta):
    return (ticks + delta) & _MASK


def _import_port():
    """Import the ESP32's room with the fakes in the place of the chip's modules, and put back what was there."""
    machine = _module(
        I2S=I2S, Pin=Pin, PWM=PWM, WDT=WDT, UART=UART, Timer=Timer, mem32=Mem32(), reset_cause=lambda: chip.cause, WDT_RESET=3,
        idle=lambda: chip.sleep_ms(1), disable_irq=lambda: 1, enable_irq=lambda state: None,
    )
    clock = _module(
        ticks_us=lambda: chip.ticks_us(), ticks_ms=lambda: chip.ticks_ms(), sleep_ms=lambda ms: chip.sleep_ms(ms),
        ticks_diff=ticks_diff, ticks_add=ticks_add,
    )  # fmt: skip
    fakes = {
        "machine": machine, "time": clock, "esp32": _module(PCNT=PCNT), "select": _module(poll=Poll, POLLOUT=4),
    }  # fmt: skip
    if not hasattr(micropython, "alloc_emergency_exception_buf"):  # the unix port has none
        fakes["micropython"] = _module(
            const=micropython.const, kbd_intr=micropython.kbd_intr, alloc_emergency_exception_buf=lambda size: None
        )
    before = {name: sys.modules.get(name) for name in fakes}
    sys.modules.update(fakes)
    try:
        from passo.ports.esp32 import chip as registers

        base = registers.gpio_base
        registers.gpio_base = lambda machine=_MACHINE: base(machine)
        from passo.ports import limit_watch  # noqa: F401: the port asks for it later, as for parts of options
        from passo.ports.esp32 import i2s_player, port, start, timer_player

        for option in ("encoders", "interlock"):
            __import__("passo.options.%s.port_pins" % option)
        __import__("passo.options.shift.port_esp32")
    finally:
        for name in before:
            if before[name] is None:
                del sys.modules[name]
            else:
                sys.modules[name] = before[name]
    return port, start, timer_player, i2s_player, fakes


port, start, timer_player, i2s_player, fakes = _import_port()

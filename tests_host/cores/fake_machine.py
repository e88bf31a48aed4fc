"""The modules of an ESP32 that the firmware asks for at its start, as small as may be: nothing of them moves. Runs on qemu."""

import os
import sys


class Quiet:
    IN = OUT = PULL_UP = PULL_DOWN = IRQ_RISING = IRQ_FALLING = PERIODIC = TX = STEREO = INCREMENT = 1

    def __init__(self, *arguments, **options):
        self.taken = 0

    def value(self, level=None):
        return 1

    def write(self, data):
        if self.taken > 4096:
            return 0
        self.taken += len(data)
        return 4 * len(data)

    def nothing(self, *arguments, **options):
        return None

    irq = init = deinit = duty_u16 = freq = feed = start = readinto = register = unregister = nothing

    def any(self):
        return 0

    def poll(self, timeout=0):
        return ()

    ipoll = poll


class Registers:
    def __getitem__(self, address):
        return 0

    def __setitem__(self, address, value):
        pass


class Module:
    pass


def module(name, **names):
    made = Module()
    for key in names:
        setattr(made, key, names[key])
    sys.modules[name] = made


module(
    "machine", I2S=Quiet, Pin=Quiet, PWM=Quiet, WDT=Quiet, UART=Quiet, Timer=Quiet, SPI=Quiet, mem32=Registers(), reset_cause=lambda: 1, WDT_RESET=3,
    idle=lambda: None, disable_irq=lambda: 1, enable_irq=lambda state: None, unique_id=lambda: b"12345678",
)  # fmt: skip
module("esp32", PCNT=Quiet)
module("socket", socket=Quiet, SOCK_STREAM=1, AF_INET=2)
module("select", poll=Quiet, POLLIN=1, POLLOUT=4)
module("os", urandom=bytes, **{name: getattr(os, name) for name in dir(os) if not name.startswith("__")})

"""The pulses of a servo.

    pulse = port.make("servo", (11, 1_500_000))     # pin, and ns
    pulse.duty_ns(1_600_000)
"""

from machine import PWM, Pin


def make(port, config):
    return PWM(Pin(config[0]), freq=50, duty_ns=config[1])

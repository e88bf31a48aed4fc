"""The PWM of a pen's servo: a pulse every 20 ms.

    pulse = port.make("servo", (pin, ns))
    pulse.duty_ns(1_500_000)
"""

from machine import PWM, Pin


def create(port, inputs, config):
    """Return the PWM; `config`: (pin, ns of the first pulse)."""
    return PWM(Pin(config[0]), freq=50, duty_ns=config[1])

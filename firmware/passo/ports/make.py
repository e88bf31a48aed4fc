"""What few boards have, each from a module of this folder.

    port.make("pulses", name)               # counts those of an input
    port.make("servo", (pin, ns))
    port.make("switching", switches)        # outputs that change with a step; False if the player cannot
    port.make("spi_line", spi_drivers)      # `spi_drivers` and `card` of the board file
    port.make("memory_card", card)
"""


def make(port, kind, config):
    if kind == "pulses":
        from passo.ports.pulses import make
    elif kind == "servo":
        from passo.ports.servo import make
    elif kind == "switching":
        from passo.ports.switching import make
    elif kind == "spi_line":
        from passo.ports.spi_line import make
    else:
        from passo.ports.memory_card import make
    return make(port, config)

"""SPI to motor drivers on the virtual port."""


def create(port, config):
    """Return the drivers that the PC has put behind the port."""
    return port.lines["drivers"]  # the PC has put them there

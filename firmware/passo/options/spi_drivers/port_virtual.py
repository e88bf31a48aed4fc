"""SPI to motor drivers on the virtual port."""


def create(port, config):
    return port.lines["drivers"]  # the PC has put them there

"""The memory card of a virtual board: a folder of the PC."""


class VirtualCard:
    path = ""
    inside = True

    def mount(self):
        """Raise OSError if the test has taken the card out."""
        if not self.inside:
            raise OSError("no SD card")


def create(port, config):
    """Return the VirtualCard."""
    return VirtualCard()

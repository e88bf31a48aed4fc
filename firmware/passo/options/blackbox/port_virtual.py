"""Boxes on the virtual port: in memory, where tests find them."""


class Boxes:
    def __init__(self):
        self.written = []  # (why, numbers, text), the newest last

    def __call__(self, why, numbers, text, feed=None):
        self.written.append((why, bytes(numbers), bytes(text)))


def create(port, keep):
    """Return a Boxes in place of write_box()."""
    return Boxes()

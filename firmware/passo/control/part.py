"""What the controller asks of the parts that only some machines have; each overrides what it has something to say to."""


class Part:
    def handlers(self):
        """{kind of command: handler}, as Controller.accept calls them."""
        return {}

    def poll(self):
        """Once a main loop turn."""

    def active(self):
        """True while the axes are this part's alone."""
        return False

    def held(self):
        """True where it stands in the middle of its work, until somebody says what next."""
        return False

    def live(self):
        """True while what is under way may change at any moment."""
        return False

    def ready(self):
        """True when words may be played."""
        return True

    def clear(self):
        """All motion has been dropped."""

    def release(self):
        """The safe state, at once."""

    def report(self, report):
        """Add to a status report."""

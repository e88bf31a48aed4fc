"""The settings of a board on a cable whose language has no lines of its own: asked for one by one, and set.

    class TorchMachine(with_settings(cabled(TorchPage))): …

A page that asks for the settings has them read, while the machine stands and nothing else is said: `$` for their numbers, then each. Its wire
carries SETTING commands: `$`, `$100` or `$100=48.5` (clients/answers.py). From then on positions and jogs count in the board's own steps/mm.
A board that does not know such lines has none.
"""

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.protocols.setting_lines import thousandths

_RESTING = ("Idle", "Sleep")
_MISSES = const(8)  # answers that may get lost
_X_SCALE = const(100)
_X_TRAVEL = const(130)


def _question(number=None):
    return Command(commands.SETTING, number, None)


class Known:
    """What the board has told, as the pages of boards ask for it."""

    def __init__(self, values, scale):
        self._values = values
        self._scale = scale

    def jog_steps(self, axis):
        return max(1, round(float(self._values[150 + axis]) * self._scale[axis]))

    def jog_steps_s(self, axis):
        return max(1, round(float(self._values[170 + axis]) * self._scale[axis] / 60))


def with_settings(kind):
    """The class of pages `kind`, see cabled.py, that shows and sets the board's settings."""

    class WithSettings(kind):
        tells = kind.tells + ("settings",)

        def __init__(self, *arguments):
            kind.__init__(self, *arguments)
            self._wanted = None  # SETTING commands that are to be asked; None: no page has asked for settings yet
            self._asked = None  # the one that has been
            self._misses = 0
            self._found = {}  # {number: value} of those that have been told
            self.kinds[commands.SETTING] = self._hear
            self.kinds[commands.STILL] = self._ask_again

        def told_settings(self):
            if not self._wanted and self._asked is None:
                self._wanted = [_question()]
            return self.settings

        def set(self, number, text):
            value = thousandths(text)
            if value is None:
                return errors.NUMBER
            return self.still() or self.do(Command(commands.SETTING, number, value), self.finished)

        def _ask_again(self, event):
            """Something has been set, which may bound or change others."""
            if self._wanted is not None and not event.error:
                self._wanted = [_question()]

        def poll(self, now_ms):
            kind.poll(self, now_ms)
            rests = self.state["link"] and self.state["state"] in _RESTING and not self.jog.active and not self.said and not self.unanswered
            if self._wanted and self._asked is None and rests and self.wire.takes(self._wanted[0]) and not self.still():
                self._asked = self._wanted.pop(0)
                self.wire.order(self._asked)

        def _hear(self, event):
            """The answer to a question about settings, or to one that was set."""
            if event.command is not self._asked:
                self._ask_again(event)
                return
            self._asked = None
            if event.error:
                self._misses += 1
                if event.command.target is not None and self._misses < _MISSES:
                    self._wanted.insert(0, event.command)
                else:  # it has no such lines
                    self._wanted = []
                return
            for told in event.value or ():
                if told[:3] == "[$:":
                    self._misses = 0
                    self._found = {}
                    self._wanted = [_question(int(number)) for number in told[3:-1].split(",")]
                elif told[:1] == "$" and "=" in told:
                    number, _, value = told[1:].partition("=")
                    self._found[int(number)] = value
            if not self._wanted and self._found:
                self.settings = self._found
                self._follow_told()

        def _follow_told(self):
            """All have been told: steps/mm, travel and jogs are the board's, and so every page sees them."""
            scale = [float(self.settings[_X_SCALE + axis]) for axis in range(len(self.scale)) if _X_SCALE + axis in self.settings]
            if len(scale) == len(self.scale):
                self.scale = scale
            if self.travel:
                far = [float(self.settings.get(_X_TRAVEL + axis, high - low)) for axis, (low, high) in enumerate(self.travel)]
                self.travel = [[-far[axis], 0] if low < 0 else [0, far[axis]] for axis, (low, high) in enumerate(self.travel)]
            if 170 in self.settings:
                self._take_jogs(Known(self.settings, self.scale))
            self._tell({"t": "settings", "axes": self.axes, "settings": self.settings})

        def silent(self):
            kind.silent(self)
            self._asked = None
            if self._wanted is not None:
                self._wanted = [_question()]  # who answers next may be another board

    return WithSettings

"""The settings of a board on a cable whose language has no lines of its own: asked for one by one, and set.

    class TorchMachine(with_settings(on_cable(TorchPage))): …

If a page asks for the settings, they are read while the machine stands and no other command waits: `$` for their numbers, then each. Its wire
carries SETTING commands: `$`, `$100` or `$100=48.5` (clients/answers.py). From then on positions and jogs count in the board's own steps/mm.
A board that does not know such lines has none.
"""

from micropython import const

from passo import commands, errors
from passo.commands import STILL, Command
from passo.config.setting_numbers import JOG, JOG_SPEED, STEPS, TRAVEL
from passo.protocols.setting_lines import parse_thousandths

_RESTING = ("Idle", "Sleep")
_MISSES = const(8)  # answers that may get lost


def _make_question(number=None):
    return Command(commands.SETTING, number, None)


class Known:
    """The settings of a board's jogs in steps, with the methods that the page of a board calls."""

    def __init__(self, values, scale):
        self._values = values
        self._scale = scale

    def jog_steps(self, axis):
        """Steps of one jog of an axis, at least 1."""
        return max(1, round(float(self._values[JOG + axis]) * self._scale[axis]))

    def jog_steps_s(self, axis):
        """Speed of a jog of an axis in steps/s, at least 1."""
        return max(1, round(float(self._values[JOG_SPEED + axis]) * self._scale[axis] / 60))


class Questions:
    """The questions about settings that still wait, and the values received."""

    def __init__(self):
        self._wanted = None  # SETTING commands; None: no page has asked for settings yet
        self._asked = None  # the one that waits for its answer
        self._misses = 0
        self._numbers = ()  # of all there are
        self._found = {}  # {number: value}

    def begin(self):
        """Ask for all of them, if that is not under way."""
        if not self._wanted and self._asked is None:
            self._wanted = [_make_question()]

    def begin_again(self):
        """Ask for all anew: a changed setting may bound or change others, or another board may answer."""
        if self._wanted is not None:
            self._wanted = [_make_question()]

    def forget_question(self):
        self._asked = None
        self.begin_again()

    def next_question(self):
        """The next question; None if there is none, or one waits for its answer."""
        return self._wanted[0] if self._wanted and self._asked is None else None

    def pop_question(self):
        self._asked = self._wanted.pop(0)
        return self._asked

    def take_answer(self, event):
        """Take the answer to a SETTING command. Returns {number: text} of all settings behind the last answer, else None."""
        if event.command is not self._asked:
            if not event.error:
                self.begin_again()
            return None
        self._asked = None
        if event.error:
            self._ask_again(event.command)
            return None
        for told in event.value or ():
            if told[:3] == "[$:":
                self._misses = 0
                self._found = {}
                self._numbers = [int(number) for number in told[3:-1].split(",")]
                self._wanted = [_make_question(number) for number in self._numbers]
            elif told[:1] == "$" and "=" in told:
                number, _, value = told[1:].partition("=")
                self._found[int(number)] = value
        if event.command.target is not None and event.command.target not in self._found:  # the line has changed a byte
            self._ask_again(event.command)
        return self._found if not self._wanted and len(self._found) == len(self._numbers) else None

    def _ask_again(self, command):
        """Ask again, _MISSES times at most. If the board does not answer `$` either, it has no lines about settings."""
        self._misses += 1
        if command.target is not None and self._misses < _MISSES:
            self._wanted.insert(0, command)
        else:
            self._wanted = []


def with_settings(kind):
    """The class of pages `kind`, see cable_page.py, that shows and sets the board's settings."""

    class WithSettings(kind):
        tells = kind.tells + ("settings",)

        def __init__(self, *arguments):
            kind.__init__(self, *arguments)
            self._questions = Questions()
            self.kinds[commands.SETTING] = self._take_setting
            self.kinds[STILL] = self._take_setting

        def settings_texts(self):
            """Ask the board for its settings, and return those known, {number: value as text}; all follow in a message."""
            self._questions.begin()
            return self.settings

        def set_setting(self, number, text):
            """Set setting `number` to a number as text. Returns 0 or an error; the board's answer goes to note_result()."""
            value = parse_thousandths(text)
            if value is None:
                return errors.NUMBER
            return self.busy_error() or self.queue_command(Command(commands.SETTING, number, value), self.note_result)

        def poll(self, now_ms):
            """Do the page's work, and ask the next question about settings while the machine stands and no command is under way."""
            kind.poll(self, now_ms)
            question = self._questions.next_question()
            rests = self.state["link"] and self.state["state"] in _RESTING and not self.jog.active and not self.said and not self.unanswered
            if question and rests and self.wire.can_take(question) and not self.busy_error():
                self.wire.send_command(self._questions.pop_question())

        def _take_setting(self, event):
            """Take a board's answer about a setting; apply the settings once all are there."""
            found = self._questions.take_answer(event)
            if found:
                self.settings = found
                self._apply_settings()

        def _apply_settings(self):
            """Take steps/mm, travel in mm and jogs from the settings received, and send the settings to all pages."""
            axes = range(len(self.scale))
            self.scale = [float(self.settings[STEPS + axis]) for axis in axes]
            if self.travel:
                far = [float(self.settings[TRAVEL + axis]) for axis in axes]
                self.travel = [[-far[axis], 0] if self.travel[axis][0] < 0 else [0, far[axis]] for axis in axes]
            if JOG_SPEED in self.settings:
                self._take_jogs(Known(self.settings, self.scale))
            self._tell({"t": "settings", "axes": self.axes, "settings": self.settings})

        def note_silence(self):
            kind.note_silence(self)
            self._questions.forget_question()

    return WithSettings

"""Lines of text in languages that are not of lines: the words that options add to them.

    words = Words.words_of(protocol)    # made when it is asked for first
    words.learn_lines("$F", JOB, line_commands, answer_text)      # as Grbl.learn_lines()
    words.line_command("$F=PART")       # a Command; BAD if no line begins so
    words.event_bytes(event)            # the bytes that answer it; None: the event is of no such line
"""

from passo import errors
from passo.commands import ACCEPTED, BAD, FINISHED, Command

LINE = "$"  # the `value` of BAD


class Words:
    def __init__(self):
        self._lines = []  # (how a line begins, understand)
        self._told = {}  # by kind of command
        self.notices = {}  # by number of a notice: a function that returns its text for a value

    @classmethod
    def words_of(cls, protocol):
        """Return the protocol's words; make them at the first call."""
        if protocol.words is None:
            protocol.words = cls()
        return protocol.words

    def learn_lines(self, start, kind, understand, told, asked=False):
        """Take lines that begin with `start`: understand(None, the rest) returns [a command of this kind] or the number of an error;
        told(event.value) is the answer before `ok`."""
        self._lines.append((start, understand))
        self._told[kind] = told

    def line_command(self, line):
        """Return the Command of a line; BAD if no line begins like it."""
        found = errors.STATEMENT
        for start, understand in self._lines:
            if line.startswith(start):
                found = understand(None, line[len(start) :])
        if isinstance(found, int):
            return Command(BAD, value=LINE, error=found)
        return found[0]

    def event_bytes(self, event):
        """Return the bytes that answer `event`; None if it is of no such line."""
        command = event.command
        told = self._told.get(command.kind)
        if not told and (command.kind != BAD or command.value != LINE):
            return None
        if event.kind != ACCEPTED and event.kind != FINISHED:
            return b"error:%d\n" % event.error
        said = told(event.value).replace("\r", "") if told and event.value else ""
        return (said + "ok\n").encode()

    def notice_bytes(self, event):
        """Return the line of a notice, in bytes; empty if no option has taught its number."""
        say = self.notices.get(event.error)
        return ("[MSG:%s]\n" % say(event.value)).encode() if say else b""

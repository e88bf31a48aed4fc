"""Lines of text in languages that are not of lines: what options add to them.

    words = Words.of(protocol)      # made when it is asked for first
    words.learn(language)           # a module: START and KIND, understand(machine, text), told(value)
    words.command("$F=PART")        # a Command; BAD if no line begins so
    words.told(event)               # the bytes that answer it; None: the event is of no such line
"""

from passo import errors
from passo.commands import ACCEPTED, BAD, FINISHED, Command

_LINE = "$"  # the `value` of BAD


class Words:
    def __init__(self):
        self._languages = {}  # by kind of command

    @classmethod
    def of(cls, protocol):
        if protocol.words is None:
            protocol.words = cls()
        return protocol.words

    def learn(self, language):
        self._languages[language.KIND] = language

    def command(self, line):
        found = errors.STATEMENT
        for language in self._languages.values():
            if line.startswith(language.START):
                found = language.understand(None, line[len(language.START) :])
        if isinstance(found, int):
            return Command(BAD, value=_LINE, error=found)
        return found[0]

    def told(self, event):
        command = event.command
        language = self._languages.get(command.kind)
        if not language and (command.kind != BAD or command.value != _LINE):
            return None
        if event.kind != ACCEPTED and event.kind != FINISHED:
            return b"error:%d\n" % event.error
        said = language.told(event.value).replace("\r", "") if language and event.value else ""
        return (said + "ok\n").encode()

    def said(self, event):
        """What a notice says, if it is one of an option: bytes."""
        for language in self._languages.values():
            if getattr(language, "NOTICE", 0) == event.error:
                return ("[MSG:%s]\n" % language.ended(event.value)).encode()
        return b""

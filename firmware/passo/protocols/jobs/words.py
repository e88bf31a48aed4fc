"""The `$F` and `$JR` lines in languages that are not of lines: files.py and journal.py say what they are.

    words = Words(board)            # only of a board with jobs or a journal
    words.command("$F=PART")        # a Command; BAD if there is no such line
    words.told(event)               # the bytes that answer it; None: the event is of no such line
"""

from passo import errors
from passo.commands import ACCEPTED, BAD, FINISHED, JOB, JOURNAL, Command


class Words:
    def __init__(self, board):
        self._files = self._journal = None
        if board["jobs"]:
            from passo.protocols.jobs import files

            self._files = files
        if board["journal"]:
            from passo.protocols.jobs import journal

            self._journal = journal

    def command(self, line):
        found = errors.STATEMENT
        if line[:2] == "$F" and self._files:
            found = self._files.understand(line)
        elif line[:3] == "$JR" and self._journal:
            found = self._journal.understand(line)
        if isinstance(found, int):
            return Command(BAD, value=JOB, error=found)
        return found[0]

    def told(self, event):
        command = event.command
        if command.kind == BAD and command.value != JOB or command.kind not in (BAD, JOB, JOURNAL):
            return None
        if event.kind != ACCEPTED and event.kind != FINISHED:
            return b"error:%d\n" % event.error
        said = ""
        if event.value:
            said = (self._files if command.kind == JOB else self._journal).told(event.value).replace("\r", "")
        return (said + "ok\n").encode()

    def ended(self, value):
        """How a stored job has ended, unasked."""
        return ("[MSG:%s]\n" % self._files.ended(value)).encode()

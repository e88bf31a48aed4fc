"""The `$JR` lines: the job's journal.

    $JR             [JOURNAL:job|line|flags|x,y,z]: job in hexadecimal, positions in steps; flags: 1 the line is done, 2 the position
                    is known; of commands and points also 4 backward, 256 × the times it is to be played
    $JR=89ABCDEF    a job of that number begins
    $JR=89ABCDEF,LINE,FLAGS,LEAD,X,Y,Z      the same, of commands or points, as it is gone on with: LEAD of those to come are none of it
"""

from passo import commands, errors
from passo.commands import Command
from passo.records import COUNT_MASK


def extend(protocol, board):
    """Add the `$JR` lines to a link's protocol."""
    teach_lines(protocol)


def teach_lines(words):
    """Add the `$JR` lines to `words`, a Words or a Grbl."""
    words.learn_lines("$JR", commands.JOURNAL, line_commands, answer_text, True)


def line_commands(machine, text):
    """The commands of a line in which `text` follows `$JR`, or the number of an error."""
    if not text:
        return [Command(commands.JOURNAL, value=None)]
    number, comma, rest = text[1:].partition(",")
    try:
        job = int(number, 16)
        fields = [int(field) for field in rest.split(",")] if comma else ()
    except ValueError:
        job = 0
    if text[:1] != "=" or not 0 < job <= 0xFFFFFFFF:
        return errors.STATEMENT
    if not fields:
        return [Command(commands.JOURNAL, job)]
    if not 2 < len(fields) < 8 or min(fields[:3]) < 0 or fields[1] > 0xFFFF or max([abs(field) for field in fields]) > COUNT_MASK:
        return errors.STATEMENT
    return [Command(commands.JOURNAL, (job, fields[0], fields[1], fields[2], fields[3:]))]


def answer_text(value):
    """Return the line that answers `$JR`."""
    job, line, flags, position = value
    return "[JOURNAL:%08x|%d|%d|%s]\r\n" % (job, line, flags, ",".join([str(steps) for steps in position]))

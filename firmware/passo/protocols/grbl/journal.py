"""The `$JR` lines: the job's journal.

    $JR             [JOURNAL:job|line|flags|x,y,z]: job in hexadecimal, positions in steps; flags: 1 the line is done, 2 homed
    $JR=89ABCDEF    a job of that number begins
"""

from passo import commands, errors
from passo.commands import Command


def understand(line):
    """The commands of a line that begins with `$JR`, or the number of an error."""
    if line == "$JR":
        return [Command(commands.JOURNAL)]
    try:
        job = int(line[4:], 16)
    except ValueError:
        job = 0
    if line[3:4] != "=" or not 0 < job <= 0xFFFFFFFF:
        return errors.STATEMENT
    return [Command(commands.JOURNAL, job)]


def told(value):
    job, line, flags, position = value
    return "[JOURNAL:%08x|%d|%d|%s]\r\n" % (job, line, flags, ",".join([str(place) for place in position]))

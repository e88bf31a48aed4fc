"""The `$F` lines: stored jobs, as far as grblHAL has them by the same words.

    $F                                      [FILE:NAME|SIZE:bytes|STORED:bytes|CRC:hexadecimal|LANGUAGE:grbl] each, [FREE:bytes];
                                            before it [MORE:count] of jobs that the list leaves out
    $F?                                     [JOB:NAME|per cent] of the one that runs, else [ENDED:NAME|error|line], error 0: it is done
    $F=NAME                                 run
    $FD=NAME                                delete
    $FS=NAME,LANGUAGE,BYTES,CRC,STORED      an upload of STORED bytes begins; they are a job of BYTES with that CRC-32
    $F:BASE64                               some of its bytes
    $FE                                     it is complete: `ok` once it has been read back and is right
"""

from binascii import a2b_base64

from passo import commands, errors
from passo.commands import Command


def _command(what, target=None):
    return [Command(commands.JOB, target, what)]


def understand(line):
    """The commands of a line that begins with `$F`, or the number of an error."""
    if line == "$F":
        return _command(commands.JOB_LIST)
    if line == "$F?":
        return _command(commands.JOB_STATE)
    if line == "$FE":
        return _command(commands.JOB_CLOSE)
    if line[:3] == "$F=" and line[3:]:
        return _command(commands.JOB_RUN, line[3:])
    if line[:4] == "$FD=":
        return _command(commands.JOB_DELETE, line[4:])
    try:
        if line[:3] == "$F:":
            return _command(commands.JOB_DATA, a2b_base64(line[3:]))
        if line[:4] == "$FS=":
            name, language, size, crc, stored = line[4:].split(",")
            return _command(commands.JOB_OPEN, (name, language.lower(), int(size), int(crc, 16), int(stored)))
    except ValueError:
        pass
    return errors.STATEMENT


def told(value):
    """The lines that answer `$F` and `$F?`."""
    if len(value) == 3:
        return "[ENDED:%s|%d|%d]\r\n" % value
    if isinstance(value[0], str):
        return "[JOB:%s|%d]\r\n" % value
    entries, (free, more) = value
    lines = ["[FILE:%s|SIZE:%d|STORED:%d|CRC:%08x|LANGUAGE:%s]\r\n" % (name, size, stored, crc, language or "damaged")
             for name, language, size, stored, crc in entries]
    if more:
        lines.append("[MORE:%d]\r\n" % more)
    lines.append("[FREE:%d]\r\n" % free)
    return "".join(lines)


def ended(value):
    """How a job has ended, for its notice."""
    name, error, line = value
    if error == 0:
        return "Job %s done" % name
    return "Job %s: error %d in line %d" % (name, error, line) if line else "Job %s: error %d" % (name, error)

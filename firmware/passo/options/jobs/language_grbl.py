"""Stored jobs in grbl's language: the `$F` lines, as far as grblHAL has them by the same words; each line is answered by `ok` or `error`.

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

from passo import errors
from passo.commands import Command
from passo.options.jobs.commands import JOB, JOB_CLOSE, JOB_DATA, JOB_DELETE, JOB_LIST, JOB_OPEN, JOB_RUN, JOB_STATE
from passo.options.jobs.errors import NOTICE_JOB_ENDED

_LIMITS = (8, 126)  # lines not yet answered, from which on no more are given; bytes given at once
_FRAME = (b"", b"")  # the bytes before a job, and after it


def extend(protocol, board):
    """Add the `$F` lines, the notice, and the counting of answers to a link's protocol."""
    protocol.stored = _LIMITS, _FRAME, _count_lines, _count_answers
    protocol.raw = b"$F:"
    notices = dict(protocol.notices)  # those of this link: the class has none
    notices[NOTICE_JOB_ENDED] = end_text
    protocol.notices = notices
    teach_lines(protocol)


def teach_lines(words):
    """Add the `$F` lines to `words`, a Words or a Grbl."""
    words.learn_lines("$F", JOB, line_commands, answer_text)


def _count_lines(data):
    """Return the number of lines that end in `data`."""
    return bytes(data).count(b"\n")


def _count_answers(said, before, given):
    """Return `before`, the lines answered so far, plus the answers in the bytes `said`; `given`: lines given."""
    return before + said.count(b"ok\r\n") + said.count(b"error:")


def _job_command(what, target=None):
    """Return [the command JOB with this order]."""
    return [Command(JOB, target, what)]


def line_commands(machine, text):
    """The commands of a line in which `text` follows `$F`, or the number of an error."""
    if not text:
        return _job_command(JOB_LIST)
    if text == "?":
        return _job_command(JOB_STATE)
    if text == "E":
        return _job_command(JOB_CLOSE)
    if text[:1] == "=" and text[1:]:
        return _job_command(JOB_RUN, text[1:])
    if text[:2] == "D=":
        return _job_command(JOB_DELETE, text[2:])
    try:
        if text[:1] == ":":
            return _job_command(JOB_DATA, a2b_base64(text[1:]))
        if text[:2] == "S=":
            name, language, size, crc, stored = text[2:].split(",")
            return _job_command(JOB_OPEN, (name, language.lower(), int(size), int(crc, 16), int(stored)))
    except ValueError:
        pass
    return errors.STATEMENT


def answer_text(value):
    """Return the lines that answer `$F` and `$F?`."""
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


def end_text(value):
    """Return the text of the notice that a job has ended; `value`: (name, error, line)."""
    name, error, line = value
    if error == 0:
        return "Job %s done" % name
    return "Job %s: error %d in line %d" % (name, error, line) if line else "Job %s: error %d" % (name, error)

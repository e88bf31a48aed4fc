"""Answers of lines, for clients and for the pages' wires, which run under MicroPython, too."""

from passo.protocols.setting_lines import decimal_text


def is_complete(text):
    """True if the text that answers a line ends in its `ok` or `error:N`."""
    if text[-1:] != "\n":
        return False
    last = text[:-1].split("\n")[-1]
    word, colon, number = last.partition(":")
    return last == "ok" or bool(word == "error" and colon and number.isdigit())


def answer_of(text):
    """(number of the error, 0: ok; the lines before it) of a complete answer."""
    lines = text[:-1].split("\n")
    last = lines.pop()
    return 0 if last == "ok" else int(last[6:]), lines


def setting_line(command):
    """The line of a SETTING command: `$` for the numbers that there are, `$100` for a value, `$100=48.500` to set it."""
    if command.target is None:
        return "$"
    return "$%d" % command.target if command.value is None else "$%d=%s" % (command.target, decimal_text(command.value, 3))

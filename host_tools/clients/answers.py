"""Answers of lines, for clients and for the pages' wires, which run under MicroPython, too."""


def complete(text):
    """True if the text that answers a line ends in its `ok` or `error:N`."""
    if text[-1:] != "\n":
        return False
    last = text[:-1].split("\n")[-1]
    word, colon, number = last.partition(":")
    return last == "ok" or bool(word == "error" and colon and number.isdigit())

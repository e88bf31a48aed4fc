"""The languages, a folder each."""

# The frame by which a PC asks whether a link speaks frames. Its bytes mean nothing in any of the languages.
HELLO_WIRE = b"\0\x0e\x10\x01\x01\x01\x04\x04\x12\x1d\x19\x05\x0c\x0f\x15\0"


def extend_language(protocol, board, language):
    """Return `protocol` with the additions of options to its `language`."""
    if "additions" in board:
        for module in board["additions"].extensions.get(language, ()):
            module.extend(protocol, board)
    return protocol

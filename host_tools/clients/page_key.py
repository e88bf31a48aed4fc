"""The key of a board's page, as people read it: passo/web/session.py proves orders by it.

    key = make_key(os.urandom)
    read_key("abcd-efgh …"), in_groups(key)
"""

KEY_LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"  # none looks like another
_KEY_LENGTH = 16  # of 32 letters: 80 bits


def make_key(random):
    """A new key of 80 bits. `random(count)`: `count` random bytes, from the system."""
    return "".join([KEY_LETTERS[byte & 31] for byte in random(_KEY_LENGTH)])


def in_groups(key):
    """The key in groups of four letters, "ABCD-EFGH-…", as people read it."""
    return "-".join([key[at : at + 4] for at in range(0, len(key), 4)])


def read_key(text):
    """The key in what a person has typed: dashes, blanks and small letters do not matter. Raises ValueError if it has less than 16 of its letters."""
    key = "".join([letter for letter in text.upper() if letter in KEY_LETTERS])
    if len(key) < _KEY_LENGTH:
        raise ValueError("a key has 16 letters and digits or more, and not %d" % len(key))
    return key

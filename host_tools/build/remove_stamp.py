"""Runs on the board, before its new firmware is copied: from here on it is not whole, until the new stamp is there, as the last."""

import os

try:
    os.remove("stamp.txt")
except OSError:  # an older version, or none
    pass

"""Runs on the board, before its new firmware is copied: from here on it is not whole, until the new stamp is there, as the last. A stamp that
is none, and not merely no stamp: sources that were copied by hand have none, and are run."""

with open("stamp.txt", "w") as file:
    file.write("being copied\n")

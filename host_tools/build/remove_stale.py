"""Runs on the board, after its new firmware is copied: removes the modules of an older one from /passo.

A module stays if passo/files.txt names it. Only .py and .mpy files go: settings and a user's other files stay.
"""

import os

MODULE_ENDINGS = (".py", ".mpy")
FOLDER = 0x4000


def remove_stale(folder, keep):
    """Remove modules that `keep` does not name from a folder and those below it, and folders that become empty."""
    for entry in list(os.ilistdir(folder)):
        path = folder + "/" + entry[0]
        if entry[1] == FOLDER:
            remove_stale(path, keep)
        elif path.endswith(MODULE_ENDINGS) and path not in keep:
            print("removed", path)
            os.remove(path)
    if not os.listdir(folder):
        os.rmdir(folder)


with open("passo/files.txt") as listed:
    remove_stale("passo", set(listed.read().split()))

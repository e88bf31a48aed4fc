"""Runs on a board with Passo's UF2: removes the package that an older `passo flash` laid on the file system, which is not run."""

import os

FOLDER = 0x4000


def remove_folder(folder):
    """Remove a folder and all in it."""
    for entry in list(os.ilistdir(folder)):
        path = folder + "/" + entry[0]
        if entry[1] == FOLDER:
            remove_folder(path)
        else:
            os.remove(path)
    os.rmdir(folder)


names = os.listdir()
for name in ("stamp.txt", "source.txt", "main.py"):
    if name in names:
        os.remove(name)
if "passo" in names:
    remove_folder("passo")

"""Host tools under MicroPython: the package's own start is for a PC, here it is only a folder. Import this first."""

import sys

if sys.implementation.name == "micropython":

    class _Folder:
        __path__ = __file__.rsplit("/", 3)[0] + "/host_tools"

    sys.modules["host_tools"] = _Folder
    sys.path.insert(0, _Folder.__path__ + "/site")  # its `random` has the functions that the plant uses

"""The `passo` command and the tools behind it. Runs on CPython only.

Importing this package puts the stand-ins of `host_tools/shims` on the module path, so that the firmware's modules,
which import `micropython`, load on a PC as they are.
"""

import sys
from pathlib import Path

_SHIMS = str(Path(__file__).resolve().parent / "shims")
if _SHIMS not in sys.path:
    sys.path.append(_SHIMS)

"""The `passo` command and the tools behind it. Runs on CPython only.

Importing this package puts the stand-ins of `host_tools/shims` on the module path, so that the firmware's modules,
which import `micropython`, load on a PC as they are.
"""

import os
import sys

_SHIMS = os.path.join(os.path.dirname(os.path.realpath(__file__)), "shims")
if _SHIMS not in sys.path:
    sys.path.append(_SHIMS)

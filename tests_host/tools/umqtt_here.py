"""micropython-lib's umqtt.simple, as mip puts it on a board: of MicroPython's sources, which MICROPYTHON names, or fetched once.

    UMQTT       # the folder that has `umqtt`, or None
"""

import os
from pathlib import Path

import pytest
import requests

_URL = "https://raw.githubusercontent.com/micropython/micropython-lib/v1.27.0/micropython/umqtt.simple/umqtt/simple.py"
_CACHE = Path.home() / ".cache" / "passo" / "umqtt.simple"


def _found():
    sources = os.environ.get("MICROPYTHON")
    if sources:
        folder = Path(sources).expanduser() / "lib" / "micropython-lib" / "micropython" / "umqtt.simple"
        if (folder / "umqtt" / "simple.py").exists():
            return folder
    kept = _CACHE / "umqtt" / "simple.py"
    if not kept.exists():
        try:
            answer = requests.get(_URL, timeout=10)
            answer.raise_for_status()
        except requests.RequestException:
            return None
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(answer.text)
    return _CACHE


UMQTT = _found()
needs_umqtt = pytest.mark.skipif(UMQTT is None, reason="there is no umqtt: MICROPYTHON names MicroPython's sources, or the internet is wanted")

"""A tool table: lengths and diameters in mm, in LinuxCNC's format: `T1 P1 D6.0 Z42.5 ;end mill`, a tool a line. A line `;inch` says that
those behind it are inches.

    tools = read("tools.tbl")
    tools[1].radius, tools[1].length
"""

import re
from dataclasses import dataclass
from pathlib import Path

from host_tools.failure import Failure, reason

_INCH_MM = 25.4
_WORD = re.compile(r"([A-Z])\s*([-+]?\d*\.?\d+)", re.IGNORECASE)


@dataclass
class Tool:
    diameter: float = 0.0
    length: float = 0.0

    @property
    def radius(self):
        return self.diameter / 2


def read(path):
    """Read a tool table; return {number: Tool}. Raises Failure with the line that is wrong."""
    tools = {}
    scale = 1.0
    try:
        lines = Path(path).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error
    for number, line in enumerate(lines, 1):
        told = line.partition(";")[0].strip()
        if line.strip().lower() in (";inch", "; inch"):
            scale = _INCH_MM
        if not told:
            continue
        words = {letter.upper(): float(value) for letter, value in _WORD.findall(told)}
        if _WORD.sub("", told).strip() or not words.get("T", 0) > 0 or words["T"] % 1:
            raise Failure("{}:{}: a tool is written like this: T1 P1 D6.0 Z42.5 ;end mill", path, number)
        if words.get("D", 0.0) < 0:
            raise Failure("{}:{}: the diameter is negative", path, number)
        if int(words["T"]) in tools:
            raise Failure("{}:{}: tool {} stands twice", path, number, int(words["T"]))
        tools[int(words["T"])] = Tool(words.get("D", 0.0) * scale, words.get("Z", 0.0) * scale)
    return tools

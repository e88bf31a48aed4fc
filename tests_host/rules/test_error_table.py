"""docs/reference/errors.md lists exactly the numbers and texts of the firmware's table, and of the compiler's behind it."""

import re
from pathlib import Path

import pytest

from host_tools import options
from host_tools.programs import program_errors

pytestmark = pytest.mark.quick

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "reference" / "errors.md"


def test_the_document_is_the_table():
    rows = re.findall(r"^\| (\d+) \| (.*) \|$", DOCUMENT.read_text(), re.MULTILINE)
    wanted = [(str(number), text) for number, text in sorted(options.error_texts().items())]
    wanted += [(str(number), text) for number, text in sorted(program_errors.TEXTS.items())]
    assert rows == wanted, "docs/reference/errors.md should hold:\n" + "\n".join(f"| {n} | {text} |" for n, text in wanted)

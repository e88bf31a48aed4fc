"""docs/reference/errors.md lists exactly the numbers and texts of the firmware's table, and of the compiler's behind it."""

import re
from pathlib import Path

import pytest

from host_tools.programs import program_errors
from passo import error_texts

pytestmark = pytest.mark.quick

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "reference" / "errors.md"


def test_the_document_is_the_table():
    rows = re.findall(r"^\| (\d+) \| (.*) \|$", DOCUMENT.read_text(), re.MULTILINE)
    wanted = [(str(number), error_texts.text(number)) for number in sorted(error_texts.TEXTS)]
    wanted += [(str(number), text) for number, text in sorted(program_errors.TEXTS.items())]
    assert rows == wanted, "docs/reference/errors.md should hold:\n" + "\n".join(f"| {n} | {text} |" for n, text in wanted)

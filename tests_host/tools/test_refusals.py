"""The error text of a refused line: the same from the sender and from the check."""

import pytest

from host_tools.cli.check import _check_file
from host_tools.clients.refusal import explain
from host_tools.failure import Failure
from passo import error_texts, errors


@pytest.mark.parametrize("line, wanted", [
    ("N3 G1 X5*18", "error 1, checksums such as *18 are for 3D printers"), ("*5", "error 1, "),
    ("G1 X9999 F600", "error 15, the target is outside the machine's travel"), ("G81 X5 F600", "error 28, a word is missing: P or L; R, Z or Q"),
])  # fmt: skip
def test_check_says_what_helps(line, wanted, tmp_path, capsys):
    file = tmp_path / "a.nc"
    file.write_text(f"G21 G90\n{line}\nG0 X1\n")
    with pytest.raises(Failure, match="the first is line 2"):
        _check_file(file, "router_3axis", ((), None, None), None, None, None)
    assert wanted in capsys.readouterr().err


def test_a_sender_says_the_same():
    assert explain("error:1", b"G1X1*7").startswith("error 1, checksums such as *7")
    assert explain("error:1", b"G1X1*7Y") == explain("error:1") == f"error 1, {error_texts.TEXTS[errors.LETTER]}"

"""The board file of each board as the build writes it: golden/boards.txt has a digest of its values, and the board it is "like".

    python tests_host/rules/test_board_bytes.py > tests_host/golden/boards.txt      # after a change; its diff lists the boards that change
"""

import hashlib
from pathlib import Path

import pytest

GOLDEN = Path(__file__).resolve().parents[1] / "golden" / "boards.txt"


def rows():
    """{board: its line}."""
    from host_tools import boards

    bases = {name: base for base in boards.names() for name in boards.names_like(base)}
    found = {}
    for name in boards.names():
        digest = hashlib.sha256(boards.text_of(boards.load(name)).encode()).hexdigest()[:12]
        found[name] = f"{name} {digest}" + (f" like {bases[name]}" if name in bases else "")
    return found


def changes(before, now):
    """Names of the boards whose lines differ."""
    return sorted(name for name in {*before, *now} if before.get(name) != now.get(name))


@pytest.mark.quick
def test_a_change_of_a_board_file_lists_the_boards_that_it_changes():
    golden = {line.split()[0]: line for line in GOLDEN.read_text(encoding="utf-8").splitlines()}
    changed = changes(golden, rows())
    assert not changed, f"board files that differ from golden/boards.txt: {', '.join(changed)}; wanted? python {Path(__file__).name} > golden/boards.txt"


@pytest.mark.quick
def test_a_base_changes_those_that_are_like_it(tmp_path, monkeypatch):
    import shutil

    from host_tools import boards

    before = rows()
    for path in boards.BOARDS.glob("*.py"):
        shutil.copy(path, tmp_path)
    monkeypatch.setattr(boards, "BOARDS", tmp_path)
    router = tmp_path / "router_3axis.py"
    router.write_text(router.read_text(encoding="utf-8").replace('"pull_off_steps": 640', '"pull_off_steps": 650'), encoding="utf-8")
    assert changes(before, rows()) == ["router_3axis", *boards.names_like("router_3axis")]
    assert boards.names_like("router_3axis")  # one at least, even where some have gone with an option


if __name__ == "__main__":
    print("\n".join(rows().values()))

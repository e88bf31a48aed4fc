"""The virtual board's flash in a file."""

from pathlib import Path

import pytest

from host_tools.sim.pages import BLOCK, Pages


def test_a_program_that_is_killed_as_it_writes_loses_nothing(tmp_path, monkeypatch):
    path = tmp_path / "pages"
    pages = Pages(path)
    pages.write(0, 0, b"first")
    before = path.read_bytes()

    def killed(self, data):
        with open(self, "wb") as file:
            file.write(data[: len(data) // 2])
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_bytes", killed)
    with pytest.raises(KeyboardInterrupt):
        pages.write(0, 1, b"second")
    with pytest.raises(KeyboardInterrupt):
        pages.erase_block(0)
    monkeypatch.undo()
    assert path.read_bytes() == before and len(before) == BLOCK * Pages.BLOCKS
    assert Pages(path).read(0, 0)[:5] == b"first"

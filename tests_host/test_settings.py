"""check_settings under CPython, by hypothesis; and the two files in which a board keeps them."""

import check_settings
from passo.control.journal import FileSlots
from properties import make_tests

globals().update(make_tests(check_settings))


def test_settings_are_kept_in_two_files(tmp_path):
    """They are written in turn; where the newer one is cut short, the values before are there."""
    path = str(tmp_path / "settings")
    settings = check_settings.make(FileSlots(path))
    for speed in (4_000_000, 3_000_000):
        settings.change(110, speed)
        assert settings.save() == 0
    assert sorted(file.name for file in tmp_path.iterdir()) == ["settings.0", "settings.1"]
    assert check_settings.make(FileSlots(path)).value(110) == 3_000_000
    newest = max(tmp_path.iterdir(), key=lambda file: int(file.read_bytes().split()[1]))
    newest.write_bytes(newest.read_bytes()[:-1])
    assert check_settings.make(FileSlots(path)).value(110) == 4_000_000

"""The two files in which a board keeps its settings."""

import builtins

import check_settings
import pytest
from boards.router_3axis import BOARD
from passo.app import App
from passo.config.boardfile import check
from passo.config.journal import FileSlots
from passo.ports.virtual import VirtualPort
from router import World


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


class PowerCut(BaseException):
    """Nothing catches it: from here on the board is dark."""


@pytest.fixture
def cut():
    """cut(at): the power goes after `at` bytes have been written to files, until `undo()` of its value."""
    kept = builtins.open

    def arm(at):
        left = [at]

        class Cut:
            def __init__(self, file):
                self._file = file

            def __enter__(self):
                return self

            def __exit__(self, *_):
                self._file.close()

            def write(self, data):
                self._file.write(data[: left[0]])
                left[0] -= len(data)
                if left[0] < 0:
                    self._file.close()
                    raise PowerCut

        def opened(path, mode="r", *arguments, **options):
            file = kept(path, mode, *arguments, **options)
            return Cut(file) if "w" in mode else file

        patch = pytest.MonkeyPatch()
        patch.setattr(builtins, "open", opened)
        return patch

    return arm


def test_power_cut_at_every_byte_of_the_files(tmp_path, cut, monkeypatch):
    """Two writes, one after the other: with the power gone at any byte of them, all of the old or all of the new."""
    monkeypatch.setattr("os.sync", lambda: None)
    path = str(tmp_path / "settings")
    states = [(110, 1_000_000, "1,2,3"), (110, 2_000_000, "1,2,3"), (110, 2_000_000, "4,5,6")]

    def change(settings, number, value, offset):
        settings.change(number, value)
        settings.put("G54", offset)
        assert settings.save() == 0

    change(check_settings.make(FileSlots(path)), *states[0])
    files = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    seen = set()
    for at in range(160):
        for name in ("settings.0", "settings.1"):
            (tmp_path / name).unlink(missing_ok=True)
        for name, data in files.items():
            (tmp_path / name).write_bytes(data)
        armed = cut(at)
        try:
            writer = check_settings.make(FileSlots(path))
            change(writer, *states[1])
            change(writer, *states[2])
            whole = True
        except PowerCut:
            whole = False
        armed.undo()
        booted = check_settings.make(FileSlots(path))
        after = (110, booted.value(110), booted.get("G54"))
        assert not booted.damaged and after in states and (not whole or after == states[2]), (at, after)
        seen.add(after)
    assert len(seen) == 3 and whole


def test_a_board_boots_with_what_a_power_cut_left(tmp_path, cut):
    path = str(tmp_path / "settings")
    settings = check_settings.make(FileSlots(path))
    settings.change(110, 1_000_000)
    settings.save()
    settings.change(110, 2_000_000)
    armed = cut(20)
    with pytest.raises(PowerCut):
        settings.save()
    armed.undo()
    app = App(check(BOARD), VirtualPort(check(BOARD), World()), None, FileSlots(path))
    app.cycle()
    assert app.controller.machine.settings.value(110) == 1_000_000 and b"Grbl" in app.port.lines["pc"].outgoing

"""The programs that this PC has begun, by their numbers."""

from host_tools.programs import begun


def test_what_was_begun_is_known(tmp_path, monkeypatch):
    monkeypatch.setattr(begun, "KEPT", tmp_path / "share" / "begun.json")
    assert begun.find(7) == ("", 0)
    begun.remember(7, "rings.gcode", 251)
    assert begun.find(7) == ("rings.gcode", 251) and begun.find(8) == ("", 0)
    for number in range(100, 250):
        begun.remember(number, f"{number}.nc", number)
    assert begun.find(7) == ("", 0) and begun.find(249) == ("249.nc", 249), "the oldest are forgotten"


def test_a_file_of_something_else_is_no_reason_to_stop(tmp_path, monkeypatch):
    for text in ("", "[1]", '{"00000007": "x"}', '{"00000007": [1, 2]}'):
        kept = tmp_path / "begun.json"
        kept.write_text(text)
        monkeypatch.setattr(begun, "KEPT", kept)
        assert begun.find(7) == ("", 0)
        begun.remember(7, "a", 1)
        assert begun.find(7) == ("a", 1)
    monkeypatch.setattr(begun, "KEPT", tmp_path / "begun.json" / "no folder")
    begun.remember(7, "a", 1)
    assert begun.find(7) == ("", 0)

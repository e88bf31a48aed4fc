"""The programs that this PC has begun, by their numbers."""

from host_tools.programs import program_names


def test_what_was_begun_is_known(tmp_path, monkeypatch):
    monkeypatch.setattr(program_names, "KEPT", tmp_path / "share" / "begun.json")
    assert program_names.name_of_number(7) == ("", 0)
    program_names.remember_name(7, "rings.gcode", 251)
    assert program_names.name_of_number(7) == ("rings.gcode", 251) and program_names.name_of_number(8) == ("", 0)
    for number in range(100, 250):
        program_names.remember_name(number, f"{number}.nc", number)
    assert program_names.name_of_number(7) == ("", 0) and program_names.name_of_number(249) == ("249.nc", 249), "the oldest are forgotten"


def test_a_file_of_something_else_is_no_reason_to_stop(tmp_path, monkeypatch):
    for text in ("", "[1]", '{"00000007": "x"}', '{"00000007": [1, 2]}'):
        kept = tmp_path / "begun.json"
        kept.write_text(text)
        monkeypatch.setattr(program_names, "KEPT", kept)
        assert program_names.name_of_number(7) == ("", 0)
        program_names.remember_name(7, "a", 1)
        assert program_names.name_of_number(7) == ("a", 1)
    monkeypatch.setattr(program_names, "KEPT", tmp_path / "begun.json" / "no folder")
    program_names.remember_name(7, "a", 1)
    assert program_names.name_of_number(7) == ("", 0)

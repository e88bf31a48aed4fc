"""`passo blackbox` with a file, as somebody gets it who was not there; test_pico_blackbox.py reads one off a port."""

import pytest
from black_boxes import CAUSES
from typer.testing import CliRunner

from host_tools.cli.main import app
from host_tools.failure import Failure
from host_tools.programs.blackbox import board_of, pack_files, unpack_files


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("box") / "yesterday.zip"
    path.write_bytes(pack_files(CAUSES["interlock"]()[0]))
    return path


def said(*words):
    result = CliRunner().invoke(app, ["blackbox", *map(str, words)])
    return result.exit_code, result.output + (result.stderr if result.exit_code else "") + str(result.exception or "")


def test_it_tells_and_replays(file, tmp_path):
    status, text = said(file, "--picture", tmp_path / "timeline.png", "--save", tmp_path / "copy.zip")
    assert status == 0 and "mill_2004" in text and "the interlock has stopped" in text and "the same way, 638 steps" in text
    assert (tmp_path / "timeline.png").read_bytes()[:4] == b"\x89PNG"
    assert unpack_files((tmp_path / "copy.zip").read_bytes()) == unpack_files(file.read_bytes())


def test_it_tells_alone(file):
    status, text = said(file, "--no-replay")
    assert status == 0 and "dy off" in text and "the same way" not in text


def test_another_way_is_an_error(file, tmp_path):
    files = unpack_files(file.read_bytes())
    board = files["board.py"]
    files["board.py"] = board.replace(b"'steps_per_m': 80000", b"'steps_per_m': 79000")
    assert files["board.py"] != board
    path = tmp_path / "other.zip"
    path.write_bytes(pack_files(files))
    status, text = said(path)
    assert status == 1 and "went another way" in text


@pytest.mark.parametrize("words, wanted", [((), "which black box"), (("none.zip",), "no file"), (("{}", "--older"), "no older")])
def test_what_it_refuses(file, words, wanted):
    status, text = said(*(word.format(file) for word in words))
    assert status == 1 and wanted in text


@pytest.mark.parametrize("text", ["import os\nos.mkdir('ran')\nBOARD = {}\n", "BOARD = {'name': __import__('os').mkdir('ran')}\n", "class BOARD:\n    pass\n"])
def test_code_in_the_board_file_of_a_box_is_not_run(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(Failure, match="the board file beside the black box: .* this is code"):
        board_of(text)
    assert not (tmp_path / "ran").exists()

"""`passo wifi`: the file that it writes to a board, which is a folder here in the place of mpremote; its refusals."""

import json
import shutil

import pytest
from typer.testing import CliRunner

from host_tools.cli import wifi
from host_tools.cli.main import app
from host_tools.failure import Failure
from host_tools.clients import page_key
from passo.web import radio


@pytest.fixture
def board(tmp_path, monkeypatch):
    """The board's files; mpremote's words act on them."""

    def mpremote(port, *words):
        assert port == "/dev/ttyACM0"
        if words[0] == "cp":
            assert words[3:] == ("+", "reset")
            shutil.copyfile(words[1], tmp_path / words[2].lstrip(":"))
        path = tmp_path / words[-1].lstrip(":")
        if words[0] == "cat":
            return (path.read_text(), 0) if path.exists() else ("", 1)
        if words[0] == "rm":
            path.unlink(missing_ok=True)
        return "", 0

    monkeypatch.setattr(wifi, "_run_mpremote", mpremote)
    return tmp_path


def passo(*words, said=None):
    result = CliRunner().invoke(app, ["wifi", *words, "--port", "/dev/ttyACM0"], input=said)
    if isinstance(result.exception, Failure):
        return str(result.exception)
    assert result.exception is None, result.exception
    return result.output


def test_a_board_gets_its_network(board, monkeypatch):
    assert passo("show") == "the radio is off\n"
    said = passo("access", "tocha", said="a good passphrase\na good passphrase\n")
    saved = json.loads((board / "wifi.json").read_text())
    assert saved["mode"] == "access" and saved["name"] == "tocha" and saved["passphrase"] == "a good passphrase"
    assert len(saved["key"]) == 16 and page_key.in_groups(saved["key"]) in said and "good passphrase" not in said
    assert passo("show") == f"access point tocha\nkey: {page_key.in_groups(saved['key'])}\n"
    monkeypatch.chdir(board)
    assert radio.read_wifi_file() == saved  # the board can use it
    passo("station", "workshop", "--passphrase", "another passphrase")
    again = json.loads((board / "wifi.json").read_text())
    assert again["mode"] == "station" and again["key"] == saved["key"]
    passo("station", "workshop", "--passphrase", "another passphrase", "--new-key")
    assert json.loads((board / "wifi.json").read_text())["key"] != saved["key"]
    passo("off")
    assert radio.read_wifi_file() is None and passo("show") == "the radio is off\n"


@pytest.mark.parametrize(
    "name, passphrase",
    [("tocha", "short"), ("tocha", "x" * 64), ("tocha", "12121212"), ("tocha", "tocha2024"), ("tocha", "coração forte"), ("", "good enough"),
     ("á" * 17, "good enough")],
)  # fmt: skip
def test_what_is_weak_or_impossible_is_refused(board, name, passphrase):
    said = passo("access", name, "--passphrase", passphrase)
    assert not (board / "wifi.json").exists() and ("passphrase" in said or "name" in said)


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", "{", '{"mode": "access", "name": "a", "passphrase": "", "key": "K"}',
             '{"mode": "open", "name": "a", "passphrase": "12345678", "key": "K"}', '{"mode": "access", "name": "", "passphrase": "12345678", "key": "K"}',
             '{"mode": "access", "name": "a", "passphrase": "12345678", "key": ""}'],
)  # fmt: skip
def test_a_board_without_whole_data_keeps_its_radio_off(text, tmp_path, monkeypatch):
    (tmp_path / "wifi.json").write_text(text)
    monkeypatch.chdir(tmp_path)
    assert radio.read_wifi_file() is None

"""`passo` in Portuguese: numbered errors, settings, first steps; no words missing and none left over."""

import ast
import json
import os
import re
import string
import subprocess
import sys

import pytest

from host_tools import language
from host_tools.clients import setting_names
from host_tools.resources import HOST_TOOLS, ROOT

pytestmark = pytest.mark.quick
WORDS = json.loads((HOST_TOOLS / "pt.json").read_text(encoding="utf-8"))


@pytest.fixture
def portuguese():
    language.choose("pt")
    yield
    language.choose(None)


def texts(source):
    """What a module says by way of _("…"); anything else than one text is a fault."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "_" and isinstance(node.args[0], ast.Constant):
            found.add(node.args[0].value)
    return found


def said():
    return set().union(*(texts(path.read_text(encoding="utf-8")) for path in HOST_TOOLS.rglob("*.py")))


def helps(command):
    """(what each command is for, the help of options)."""
    purposes, options = {language.summary(command.help)}, {param.help for param in command.params if getattr(param, "help", None)}
    for other in getattr(command, "commands", {}).values():
        more = helps(other)
        purposes |= more[0]
        options |= more[1]
    return purposes, options


def test_every_text_has_its_words_and_no_words_are_left_over():
    """Of options, those that many commands have."""
    import typer

    from host_tools.cli.main import app

    purposes, options = helps(typer.main.get_command(app))
    assert not (said() | purposes) - set(WORDS)
    assert not set(WORDS) - said() - purposes - options


def test_words_have_the_fields_of_their_text():
    def fields(text):
        return {name for _, name, _, _ in string.Formatter().parse(text) if name}

    for text, words in WORDS.items():
        assert words.strip() and fields(text) == fields(words), text


def test_what_the_environment_asks_for():
    assert language.preferred({}) == "en"
    assert language.preferred({"LANG": "pt_BR.UTF-8"}) == "pt"
    assert language.preferred({"LC_ALL": "C", "LANG": "pt_BR.UTF-8"}) == "en"
    assert language.preferred({"LANGUAGE": "de:pt:en", "LC_ALL": "C"}) == "pt"
    assert language.preferred({"LANG": "de_DE.UTF-8"}) == "en"


def test_errors_and_settings_in_portuguese(portuguese):
    from passo import error_texts, errors

    for number in error_texts.numbers():
        assert language.error_text(number) == language.catalogue("pt").words.get(error_texts.text(number), error_texts.text(number))
    assert language.error_text(errors.BUSY) != error_texts.text(errors.BUSY)
    assert setting_names.describe("$110=500", 3)[0].startswith("x: ") and "highest" not in setting_names.describe("$110=500", 3)[0]
    assert setting_names.describe("$20=1", 3)[0] != setting_names.NAMES[20][0]
    assert setting_names.describe("G10L2P2X1", 3)[0] == "origem de G55"


def test_nothing_changes_in_english():
    from passo import error_texts, errors

    assert language.error_text(errors.BUSY) == error_texts.text(errors.BUSY)
    assert setting_names.describe("$20=1", 3)[0] == setting_names.NAMES[20][0]


def passo(*words, **environment):
    command = [sys.executable, "-m", "host_tools.cli.main", *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env={**os.environ, "PYTHONIOENCODING": "utf-8", **environment})


def test_the_command_in_portuguese():
    asked, by_environment = passo("--lang", "pt"), passo(LANGUAGE="pt_BR")
    assert "Comece por aqui" in asked.stdout and asked.stdout == by_environment.stdout
    assert "Try this first" in passo("--lang", "en", LANGUAGE="pt").stdout
    for words in (("--lang", "pt", "draw", "--help"), ("draw", "--help")):
        assert "Desenhar um arquivo SVG na plotadora" in passo(*words, LANGUAGE="pt").stdout
    assert "Draw an SVG file" in passo("--lang", "en", "draw", "--help", LANGUAGE="pt").stdout
    refused = passo("--lang", "xx", "ports")
    assert refused.returncode == 1 and re.search("--lang is en or pt, not 'xx'", refused.stderr)

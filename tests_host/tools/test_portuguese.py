"""`passo --lang pt`: the Portuguese texts of a terminal."""

import os
import re
import subprocess

from host_tools import interpreter
from host_tools.resources import ROOT


def passo(*words, **environment):
    command = [*interpreter.passo(), *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env={**os.environ, **environment})


def test_the_command_in_portuguese():
    asked, by_environment = passo("--lang", "pt"), passo(LANGUAGE="pt_BR")
    assert "Comece por aqui" in asked.stdout and asked.stdout == by_environment.stdout
    assert "Try this first" in passo("--lang", "en", LANGUAGE="pt").stdout
    for words in (("--lang", "pt", "draw", "--help"), ("draw", "--help")):
        assert "Desenha um arquivo numa plotter" in passo(*words, LANGUAGE="pt").stdout
    assert "Draw a file" in passo("--lang", "en", "draw", "--help", LANGUAGE="pt").stdout
    assert all(each in asked.stdout for each in ("Uso:", "Opções", "Comandos", "Mostrar esta mensagem"))
    assert "não foi possível ler nada.nc: arquivo ou pasta não encontrado" in passo("--lang", "pt", "check", "nada.nc").stderr
    wrong = passo("--lang", "pt", "drw").stderr
    assert all(each in wrong for each in ("Uso:", "Experimente", "Erro", "Seria 'draw'?"))
    refused = passo("--lang", "xx", "ports")
    assert refused.returncode == 1 and re.search("--lang is en or pt, not 'xx'", refused.stderr)

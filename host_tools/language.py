"""What `passo` says in another language, by gettext: the English text is the key.

    choose("pt")
    error_text(18)                                              # "a máquina está ocupada: …"
    _("{package} is not installed").format(package="numpy")

The words of numbered errors and of settings are the page's (firmware/passo/web/page/pt.json), those of the command its own
(pt.json beside this file): what commands are for, and the options that many of them have. `passo --lang` chooses; without it LANGUAGE, LC_ALL, LC_MESSAGES and LANG do, as for any program.
"""

import gettext
import json
import os
from functools import lru_cache

from host_tools.resources import FIRMWARE, HOST_TOOLS

LANGUAGES = ("en", "pt")
_VARIABLES = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")
_chosen = None


class Catalogue(gettext.NullTranslations):
    """Words from JSON files; what they lack is said in English."""

    def __init__(self, *files):
        super().__init__()
        self.words = {}
        for file in files:
            self.words.update(json.loads(file.read_text(encoding="utf-8")))

    def gettext(self, message):
        return self.words.get(message, message)


@lru_cache(maxsize=None)
def catalogue(language):
    """The words of one of LANGUAGES."""
    if language == "en":
        return gettext.NullTranslations()
    return Catalogue(FIRMWARE / "passo" / "web" / "page" / f"{language}.json", HOST_TOOLS / f"{language}.json")


def choose(language):
    """Speak one of LANGUAGES from now on; None: as the environment says."""
    global _chosen
    _chosen = language


def preferred(environment):
    """The first of LANGUAGES that variables of the environment ask for: the one of most weight that is set decides."""
    for name in _VARIABLES:
        wanted = environment.get(name, "")
        if wanted:
            return next((each for part in wanted.split(":") for each in LANGUAGES if part.lower().startswith(each)), "en")
    return "en"


def _(text):
    """`text` in the language chosen."""
    return catalogue(_chosen or preferred(os.environ)).gettext(text)


def summary(help_):
    """What a command is for: the first paragraph of its help, in one line."""
    return " ".join((help_ or "").partition("\n\n")[0].split())


def speak(command):
    """Put what a click command and its subcommands are for, and their options, into the language chosen. What the catalogue lacks stays
    English."""
    for each in [command, *command.params]:
        english = each.english = getattr(each, "english", getattr(each, "help", None))
        if english:
            first, blank, rest = english.partition("\n\n")
            each.help = _(summary(first)) + blank + rest if summary(first) != _(summary(first)) else english
    for other in getattr(command, "commands", {}).values():
        speak(other)


def error_text(number):
    """What error or alarm `number` means, in one line."""
    from passo import error_texts

    return _(error_texts.text(number))

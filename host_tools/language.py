"""Translates the texts of `passo`, by gettext: the English text is the key.

    choose_language("pt")
    error_text(18)                              # "a máquina está ocupada: …"
    _("{} files in {}", 12, out)                # fields as in str.format(), filled in behind the look-up
    raise Failure("no file {}", path)           # likewise (failure.py), looked up when it is shown

The words of numbered errors and of settings are the page's (firmware/passo/web/page/pt.json), those of the command its own
(pt.json beside this file): help, failures, and texts printed for people; pt_boards.json has faults of board files. Options have theirs in words.py
(options.py). Output for programs is in no language: the port that a board prints, CSV, G-code. `passo --lang` chooses; without it LANGUAGE,
LC_ALL, LC_MESSAGES and LANG do, as for any program.
"""

import gettext
import os
import re
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache

from host_tools.resources import FIRMWARE, HOST_TOOLS

LANGUAGES = ("en", "pt")
_VARIABLES = ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")
_chosen = None
_asked = ContextVar("language", default=None)  # the language of this thread alone


class Catalogue(gettext.NullTranslations):
    """Words from JSON files; texts that they lack stay English."""

    def __init__(self, words, *files):
        import json

        super().__init__()
        self.words = dict(words)
        for file in files:
            self.words.update(json.loads(file.read_text(encoding="utf-8")))

    def gettext(self, message):
        """Return the words for a text; the text itself if there are none."""
        return self.words.get(message, message)


@lru_cache(maxsize=None)
def load_catalogue(language):
    """Return the words of one of LANGUAGES; read once."""
    if language == "en":
        return gettext.NullTranslations()
    own = (HOST_TOOLS / f"{language}{part}.json" for part in ("", "_boards"))
    from host_tools import options  # here: only who wants its words waits for them

    return Catalogue(options.portuguese_texts(), FIRMWARE / "passo" / "web" / "page" / f"{language}.json", *own)


def choose_language(language):
    """Speak one of LANGUAGES from now on; None: as the environment says."""
    global _chosen
    _chosen = language


def language_of(environment):
    """Return the first of LANGUAGES that variables of the environment ask for: of the variables that are set, the first of _VARIABLES decides."""
    for name in _VARIABLES:
        wanted = environment.get(name, "")
        if wanted:
            return next((each for part in wanted.split(":") for each in LANGUAGES if part.lower().startswith(each)), "en")
    return "en"


def current_language():
    """Return the one of LANGUAGES in which texts come out."""
    return _asked.get() or _chosen or language_of(os.environ)


@contextmanager
def in_language(language):
    """Speak one of LANGUAGES in this thread within the block: to a page, whatever the terminal's language is."""
    before = _asked.set(language)
    try:
        yield
    finally:
        _asked.reset(before)


def fill_in(text, *values, **named):
    """Return `text` with its fields; one without values is taken as it is, braces and all."""
    return text.format(*values, **named) if values or named else text


def N_(text):
    """Return `text`, which a `_` elsewhere looks up: for tables."""
    return text


_COUNTS = {
    "line": (N_("1 line"), N_("{} lines")),
    "line of G-code": (N_("1 line of G-code"), N_("{} lines of G-code")),
    "job": (N_("1 job"), N_("{} jobs")),
    "program": (N_("1 program"), N_("{} programs")),
    "arc": (N_("1 arc"), N_("{} arcs")),
    "step": (N_("1 step"), N_("{} steps")),
    "point": (N_("1 point"), N_("{} points")),
    "pass": (N_("1 pass"), N_("{} passes")),
}  # fmt: skip


def count_text(count, noun):
    """Return “1 line”, “2 lines”, in the language chosen. `noun`: a key of _COUNTS."""
    text = _COUNTS[noun][count != 1]
    return _(text, count)


def _(text, *values, **named):
    """Return `text` in the language chosen, with its fields."""
    return fill_in(load_catalogue(current_language()).gettext(text), *values, **named)


def reword_text(text, sentences):
    """Return `text` in the language chosen if it is one of `sentences` with its fields filled in, its fields too; any other as it is."""
    for sentence in sentences:
        found = re.fullmatch(re.escape(sentence).replace(r"\{\}", "(.*?)"), text, re.DOTALL)
        if found:
            return _(sentence, *(reword_text(each, sentences) for each in found.groups()))
    return text


@lru_cache(maxsize=1000)
def in_languages(text):
    """Return {language: `text` in it} of another program's text in one of LANGUAGES, fields too; a text that is not ours stays as it is. "" if it is
    empty. Searches the whole catalogue; results are kept."""
    if not text:
        return ""
    words = load_catalogue("pt").words
    if text in words:
        return {"en": text, "pt": words[text]}
    for english, portuguese in words.items():
        if portuguese == text:
            return {"en": english, "pt": portuguese}
    for pair, patterns in _with_fields():
        found = next(filter(None, (pattern.fullmatch(text) for pattern in patterns)), None)
        if found:
            fields = [in_languages(each) for each in found.groups()]
            return {language: _fill_fields(form, [field[language] for field in fields]) for language, form in zip(LANGUAGES, pair)}
    return {"en": text, "pt": text}


_FIELD = re.compile(r"\{[^{}]*\}")


@lru_cache(maxsize=1)
def _with_fields():
    """Return [((English, Portuguese), (pattern of each))] of texts with fields: those with most words of their own first."""

    def text_pattern(text):
        """Return a pattern that matches the text with any values in its fields."""
        return re.compile("(.*?)".join(map(re.escape, _FIELD.split(text))), re.DOTALL)

    words = [pair for pair in load_catalogue("pt").words.items() if _FIELD.search(pair[0]) and _FIELD.findall(pair[0]) == _FIELD.findall(pair[1])]
    words.sort(key=lambda pair: len(_FIELD.sub("", pair[0])), reverse=True)
    return [(pair, tuple(map(text_pattern, pair))) for pair in words]


def _fill_fields(form, fields):
    """Return a text with these values in its fields, one after the other."""
    return "".join(part + field for part, field in zip(_FIELD.split(form), [*fields, ""]))


def board_file_error(text):
    """Return the firmware's text about a wrong board file, in the current language."""
    return reword_text(text, _board_file_sentences(current_language()))


@lru_cache(maxsize=None)
def _board_file_sentences(language):
    """Return the sentences about board files and options, with `{}` for the firmware's values: those with most words of their own first."""
    if language == "en":
        return []
    from host_tools import options

    known = Catalogue(options.portuguese_texts(), HOST_TOOLS / f"{language}_boards.json").words
    return sorted(known, key=lambda sentence: len(sentence.replace("{}", "")), reverse=True)


def line_text(number):
    """Return the name of line `number` of a file."""
    return _("line {}", number)


def help_pieces(help_):
    """Yield the paragraphs and examples of a help as (text before, a text of the catalogue, text behind). Of an example, a line that is indented, the
    text is the comment behind it."""
    *parts, last = re.split(r"(\n\n|\n(?=    ))", help_ or "")
    for part, end in zip([*parts[::2], last], [*parts[1::2], ""], strict=True):
        example = re.match(r"(\s+.*?)(#|$)\s*(.*)|(Example:)(.*)", part, re.DOTALL)
        if not example:
            yield "", " ".join(part.split()), end
        elif example[4]:
            yield "", example[4], example[5] + end
        else:
            yield example[1] + example[2] + " " * bool(example[3]), example[3], end


def translate_help(command):
    """Put the help of a command and its subcommands, and of their options, into the language chosen."""
    for each in [command, *command.params]:
        english = each.english = getattr(each, "english", getattr(each, "help", None))
        if english and load_catalogue(current_language()) is not load_catalogue("en"):
            each.help = "".join(before + _(text) + after for before, text, after in help_pieces(english))
        else:
            each.help = english
    for other in getattr(command, "commands", {}).values():
        translate_help(other)


def error_text(number):
    """Return the meaning of error or alarm `number`, in one line."""
    from host_tools.options import error_text as text_of

    return _(text_of(number))

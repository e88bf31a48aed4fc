"""Texts of options for people: `words.py` in their folders, which no board has.

    setting_rows()      # {58: ("parking: target, machine coordinate", "mm", -2000, 2000), …}
    status_names()      # {"Vac": "vacuum cleaner", …}

A words.py may have SECTIONS and MEANINGS of keys for docs/reference/board-file.md; SETTINGS by number, AXIS_SETTINGS by the number of the first axis, PAGE, where
docs say more of them, and KEY, if a key's value asks for the option; STATUS, the words that it adds to status reports, each with a name for people; PORTUGUESE of all of these but SECTIONS and
MEANINGS.
"""

from functools import lru_cache
from importlib import import_module
from pathlib import Path

import passo.error_texts
import passo.options

_FOLDER = Path(passo.options.__file__).parent


@lru_cache(maxsize=1)
def words_of_options():
    """Return {option: its words.py} of the options that have one."""
    return {path.parent.name: import_module(f"passo.options.{path.parent.name}.words") for path in sorted(_FOLDER.glob("*/words.py"))}


def _merge_tables(name):
    """Return the tables of that name in all options' words.py as one dict."""
    return {key: value for own in words_of_options().values() for key, value in getattr(own, name, {}).items()}


def setting_rows():
    """Return {number: (name, unit, least, most)} of the settings that options add."""
    return _merge_tables("SETTINGS")


def axis_settings():
    """Return the same of those that each axis has, by the number of the first one's."""
    return _merge_tables("AXIS_SETTINGS")


def status_names():
    """Return {word of a status report: its name}."""
    return _merge_tables("STATUS")


@lru_cache(maxsize=1)
def error_texts():
    """Return {number: text} of all errors and alarms: of the core, of each option, and of each language."""
    found = dict(passo.error_texts.TEXTS)
    for path in sorted(_FOLDER.parent.glob("*/*/error_texts.py")):
        found.update(import_module(f"passo.{path.parent.parent.name}.{path.parent.name}.error_texts").TEXTS)
    return found


def error_text(number):
    """Return the meaning of an error or alarm `number`, in one line."""
    return error_texts().get(number) or passo.error_texts.text(number)


def portuguese_texts():
    """Return {text: the same in Portuguese}."""
    return _merge_tables("PORTUGUESE")

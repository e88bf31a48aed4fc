"""The catalogue of the page and of the texts of `passo`: every text has its words, and no words are left over."""

import json
import re
from html.parser import HTMLParser

import pytest

from host_tools import options
from host_tools.build.pages import page_words
from host_tools.clients import setting_names
from host_tools.panel.panel import FOLDER

pytestmark = pytest.mark.quick

CATALOGUE = page_words()
MODULES = sorted(path.name for path in FOLDER.glob("*.js") if path.name != "torch.js")  # that one has words of its own
TABLES = ("SIGNALS", "ELSEWHERE", "MORE", "STATES", "OVERRIDES", "BITS", "HOW")  # whose texts are shown by way of _()
WHOLE_TABLES = ("LACKS",)  # all of whose values are
# English terms of the documents, and the Portuguese word that a text with them must have.
TERMS = {"spindle": "spindle", "step program": "programa de pulsos", "homing": "origem", "door": "porta", "speed": ("velocidade", "rotação"),
         "inverter": "inversor", "gantry": "pórtico", "motor": "motor", "alarm": "alarm"}  # fmt: skip


class Texts(HTMLParser):
    """The texts of a page that words.js translates."""

    def __init__(self):
        super().__init__()
        self.found = set()
        self._outside = True

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag == "script" or tag != "html" and "lang" in attributes:
            self._outside = False
        if "aria-label" in attributes:
            self.found.add(attributes["aria-label"])

    def handle_endtag(self, tag):
        if tag in ("script", "option"):
            self._outside = True

    def handle_data(self, data):
        text = data.strip()
        if self._outside and re.search("[a-zA-Z]{2}", text):
            self.found.add(text)


def page_texts():
    texts = Texts()
    texts.feed((FOLDER / "index.html").read_text(encoding="utf-8"))
    return texts.found


def script_texts():
    source = "".join((FOLDER / name).read_text(encoding="utf-8") for name in MODULES)
    found = set(re.findall(r'\b_\("([^"]+)"', source))
    for name in TABLES:
        table = re.search(rf"const {name} = (.*?);\n", source, re.DOTALL)[1]
        found |= {text for text in re.findall(r'"([^"]*)"', table) if re.search("[A-Z][a-z]", text)}
    for name in WHOLE_TABLES:
        found |= set(re.findall(r': "([^"]+)"', re.search(rf"const {name} = (.*?);\n", source, re.DOTALL)[1]))
    shown = re.search(r"const how = \{(.*?)\}\[", source, re.DOTALL)[1]
    return found | set(re.findall(r'"([^"]+)"', shown))


def wanted():
    errors = set(options.error_texts().values())
    settings = {name[0] for names in (setting_names.NAMES, setting_names.AXIS_NAMES) for name in names.values()}
    return page_texts() | script_texts() | errors | settings


def test_every_text_has_its_words():
    missing = wanted() - set(CATALOGUE)
    assert not missing, "pt.json lacks:\n" + "\n".join(json.dumps(text, ensure_ascii=False) for text in sorted(missing))


def test_no_words_are_left_over():
    assert not set(CATALOGUE) - wanted()


def test_the_fields_are_the_same():
    for text, words in CATALOGUE.items():
        assert words.strip() and sorted(re.findall(r"\{\w+\}", text)) == sorted(re.findall(r"\{\w+\}", words)), text


def test_the_words_are_those_of_the_documents():
    for text, words in CATALOGUE.items():
        for term, term_words in TERMS.items():
            if re.search(rf"\b{term}\b", text, re.IGNORECASE):
                term_words = (term_words,) if isinstance(term_words, str) else term_words
                assert any(each in words.lower() for each in term_words), f"{text}: {words}"


def test_a_page_is_small(tmp_path):
    """All that a board keeps of it, compressed."""
    from host_tools import boards
    from host_tools.build.pages import pack_files

    for name in ("plotter_page", "router_pico_w"):
        rows = pack_files(boards.load(name), tmp_path / name)
        assert "index.html" in [name for name, _, _ in rows] and sum(packed for _, _, packed in rows) < 100_000  # 6 kB are a sentence for each control, twice

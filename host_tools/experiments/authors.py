"""The figures that the documents print, from authors.json: each with its document, page, and table, figure or section.

    author_figure("square better").value        # 3.96, in author_figure("square better").unit
    author_figure("square better").place.text() # 'plotter 2014, p. 76, table 8'
    document_place("section 2.7.3")             # the same without a figure: the document tells the test, and no number
"""

import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from host_tools.language import N_, _

NAMES = {"plotter": N_("plotter"), "torch": N_("torch"), "pulses": N_("parallel port"), "mill": N_("mill"), "keys": N_("kit")}
PARTS = {"table": N_("table {}"), "figure": N_("figure {}"), "section": N_("section {}")}
ORIGIN = N_("the sensors of the origin")


@dataclass(frozen=True)
class Place:
    """A place in a document: `name` is a table, figure or section; `document` a key of NAMES; `page` 0: none."""

    name: str
    document: str
    page: int

    def text(self):
        """Return the name of the place for people: “plotter 2014, p. 76, table 8”."""
        kind, _space, number = self.name.rpartition(" ")
        part = _(PARTS[kind], number) if kind in PARTS else _(self.name)
        document = read_data()["documents"][self.document]
        year = f" {document['year']}" if document["year"] else ""
        page = _(", p. {}", self.page) if self.page else ""
        return f"{_(NAMES[self.document])}{year}{page}, {part}"


@dataclass(frozen=True)
class Author:
    """A figure as a document prints it; `value` None: the document has the test, and no figure."""

    place: Place
    printed: str = ""
    value: float | None = None
    unit: str = ""


@lru_cache
def read_data():
    """Return the contents of authors.json; read once."""
    return json.loads((Path(__file__).parent / "authors.json").read_text(encoding="utf-8"))


def document_place(name):
    """Return the Place of that name in a document. Raises KeyError if there is none."""
    found = read_data()["places"][name]
    return Place(name, found["document"], found["page"])


def author_figure(name):
    """Return a figure that a document prints. Raises KeyError if no document has it."""
    found = read_data()["figures"][name]
    value = found["value"] if "value" in found else float(found["printed"].replace(",", "."))
    return Author(document_place(found["place"]), found["printed"], value, found["unit"])


def without_figure(name):
    """Return an Author for a place at which a document tells a test and gives no figure. Raises KeyError."""
    return Author(document_place(name))

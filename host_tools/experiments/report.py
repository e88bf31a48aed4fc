"""Writes the files of `passo experiments`: report.html, one page to print on A4 and hand in, and table.csv.

    write(folder, done, place_title)        # done: [(name, Outcome, or the sentence why it is not measured)]
"""

import csv
import time
from html import escape

from host_tools.experiments.authors import NAMES, read_data
from host_tools.experiments.experiments import EXPERIMENTS
from host_tools.experiments.row import figure_text
from host_tools.language import _, current_language
from host_tools.resources import version

COLUMNS = ("experiment", "what", "document", "page", "at", "printed", "author", "author_unit", "ours", "unit", "note", "right", "measured_on")
STYLE = """
@page { size: A4; margin: 16mm 15mm }
body { font: 10.5pt/1.4 "Helvetica Neue", Arial, sans-serif; color: #222; max-width: 180mm; margin: 8mm auto; padding: 0 4mm }
h1 { font-size: 19pt; margin: 0 0 1mm; color: #173f5f } h2 { font-size: 12.5pt; margin: 9mm 0 1mm; color: #173f5f; break-after: avoid }
.about, .how { color: #555; font-size: 9.5pt; margin: 0 0 2mm } .how { break-after: avoid } .who { display: flex; gap: 8mm; margin: 5mm 0 2mm }
.who span { flex: 1; border-bottom: 1px solid #888; padding-bottom: 1mm; color: #555; font-size: 9.5pt }
table { border-collapse: collapse; width: 100%; font-size: 9.5pt } th { text-align: left; border-bottom: 1.5px solid #173f5f; font-weight: 600; padding: 1mm 2mm }
td { border-bottom: 1px solid #e2e2e2; padding: 0.8mm 2mm; vertical-align: top } tr { break-inside: avoid }
.n { text-align: right; white-space: nowrap } .at { color: #777; font-size: 8.5pt; white-space: nowrap } .wrong { color: #b00020; font-weight: 600 } .note { color: #777; font-size: 8.5pt }
figure { margin: 3mm 0 0; break-inside: avoid } figcaption { font-size: 9pt; color: #555 } svg { width: 100%; height: auto; max-height: 72mm }
footer { margin-top: 9mm; border-top: 1px solid #ccc; padding-top: 2mm; font-size: 8.5pt; color: #666 }
"""


def author_text(author):
    """Return a document's figure as it prints it, and its value in the table's unit if it prints another one."""
    if not author.printed:
        return _("no figure")
    plain = author.printed.replace(",", "").replace(".", "").isdigit()
    if plain or author.value is None:
        return f"{author.printed} {_(author.unit) if author.unit else ''}".strip()
    return author.printed if author.unit == "s" else _("{}: {} {}", author.printed, figure_text(author.value), _(author.unit))


def own_text(row):
    """Return the measured value of a row with its unit, or its text."""
    if row.ours is None:
        return row.told
    return f"{figure_text(row.ours)} {row.unit}"


def page_html(done, place_title):
    """Return the text of report.html. `done`: as write() takes it."""
    body = "".join(_section_html(name, outcome) for name, outcome in done)
    title = _("Experiments of five documents, repeated")
    about = _("Measured on: {}. Passo {}, {}.", place_title, version(), time.strftime("%Y-%m-%d"))
    who = "".join(f"<span>{escape(each)}</span>" for each in (_("Name"), _("Class"), _("Date")))
    return (
        f'<!doctype html><html lang="{current_language()}"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{escape(title)}</title>'
        f"<style>{STYLE}</style></head><body><h1>{escape(title)}</h1><p class=about>{escape(about)}</p><div class=who>{who}</div>{body}{_sources_html(done)}</body></html>\n"
    )


def _section_html(name, outcome):
    """Return the heading, table and pictures of an experiment, or the reason why it is not measured."""
    head = f"<h2>{escape(_(EXPERIMENTS[name].title))}</h2>"
    if isinstance(outcome, str):
        return f"{head}<p class=how>{escape(_('Not measured: {}.', outcome))}</p>"
    names = "".join(f"<th{kind}>{escape(each)}</th>" for each, kind in ((_("what"), ""), (_("document"), " class=n"), (_("where in it"), ""), (_("measured"), " class=n")))
    rows = "".join(_row_html(row) for row in outcome.rows)
    shown = "".join(f"<figure><figcaption>{escape(caption)}</figcaption>{svg}</figure>" for caption, svg in outcome.pictures)
    return f"{head}<p class=how>{escape(_as_sentence(outcome.how))}</p><table><thead><tr>{names}</tr></thead><tbody>{rows}</tbody></table>{shown}"


def _row_html(row):
    """Return a row of the table."""
    note = f"<br><span class=note>{escape(row.told)}</span>" if row.told and row.ours is not None else ""
    mark = {None: "", True: " ✓", False: " ✗"}[row.agrees]
    wrong = " wrong" if row.agrees is False else ""
    cells = f"<td class=n>{escape(author_text(row.author))}</td><td class=at>{escape(row.author.place.text())}</td>"
    return f'<tr><td>{escape(row.what)}{note}</td>{cells}<td class="n{wrong}">{escape(own_text(row))}{mark}</td></tr>'


def _as_sentence(text):
    """Return a text with a capital letter and a full stop."""
    return text[:1].upper() + text[1:] + "."


def _sources_html(done):
    """Return the list of the documents used."""
    used = dict.fromkeys(EXPERIMENTS[name].document for name, _outcome in done)
    used.update({row.author.place.document: None for _name, outcome in done if not isinstance(outcome, str) for row in outcome.rows})
    lines = []
    for key in used:
        document = read_data()["documents"][key]
        named = ", ".join(str(each) for each in (document["author"], document["title"], document["year"]) if each)
        lines.append(f"<li>{escape(_(NAMES[key]))}: {escape(named)}</li>")
    return f"<footer>{escape(_('Documents'))}<ul>{''.join(lines)}</ul></footer>"


def write(folder, done, place_title):
    """Write report.html and table.csv to `folder`, which is made; return both paths."""
    folder.mkdir(parents=True, exist_ok=True)
    html, table = folder / "report.html", folder / "table.csv"
    html.write_text(page_html(done, place_title), encoding="utf-8")
    with open(table, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for name, outcome in done:
            writer.writerows(_csv_fields(name, row, place_title) for row in ([] if isinstance(outcome, str) else outcome.rows))
    return html, table


def _csv_fields(name, row, place_title):
    """Return the fields of a row of table.csv, in the order of COLUMNS."""
    place, author = row.author.place, row.author
    own = [author.printed, author.value, author.unit, row.ours, row.unit, row.told, row.agrees, place_title]
    return [name, row.what, place.document, place.page or "", place.name, *("" if each is None else each for each in own)]

"""The report of `passo prove`: a table for people, JSON, and a picture of the timings.

    print_report(rows, header)                  # to the terminal, made to be pasted into an issue
    draw_picture("prove.png", timings)
"""

import io
import json

from rich.console import Console
from rich.table import Table

from host_tools.language import _
from host_tools.prove.promises import BETTER, KEPT, WORSE
from host_tools.prove.proof import PARTS

COLOURS = {BETTER: "green", KEPT: "", WORSE: "bold red"}


def report_table(rows, header):
    """Return a rich Table of the rows: row, found, promised and verdict."""
    made = Table(title=header, title_justify="left", box=None, pad_edge=False, title_style="bold")
    for name in (_("row"), _("found"), _("promised"), ""):
        made.add_column(name, overflow="fold")
    for row in rows:
        made.add_row(row.what, row.found, row.promised, _(row.verdict) if row.verdict else "", style=COLOURS.get(row.verdict, "dim"))
    return made


def summary_sentences(rows):
    """Return the sentences under the table."""
    wrong = [row for row in rows if row.verdict == WORSE]
    told = [f"{row.what}: {row.found}. {row.advice}." for row in wrong]
    counts = {name: sum(row.verdict == name for row in rows) for name in (BETTER, KEPT, WORSE)}
    told.append(_("{} better, {} as promised, {} worse", *counts.values()))
    if not wrong:
        told.append(_("This board does what the documents say. docs/reference/boards.md says how to send this report."))
    return told


def print_report(rows, header, file=None):
    """Print the table and the summary to the terminal, or to `file`, 110 letters wide."""
    console = Console(file=file, width=110 if file else None)
    console.print(report_table(rows, header))
    for sentence in summary_sentences(rows):
        console.print(sentence, markup=False, highlight=False)


def as_lines(proof, header):
    """Yield the rows; print each as JSON once it is measured, and in front of them the part that they belong to."""
    print(json.dumps({"header": header}), flush=True)
    for number, (title, rows) in enumerate(proof.parts()):
        print(json.dumps({"part": title, "number": number, "of": len(PARTS), "said": ""}), flush=True)
        for row in rows:
            print(json.dumps(vars(row)), flush=True)
            yield row


def last_line(rows, header):
    """Return the JSON that follows the rows: the report as text, and the sentences under its table."""
    told = io.StringIO()
    print_report(rows, header, told)
    return json.dumps({"report": told.getvalue(), "summary": summary_sentences(rows)})


def as_json(rows, about):
    return json.dumps({**about, "rows": [vars(row) for row in rows]}, ensure_ascii=False, indent=1)


def draw_picture(path, timings):
    """Draw edges against their words, intervals, and answers, as a PNG."""
    from matplotlib import ticker

    from host_tools.figures import pyplot

    plt = pyplot()
    figure, ((lateness, intervals), (stops, asks)) = plt.subplots(2, 2, figsize=(11, 7), layout="constrained")
    for name, label in (("own", _("the board's own speeds")), ("fastest", _("three axes at their fastest"))):
        if name in timings and timings[name]["lateness_ns"]:
            lateness.plot(timings[name]["lateness_ns"], ".", markersize=2, label=label)
            intervals.plot([each / 1000 for each in timings[name]["interval_ns"]], ".", markersize=2, label=label)
    lateness.axhspan(-80, 80, alpha=0.15)
    lateness.set(title=_("edges off their words, one tick shaded"), ylabel="ns", xlabel=_("edge"))
    intervals.set(title=_("intervals of the first axis"), ylabel="µs", xlabel=_("step"), yscale="log")
    intervals.yaxis.set_major_formatter(ticker.ScalarFormatter())
    intervals.yaxis.set_minor_formatter(ticker.ScalarFormatter())
    stops.plot(range(1, len(timings.get("stops", ())) + 1), timings.get("stops", ()), "o", markersize=4)
    stops.axhline(25, linestyle="--", label=_("promised"))
    stops.set(title=_("halting input to the last step"), ylabel="µs", xlabel=_("stop"))
    asks.hist(timings.get("asks", ()), bins=30)
    asks.set(title=_("`?` answered in a stream"), xlabel="ms")
    for axes in (lateness, intervals, stops):
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="best", fontsize=8)
    figure.savefig(path, dpi=110)
    plt.close(figure)

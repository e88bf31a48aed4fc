"""The rows at the top of docs/reference/benchmarks.md, filled in from the tables below them.

    text = summarise(text)

A row whose figure is not in ROWS says what a test measures, and is written by hand. Figures are those with the flash cache if a table has both,
unless the row says otherwise.
"""

import re

CACHED = ", flash cache"


class Tables:
    """The tables that benches have written, by their names: each row as {column: cell}."""

    def __init__(self, document):
        self._document = document

    def rows(self, part):
        """Return the rows of a part's table as [{column: cell}]. A column's name that comes a second time gets "UF2: " in front."""
        table = re.search(rf"<!-- bench:{part} -->\n(.*?)\n<!-- /bench:{part} -->", self._document, re.DOTALL)[1]
        header, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines())
        names = [name if name not in header[:column] else "UF2: " + name for column, name in enumerate(header)]
        return [dict(zip(names, row)) for row in rows]

    def row(self, part, *cells):
        """Return the row that begins with these cells."""
        return next(row for row in self.rows(part) if tuple(row.values())[: len(cells)] == cells)

    def row_with_cache(self, part, *cells):
        """Return the row with the flash cache: itself, if its figures stand side by side; the next one, if rows follow each other."""
        row = self.row(part, *cells)
        return self.row(part, *cells, "yes") if row.get("flash cache") == "no" else row

    def promise_text(self, figure):
        """Return the text of the figure's row at the top in the column of its promise."""
        return re.search(rf"^\| {re.escape(figure)} \| ([^|\n]*) \|", self._document, re.MULTILINE)[1]


def with_cache(row, column):
    return row.get(column + CACHED, row[column])


def _pulses_text(tables, axes, template):
    left = [tables.row("pulses", axes, khz) for khz in ("480", "400") if (axes, khz) != ("1", "400")]
    return template.format(*[with_cache(row, "CPU left")[:-1] for row in left], free=left[0]["CPU left"][:-1])


def _edges_text(tables):
    rows = tables.rows("pulses")
    return f"{max(int(row['edge off its word, ns']) for row in rows)} ns, {sum(int(row['words late']) for row in rows)} words late"


def _rate_text(tables):
    return f"{max(abs(int(tables.row('pulses', axes, '100')['rate error, ppm'])) for axes in '13')} ppm"


def _timer_text(tables):
    """Return the text of the timer's row: words late, and the worst edge in µs at all rates and at 36 kHz, without and with the flash cache."""

    def worst(flash, khz=None):
        return max(float(row["µs, worst"]) for row in tables.rows("timer") if row["flash cache"] == flash and khz in (None, row["kHz"]))

    late = sum(int(row["words late"]) for row in tables.rows("timer"))
    every = f"120 kHz, {late} words late; edges within {worst('no')} µs, with the flash cache within {worst('yes')}"
    return f"{every}; at 36 kHz within {worst('no', '36')} and {worst('yes', '36')}"


def _halt_text(tables, by, figure):
    """Return the worst of the row `by`, and by which way of measuring it is over the `figure`'s must."""
    row, must = tables.row("stops", by), tables.promise_text(figure)
    free, charged = row["worst"], with_cache(tables.row_with_cache("stops", by), "worst")
    must_us = float(must.removesuffix(" µs"))
    over = f", more than the {must}" if float(charged) > must_us else ""
    worst = f"{free} µs{f', with the flash cache {charged}' if charged != free else ''}{over}"
    return f"at most {worst}; {row['exact']} of {row['trials']} positions exact"


def _resumes_text(tables):
    row = tables.row("stops", "taken up again")
    return f"{row['exact']} of {row['trials']} lines end on target, no step more or less"


def _queries_text(tables):
    row = tables.row("queries", "3", "100", "yes")
    words = max(int(tables.row("queries", "3", "100", flash)["words walked, at most"]) for flash in ("no", "yes"))
    return f"{int(row['µs, median']) / 1000:.1f} ms, at worst {int(row['worst']) / 1000:.1f} ms; {words} words"


def _uart_text(tables):
    """Return the text of the UART's row: the least share of the wire in %, points a second at 57 600 and 115 200 baud, and the bytes lost and words
    late of both."""
    rows = [tables.row("links", f"UART, {baud} baud", "100", "32") for baud in ("57 600", "115 200")]
    share = min(int(row["of the wire"][:-1]) for row in rows)
    counts = [f"{sum(int(row[column]) for row in rows)} {column}" for column in ("bytes lost", "words late")]
    free, charged = ([row["points/s" + each] for row in rows] for each in ("", CACHED))
    return f"{share} %: {free[0]}/s at 57 600 baud and {free[1]}/s at 115 200; with the flash cache {' and '.join(charged)}; {', '.join(counts)}"


def _usb_points(tables):
    idle, busy = (with_cache(tables.row("links", "USB", khz, "32"), "points/s") for khz in ("0", "100"))
    return f"{idle}/s with the flash cache; {busy}/s with three axes at 100 kHz"


def _status_text(tables):
    """Return the text of the row of `?`: 99th percentiles in ms on USB and a UART, at 200 and 125 MHz, amid short lines and longer ones."""

    def answers_p99(mhz, stream):
        rows = (tables.row("status", link, mhz, stream) for link in ("USB", "UART, 115 200 baud"))
        return [f"{float(with_cache(row, 'p99')):.1f}" for row in rows]

    short, longer = "a stream of lines of 0.2 mm at 50 mm/s", "a stream of lines of 1.5 mm at 3 × 100 kHz"
    first = "{} ms on USB, {} on a UART; at 125 MHz {} and {}".format(*answers_p99("200", short), *answers_p99("125", short))
    return first + "; of lines of 1.5 mm {} and {}, at 125 MHz {} and {} ms".format(*answers_p99("200", longer), *answers_p99("125", longer))


def _gcode_text(template, *names):
    """Return a function of the tables: the figures at 125 MHz of the rows with these names, then those at 200 MHz."""

    def fill(tables):
        rows = [next(row for row in tables.rows("gcode") if row["G-code on router_3axis"].startswith(name) and row["MHz"] == mhz)
                for mhz in ("125", "200") for name in names]  # fmt: skip
        return template.format(*[with_cache(row, "measured") for row in rows])

    return fill


def _boot_figures(tables, column, to_text):
    return [to_text(int(tables.row("boot", board, language, "no")[column])) for board, language in BOOTED]


def _heap_text(tables):
    """Return the text of the heap's row: kB free on stock MicroPython and with Passo's UF2, of three board files, and the router's largest piece."""

    def kilobytes_text(value):
        return f"{value / 1000:.0f}"

    free, uf2 = (_boot_figures(tables, column, kilobytes_text) for column in ("heap free, bytes", "heap free"))
    pieces = [_boot_figures(tables, column, kilobytes_text)[1] for column in ("in one piece", "UF2: in one piece")]
    return (
        f"{free[0]} kB plotter, {free[1]} kB router, {free[2]} kB mill_2004; {pieces[0]} kB of the router's in one piece; code in flash. "
        f"Passo's UF2: {uf2[0]}, {uf2[1]} and {uf2[2]} kB, {pieces[1]} kB"
    )


def _ready_text(tables):
    """Return the text of the row of the first answer: seconds after reset, on stock MicroPython and with Passo's UF2, of three board files."""
    stock, uf2 = (_boot_figures(tables, column, lambda value: f"{value / 1000:.1f}") for column in ("first answer, ms after reset", "first answer"))
    return (
        f"{stock[0]} s plotter, {stock[1]} s router, {stock[2]} s mill_2004, the first time: with a journal 0.3 s of it, because its blocks are erased. "
        f"Passo's UF2: {uf2[0]}, {uf2[1]} and {uf2[2]} s. Without the flash cache"
    )


BOOTED = ("plotter_2014", "plotter"), ("router_3axis", "grbl"), ("mill_2004", "grbl")
LINES, DOTS = "lines of 0.2 mm at 490 mm/s", "dots of 0.1 mm at 200 mm/s, M4"
PICTURE = "a picture's " + DOTS[:-2]
UART = " over a UART of 115 200 baud, the PC takes 0 µs"
FIRST_HALT, OTHER_HALTS = "halting input to the last step: the first", "halting input to the last step: others"
THREE = "480 kHz, {} % left with the flash cache; at 400 kHz {} %"
ROWS = {
    "three axes together, packets arriving, garbage collected without pause": lambda tables: _pulses_text(tables, "3", THREE),
    "four axes together, the same": lambda tables: _pulses_text(tables, "4", THREE),
    "one axis": lambda tables: _pulses_text(tables, "1", "480 kHz, {free} % left; {} with the flash cache"),
    "edges off their words (PIO), the same load": _edges_text,
    "rate error at 100 kHz": _rate_text,
    "timer player, one axis or three, garbage collected without pause": _timer_text,
    FIRST_HALT: lambda tables: _halt_text(tables, "first pin", FIRST_HALT),
    OTHER_HALTS: lambda tables: _halt_text(tables, "other pins", OTHER_HALTS),
    "taken up again after a halt at speed": _resumes_text,
    "asking for the position while three axes step at 100 kHz": _queries_text,
    "points on the UART, three axes at 100 kHz, part of the wire's limit": _uart_text,
    "points over USB": _usb_points,
    "`?` answered in a full stream of lines of 0.2 mm, as flashed (200 MHz), flash cache modelled, p99": _status_text,
    "G-code lines of 0.2 mm a second, three axes, stepped, fed from the board's memory, flash cache modelled":
        _gcode_text("{}; at 200 MHz {}; 2450 were asked for", LINES + " from memory"),
    "the same over USB, 127 bytes under way, the PC answers at once":
        _gcode_text("{0}; at 200 MHz {2}. If the PC takes 1 ms: {1}; at 200 MHz {3}", LINES + " over USB, the PC takes 0", LINES + " over USB, the PC takes 1000"),
    "the same over a UART of 115 200 baud, whose wire is full": _gcode_text("{}; at 200 MHz {}", LINES + UART),
    "a laser's dots of 0.1 mm a second, each its own power, fed from the board's memory, flash cache modelled":
        _gcode_text("{} with M4 and {} with M3; at 200 MHz {} and {}: 2000 were asked for", PICTURE + "M4", PICTURE + "M3"),
    "a laser's dots over USB, 127 bytes under way, the PC answers at once": _gcode_text("{} with M4; at 200 MHz {}", DOTS + ", over USB"),
    "a laser's dots over a UART of 115 200 baud": _gcode_text("{} with M4; at 200 MHz {}", DOTS + "," + UART),
    "command to the first step from rest, over USB, flash cache modelled": _gcode_text("at most {} ms; at 200 MHz {} ms", "first step after a command"),
    "feed hold begins to slow, over USB, flash cache modelled": _gcode_text("at most {} ms; at 200 MHz {} ms", "a feed hold begins"),
    "heap free, all loaded": _heap_text,
    "reset to the first answer": _ready_text,
}  # fmt: skip


def summarise(document):
    """Return the document with each of these rows as its tables have it. Raises KeyError if there is no such row."""
    tables = Tables(document)
    for figure, measured in ROWS.items():
        row = re.compile(rf"^(\| {re.escape(figure)} \|[^|\n]*\|[^|\n]*\| )[^|\n]*(?= \|)", re.MULTILINE)
        if not row.search(document):
            raise KeyError(figure)
        text = measured(tables)
        document = row.sub(lambda found: found[1] + text, document)
    return document

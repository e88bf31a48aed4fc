"""`python -m host_tools.bench`: the measurements, printed as tables and written to docs/reference/benchmarks.md.

Each part of the document stands between two markers and is replaced when its bench has run, and with it the day and the commit below it, and the
rows at the top that tell its figures (summary.py). The text around it, with method and meaning, is written by hand. `make bench ARGS=lines` runs one part; `motion` and `arcs` take many minutes and run only if
they are named.

The parts of the emulated Pico are in `pico`, `moving`, `where` and `frozen`; `make bench ARGS=pico` runs all of them.
Each is measured twice: without a flash cache, and with one whose misses cost FLASH_MISS cycles (or PASSO_FLASH_MISS); the
figures that differ stand side by side. Without a MicroPython UF2 these parts stay as they were, with a message. `where` needs
the ELF file of the UF2: `make bench ARGS="where --elf FILE"`, or PASSO_ELF.
"""

import json
import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from statistics import fmean

from host_tools import interpreter
from host_tools.bench.summary import summarise
from host_tools.build.tree import unix_tree
from host_tools.emulator import binary
from host_tools.emulator.binary import Unavailable
from host_tools.failure import Failure
from host_tools.resources import ROOT

TESTS = ROOT / "tests_host"
DOCUMENT = ROOT / "docs" / "reference" / "benchmarks.md"
_FOLDERS = TESTS / "properties", *sorted((TESTS / "options").glob("*/")), TESTS / "sims", ROOT / "host_tools" / "experiments", ROOT
CPYTHON = interpreter.python(ROOT / "firmware", *_FOLDERS, ROOT / "host_tools" / "shims")
MICROPYTHON = interpreter.micropython_command()
_TIMEOUT_S = 600


def _script_environment():
    """Return the environment of a script under MicroPython, which imports the firmware and the tests."""
    return interpreter.environment(unix_tree(), *_FOLDERS)


def _script_command(program, script, *arguments):
    """Return the command of a script of tests_host/properties and its arguments, under CPython or MicroPython."""
    heap = ["-X", "heapsize=64m"] if program is MICROPYTHON else []
    return [*program, *heap, TESTS / "properties" / script, *map(str, arguments)]


def _available_interpreters():
    return {"CPython": CPYTHON, **({"MicroPython": MICROPYTHON} if MICROPYTHON else {})}


def measure_lines():
    """Compare integer lines with floating-point lines, on the objects of 2014, under two interpreters."""
    from host_tools.drawings.objects import objects

    corners = "".join(
        f"{name} {' '.join(f'{x} {y}' for _, x, y in points)}\n" for name, points in objects().items()
    )
    results = {name: _run_lines(program, corners) for name, program in _available_interpreters().items()}
    header = ["object", "points", "steps"]
    for name in results:
        header += [f"{name} float µs", "integer µs", "better", "as driven µs"]
    rows = []
    for name in next(iter(results.values())):
        points, steps = next(iter(results.values()))[name][:2]
        row = [name, points, steps]
        for result in results.values():
            driven_us, integer_us, float_us = result[name][2:]
            row += [float_us, integer_us, _gain_text(float_us, integer_us), driven_us]
        rows.append(row)
    means = ["mean", "", ""]
    for result in results.values():
        driven_us, integer_us, float_us = (round(fmean(row[index] for row in result.values())) for index in (2, 3, 4))
        means += [float_us, integer_us, _gain_text(float_us, integer_us), driven_us]
    return header, [*rows, means]


def _gain_text(float_us, integer_us):
    return f"{100 * (float_us / integer_us - 1):.1f} %"


def _run_lines(program, corners):
    """{object: [points, steps, as driven µs, integer µs, float µs]} as tests_host/properties/bench_lines.py measures them."""
    script = TESTS / "properties" / "bench_lines.py"
    done = subprocess.run(_script_command(program, script.name), input=corners, env=_script_environment(), capture_output=True, text=True,
                          timeout=_TIMEOUT_S)
    if done.returncode:
        raise Failure(f"{script.name} under {program[0]}: {done.stderr.strip().splitlines()[-1]}")
    return {name: [int(number) for number in numbers] for name, *numbers in map(str.split, done.stdout.splitlines())}


def measure_fuzz():
    """Send a million lines and byte streams to the grbl link; PASSO_FUZZ_LINES is another number."""
    count = int(os.environ.get("PASSO_FUZZ_LINES", 1_000_000))
    shares = [("CPython", CPYTHON, count * 2 // 5, seed) for seed in (1, 2)]
    if MICROPYTHON:
        shares.append(("MicroPython", MICROPYTHON, count - 2 * shares[0][2], 3))
    with ThreadPoolExecutor(2) as pool:
        done = list(pool.map(lambda share: _run_fuzz(*share[1:]), shares))
    rows = [[name, seed, *numbers] for (name, _, _, seed), numbers in zip(shares, done)]
    rows.append(["all", "", *map(sum, zip(*done))])
    return ["interpreter", "seed", "lines", "refused", "resets"], rows


def _run_fuzz(program, count, seed):
    """Return [lines, refused, resets] of tests_host/properties/fuzz_grbl.py."""
    command = _script_command(program, "fuzz_grbl.py", count, seed)
    done = subprocess.run(command, env=_script_environment(), capture_output=True, text=True)
    if done.returncode:
        raise Failure(f"fuzz, seed {seed}: {(done.stderr or done.stdout).strip().splitlines()[-1]}")
    return [int(number) for number in done.stdout.split()]


def measure_motion():
    """Check the limits over random programmes, half of them under each interpreter; PASSO_SOAK_PROGRAMMES is how many."""
    count = int(os.environ.get("PASSO_SOAK_PROGRAMMES", 10_000))
    rows = []
    programs = list(_available_interpreters().items())
    for index, (name, program) in enumerate(programs):
        bounds = range(count * index // len(programs), count * (index + 1) // len(programs), 250)
        chunks = [(program, "soak_motion.py", first, min(first + 250, bounds.stop)) for first in bounds]
        rows.append([name, *_run_soaks(chunks, 3)])
    return ["interpreter", "programmes", "blocks", "segments", "change of speed", "steps over", "time", "failed"], rows


def measure_arcs():
    """Walk every radius to 2000, and random ones to 2²⁰, under two interpreters."""
    rows = []
    for name, program in _available_interpreters().items():
        chunks = [(program, "soak_circle.py", first, first + 99) for first in range(1, 2001, 100)]
        rows.append([name, *_run_soaks(chunks, 2)])
    return ["interpreter", "arcs", "words", "off the circle", "third axis", "CORDIC", "failed"], rows


def _run_soaks(chunks, sums):
    """Run each (program, script, first, last) and combine their last lines: add up the first `sums` figures and the last one,
    take the worst of the others."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = [line.split() for line in pool.map(_run_soak, chunks)]
    totals = []
    for index in range(len(rows[0])):
        column = [row[index] for row in rows]
        added = index < sums or index == len(rows[0]) - 1
        totals.append(sum(map(int, column)) if added else max(column, key=float))
    return totals


def _run_soak(chunk):
    """Run a script, (program, script, first, last), and print the failures that it prints; return its last line, the totals. Raises Failure if the
    script writes to stderr, or prints nothing."""
    done = subprocess.run(_script_command(*chunk), env=_script_environment(), capture_output=True, text=True)
    if done.stderr or not done.stdout:
        raise Failure(f"{chunk[1]} under {chunk[0]}: {(done.stderr or 'no answer').strip().splitlines()[-1]}")
    *failures, totals = done.stdout.splitlines()
    for failure in failures:
        print(failure, flush=True)
    return totals


def _on_the_pico(part):
    """Return a function that measures the part without and with the flash cache, in two processes at the same time."""

    def measure_part():
        """Return (header, rows) with and without the flash cache, joined; of the parts of ONLY_CHARGED the table with misses alone. A miss costs
        PASSO_FLASH_MISS cycles."""
        binary.load_emulator()
        os.environ.setdefault("PASSO_UF2", str(binary.find_uf2()))
        miss = int(os.environ.get("PASSO_FLASH_MISS") or FLASH_MISS)
        if part in ONLY_CHARGED:
            return _run_apart(part, miss)
        with ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda cycles: _run_apart(part, cycles), (0, miss)))
        return join_tables(*found)

    return measure_part


def _run_apart(part, miss):
    """Return (header, rows) of a part of the Pico if a miss of the flash cache costs `miss` cycles."""
    command = [*interpreter.python(), "-m", "host_tools.bench", "--raw", part]
    done = subprocess.run(command, env=dict(os.environ, PASSO_FLASH_MISS=str(miss)), stdout=subprocess.PIPE, text=True)
    if done.returncode == UNAVAILABLE:
        raise Unavailable("see above")
    if done.returncode:
        raise Failure(f"{part} ended with {done.returncode}")
    return json.loads(done.stdout.splitlines()[-1])


def _print_raw(part):
    """Measure a part of the Pico in this process, and print (header, rows) as JSON, each cell as text."""
    from host_tools.bench import frozen, moving, pico, streams, where

    header, rows = (pico.PARTS | moving.PARTS | where.PARTS | frozen.PARTS | streams.PARTS)[part]()
    print(json.dumps((header, [[str(cell) for cell in row] for row in rows])))


def join_tables(free, charged):
    """Join two tables: few different columns stand side by side; if there are many, the rows follow each other."""
    (header, rows), (_, others) = free, charged
    header = list(header)
    assert len(rows) == len(others)
    differ = [index for index in range(len(header)) if any(a[index] != b[index] for a, b in zip(rows, others))]
    if not differ:
        return header, rows
    if len(differ) <= COLUMNS_BESIDE:

        def join_rows(row, other):
            return [cell for index, pair in enumerate(zip(row, other)) for cell in pair[: 1 + (index in differ)]]

        return join_rows(header, [f"{name}, flash cache" for name in header]), [join_rows(*pair) for pair in zip(rows, others)]
    first = differ[0]
    table = []
    for pair in zip(rows, others):
        named = [("yes or no", pair[0])] if pair[0] == pair[1] else zip(("no", "yes"), pair)
        table += [[*row[:first], name, *row[first:]] for name, row in named]
    return [*header[:first], "flash cache", *header[first:]], table


def measure_ways():
    from host_tools.bench import ways

    return ways.ways_table()


UNAVAILABLE = 3  # exit status
FLASH_MISS = 50  # cycles, where PASSO_FLASH_MISS does not say it
COLUMNS_BESIDE = 3
ONLY_CHARGED = ("where", "frozen", "streams")  # these tell the waits for flash apart
PICO_PARTS = ("pulses", "timer", "queries", "status", "stops", "links", "gcode", "streams", "where", "boot", "frozen")
PARTS = {
    "ways": measure_ways, "lines": measure_lines, "fuzz": measure_fuzz, "motion": measure_motion, "arcs": measure_arcs,
    **{part: _on_the_pico(part) for part in PICO_PARTS},
}  # fmt: skip
LONG = ("motion", "arcs")


def markdown_table(header, rows):
    """Return a table for the document: text to the left, figures to the right."""
    text = [f"| {' | '.join(str(cell) for cell in row)} |" for row in [header, ["---", *["---:"] * (len(header) - 1)],
                                                                        *rows]]
    return "\n".join(text)


def replace_part(document, part, table):
    """Return `document` with the part between `<!-- bench:PART -->` and `<!-- /bench:PART -->` replaced."""
    pattern = re.compile(rf"(<!-- bench:{part} -->\n).*?(<!-- /bench:{part} -->)", re.DOTALL)
    if not pattern.search(document):
        raise Failure(f"{DOCUMENT.name} has no place for the bench {part!r}")
    return pattern.sub(lambda found: f"{found[1]}{table}\n{found[2]}", document)


def date_part(document, part, measured):
    """Return `document` with the line below this part that says when it was measured."""
    pattern = re.compile(rf"(<!-- /bench:{part} -->\n)(?:\nMeasured [^\n]*\n)?")
    return pattern.sub(lambda found: f"{found[1]}\nMeasured {measured}.\n", document)


def now_text():
    """Return the day and the commit that is measured, if this is a clone of the repository."""
    day = time.strftime("on %Y-%m-%d")
    try:
        done = subprocess.run(["git", "rev-parse", "--short=8", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    except OSError:  # without git
        return day
    return day if done.returncode else f"{day} at {done.stdout.strip()}"


def print_table(title, header, rows):
    """Print a table on the console: the first column to the left, the others to the right."""
    from rich.console import Console
    from rich.table import Column, Table

    table = Table(*[Column(head, justify="right" if index else "left") for index, head in enumerate(header)],
                  title=title)
    for row in rows:
        table.add_row(*(str(cell) for cell in row))
    Console().print(table)


def main(wanted):
    """Measure the parts `wanted`, by default all but the LONG ones, and write their tables to DOCUMENT. Raises Failure if there is no bench of a
    name, and behind the last part if one failed; a part that is Unavailable is reported and left out."""
    wanted = list(wanted)
    if "--elf" in wanted:
        at = wanted.index("--elf")
        os.environ["PASSO_ELF"] = "".join(wanted[at + 1 : at + 2])
        del wanted[at : at + 2]
    if wanted[:1] == ["--raw"]:
        return _print_raw(wanted[1])
    if "pico" in wanted:
        wanted[wanted.index("pico") : wanted.index("pico") + 1] = PICO_PARTS
    unknown = set(wanted) - set(PARTS)
    if unknown:
        raise Failure(f"no bench {', '.join(sorted(unknown))}; there are {', '.join(PARTS)}")
    failed = []
    for part in wanted or [part for part in PARTS if part not in LONG]:
        begun, measured = time.monotonic(), now_text()
        try:
            header, rows = PARTS[part]()
        except Unavailable as reason:
            print(f"NOT MEASURED: {part}: {reason}", file=sys.stderr)
            continue
        except Failure as reason:  # the others are measured all the same
            print(f"FAILED: {part}: {reason}", file=sys.stderr)
            failed.append(part)
            continue
        print_table(f"{part} ({time.monotonic() - begun:.0f} s)", header, rows)
        document = replace_part(DOCUMENT.read_text(encoding="utf-8"), part, markdown_table(header, rows))
        DOCUMENT.write_text(summarise(date_part(document, part, measured)), encoding="utf-8")
    print(f"written to {DOCUMENT.relative_to(ROOT)}")
    if failed:
        raise Failure(f"failed: {', '.join(failed)}")
    return None


def run():
    """Run the command: failures become one line on stderr and an exit status."""
    try:
        main(sys.argv[1:])
    except Failure as failure:
        print(f"bench: {failure}", file=sys.stderr)
        sys.exit(UNAVAILABLE if isinstance(failure, Unavailable) else 1)

"""Row of `passo prove`: golden jobs, whose words the chip has to make as the PC does."""

from host_tools.language import _
from host_tools.prove import board_words
from host_tools.prove.gcode_jobs import all_jobs
from host_tools.prove.row import LEFT_OUT, Row, equality_row, number_text


def digests(proof):
    """Yield a row: the golden jobs of the board's language, run on the chip and here; the digests of their words must be equal."""
    language = proof.raw["links"][0]["protocol"]
    jobs = jobs_of(language)
    if not jobs:
        yield Row("digests", _("golden jobs, words of chip and PC"), _("no golden jobs in the language {}", language), verdict=LEFT_OUT)
        return
    from passo.app import App

    links = {"links": [{key: value for key, value in proof.raw["links"][0].items() if key != "lost"}]}
    wrong, words = [], 0
    order = "carry_out" if language == "grbl" else "draw_packets"
    for name, job in jobs.items():
        proof.begin("words", links, more=("board_words.py",))
        refused = 0
        for part in parts_of(job):
            refused += int(proof.board.exec(f"print({order}(app, port, {part!r}))"))
        there = proof.board.exec("run_until_still(app)\nprint(port.digest(), port.count)").split()
        port = board_words.Words()
        app = App(proof.machine(links), port)
        refused_here = getattr(board_words, order)(app, port, job)
        board_words.run_until_still(app)
        words += port.count
        proof.timings.setdefault("digests", {})[name] = there[0]
        if [*there, refused] != [port.digest(), str(port.count), refused_here]:
            wrong.append(name)
    found = _("{} jobs, {} words", len(jobs), number_text(words))
    if wrong:
        found = _("{} of {} jobs differ: {}", len(wrong), len(jobs), ", ".join(wrong))
    yield equality_row("digests", _("golden jobs, words of chip and PC"), found, not wrong, _("the chip does not make the steps of the PC: a kernel was changed or is damaged; flash it again"))


def jobs_of(language):
    """Return {name: job} of the golden jobs in a language, {} if it has none: lines of a three-axis router, or packets."""
    if language == "grbl":
        return {name: lines for name, (board, lines) in all_jobs().items() if board.startswith("router_3axis") and name != "drilling"}
    if language == "plotter":
        from host_tools.drawings import objects
        from host_tools.programs.drawing_progress import packets_of
        from passo.protocols.plotter.protocol import PACKET

        return {name: parts_of(packets_of([points]), PACKET) for name, points in objects.objects().items()}
    return {}


def parts_of(job, size=24):
    return [job[at : at + size] for at in range(0, len(job), size)]

"""The key `journal`: where a job is, kept in flash. Only loaded if the board file has it."""

from passo.config.board_error import BoardError, want_input

HEAP_KB = 4  # of a Pico with stock MicroPython
RULES = {
    "journal": {
        "every_ms": (int, 1000, 100, 60_000),  # a record is written at least as often while the machine moves
        "power": (str, "", 0, 16),  # the input that is active when the power fails; "": none
    },
}


def check(board):
    """Check languages, chip and the input of the power; add features and port's part. Raises BoardError."""
    additions = board["additions"]
    spoken = [link["protocol"] for link in board["links"]]
    languages = [language for language in ("grbl", "plotter", "pulses") if language in spoken]
    if not languages or "grbl" in languages and len(languages) > 1:
        raise BoardError("journal: links speak grbl, or plotter or pulses, and not both")
    if board["chip"] != "rp2040" and board["chip"] != "rp2350":
        raise BoardError("journal: raw pages of flash are for the RP2040 and RP2350")
    additions.parts["pages"] = "passo.options.journal.port_rp2"
    additions.features["journal"] = "passo.options.journal.control", "JobJournal"
    additions.watchers.append("journal")
    if board["journal"]["power"]:
        want_input(board, "journal.power", board["journal"]["power"])
        additions.features["power_fail"] = "passo.options.journal.control_power", "PowerFail"
        additions.watchers.append("power_fail")
    additions.add_languages("passo.options.journal.language_", languages)

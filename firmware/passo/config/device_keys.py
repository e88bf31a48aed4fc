"""The keys `journal` and `network` of a board file: only boards that have one of them load this. RULES are in the notation of boardfile.py."""

from passo.config.board_error import BoardError, want_input
from passo.config.chip_pins import PIN

RULES = {
    "journal": {
        "every_ms": (int, 1000, 100, 60_000),  # so old at most is what is written while the machine moves
        "power": (str, "", 0, 16),  # the input that is active when the power fails; "": none
    },
    "network": {
        "host": (str, "passo", 1, 32),
        "http_port": (int, 80, 1, 65_535),
        "tcp_port": (int, 23, 1, 65_535),
        "legacy_http": (bool, False, 0, 1),
        "button": (str, "", 0, 16),
        "presence": (str, "", 0, 16),
        "minutes": (int, 10, 1, 60),
        "broker": (str, "", 0, 21),
        "broker_user": (str, "", 0, 40),
        "broker_password": (str, "", 0, 64),
    },
}


def check(board):
    if board["jobs"]:
        from passo.config import job_keys

        job_keys.check(board)
    for key, check_key in _CHECKS:
        if board[key] is not None:
            check_key(board, board[key])
    if board["network"]:
        from passo.config import network_keys  # most boards have none

        network_keys.check(board)


def _check_journal(board, config):
    spoken = [link["protocol"] for link in board["links"]]
    counted = "plotter" in spoken or "pulses" in spoken
    if counted == ("grbl" in spoken):
        raise BoardError("journal: links speak grbl, or plotter or pulses, and not both")
    if board["chip"] != "rp2040" and board["chip"] != "rp2350":
        raise BoardError("journal: raw pages of flash are for the RP2040 and RP2350")
    if config["power"]:
        want_input(board, "journal.power", config["power"])


_CHECKS = (
    ("journal", _check_journal),
)  # fmt: skip

"""The keys `card`, `journal` and `network` of a board file: only boards that have one of them load this. RULES are in the notation of boardfile.py."""

from passo.config.board_error import BoardError, want_input
from passo.config.chip_pins import PIN

RULES = {
    "card": {"spi": (int, 1, 0, 2), "sck": PIN, "mosi": PIN, "miso": PIN, "cs": PIN},
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


def _check_card(board, config):
    if not board["jobs"]:
        raise BoardError("card: it is for stored jobs, and there is no key jobs")
    if board["chip"].startswith("esp32"):
        return
    for key, rest in (("miso", 0), ("sck", 2), ("mosi", 3)):  # RP2040 datasheet 1.4.3
        if config[key] & 3 != rest or config[key] >> 3 & 1 != config["spi"]:
            pins = [str(pin) for pin in range(30) if pin & 3 == rest and pin >> 3 & 1 == config["spi"]]
            raise BoardError("card.%s of SPI %d is on pin %s, not %d" % (key, config["spi"], ", ".join(pins), config[key]))


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
    ("card", _check_card), ("journal", _check_journal),
)  # fmt: skip

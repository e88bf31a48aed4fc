"""The keys `card`, `journal`, `network` and `tool_change` of a board file: only
boards that have one of them load this. RULES are in the notation of boardfile.py."""

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
    "tool_change": {
        "at": (list, ..., 2, 2),  # machine coordinates of X and Y, mm: where tools are changed
        "sensor": (list, ..., 2, 2),  # and where their length is found
        "distance_mm": (int, 30, 1, 1000),  # how far down from Z's top a tool has to touch
        "seek_mm_min": (int, 200, 1, 10_000),
        "locate_mm_min": (int, 25, 1, 1000),
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


def _check_tool_change(board, config):
    if len(board["axes"]) < 3 or not board["homing"] or "z" not in board["homing"]["sensors"]:
        raise BoardError("tool_change: it wants axes x, y, z that home")
    want_input(board, "tool_change", "probe")
    board["additions"].settings = {
        341: ("tool_change_way", 0, 3, 0, 4),
        342: ("tool_change_distance", 3, config["distance_mm"] * 1000, 1000, 1_000_000),
        343: ("tool_change_locate", 3, config["locate_mm_min"] * 1000, 1000, 1_000_000),
        344: ("tool_change_seek", 3, config["seek_mm_min"] * 1000, 1000, 10_000_000),
    }
    for key in ("at", "sensor"):
        for axis in range(2):
            item = board["axes"][axis]
            travel_mm = item["travel_steps"] * 1000 // item["steps_per_m"]
            low, high = (-travel_mm, 0) if item["name"] in board["homing"]["high_end"] else (0, travel_mm)
            if not isinstance(config[key][axis], int) or not low <= config[key][axis] <= high:
                raise BoardError("tool_change.%s: whole mm within %d … %d on %s" % (key, low, high, item["name"]))


_CHECKS = (
    ("card", _check_card), ("journal", _check_journal),
    ("tool_change", _check_tool_change),
)  # fmt: skip

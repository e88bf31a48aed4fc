"""The key `card`: a memory card on SPI, which keeps stored jobs. Only loaded if the board file has it."""

from passo.config.board_error import BoardError
from passo.config.chip_pins import PIN

SHARES = ("jobs",)
RULES = {
    "card": {"spi": (int, 1, 0, 2), "sck": PIN, "mosi": PIN, "miso": PIN, "cs": PIN},
}


def claims(board):
    """Return the pins of the card: [(pin, who)]."""
    return [(board["card"][key], "input of the card" if key == "miso" else "card " + key) for key in ("sck", "mosi", "miso", "cs")]


def check(board):
    """Check the card's pins against its SPI; add the feature. Raises BoardError."""
    config = board["card"]
    if not board.get("jobs"):
        raise BoardError("card: it is for stored jobs, and there is no key jobs")
    board["additions"].features["jobs"] = "passo.options.card.control", "Jobs"
    if board["chip"].startswith("esp32"):
        return
    for key, rest in (("miso", 0), ("sck", 2), ("mosi", 3)):  # RP2040 datasheet 1.4.3
        if config[key] & 3 != rest or config[key] >> 3 & 1 != config["spi"]:
            pins = [str(pin) for pin in range(30) if pin & 3 == rest and pin >> 3 & 1 == config["spi"]]
            raise BoardError("card.%s of SPI %d is on pin %s, not %d" % (key, config["spi"], ", ".join(pins), config[key]))

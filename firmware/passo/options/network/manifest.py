"""The key `network`, and links over it. Only loaded if the board file has it."""

from passo.config.board_error import BoardError, want_input
from passo.records import NETWORK_PORTS as PORTS

HEAP_KB = 13  # of a Pico W with stock MicroPython; host_tools/build/budget.py adds its links and a broker
RULES = {
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


def prepare(board):
    """Let links have the ports of a network."""
    board["additions"].ports = PORTS


def check(board):
    """Check host, inputs, links and broker; add the feature and the links' builder. Raises BoardError."""
    config = board["network"]
    for letter in config["host"]:
        if letter not in "abcdefghijklmnopqrstuvwxyz0123456789-":
            raise BoardError("network.host: small letters, digits and - only, not %r" % config["host"])
    for key in ("button", "presence"):
        if config[key]:
            want_input(board, "network." + key, config[key])
    board["additions"].lines = "passo.options.network.builder"
    board["additions"].features["admission"] = "passo.options.network.control", "Admission"
    ports = [link["port"] for link in board["links"] if link["port"] in PORTS]
    if len(set(ports)) != len(ports):
        raise BoardError("network: one link on http, one on page, and one on tcp, at most")
    if board["links"][0]["port"] in PORTS:
        raise BoardError("network: the first link is a cable")
    if config["broker"]:
        _check_broker(config["broker"], ports)
    for link in board["links"]:
        if link["port"] == "http" and link["protocol"] != "torch":
            raise BoardError("link %s: http is for the protocol torch" % link["name"])
        if link["port"] == "tcp" and link["protocol"] != "grbl":
            raise BoardError("link %s: tcp is for the protocol grbl" % link["name"])
        if link["port"] in PORTS and (link["frames"] or link["lost"] != "go_on"):
            raise BoardError("link %s: frames and lost are for cables" % link["name"])


def _check_broker(text, ports):
    """Raise BoardError if `text` is no IPv4 address with or without a port, or there is no link on page."""
    host, _, port = text.partition(":")
    for number, most in [(part, 255) for part in host.split(".")] + [(port or "1883", 65535)]:
        if not number.isdigit() or int(number) > most or host.count(".") != 3:
            raise BoardError("network.broker: an address such as 192.168.1.5, or 192.168.1.5:1884, not %r" % text)
    if "page" not in ports:
        raise BoardError("network.broker: the broker is told what pages are: a link on page is wanted")

"""The key `network` of a board file: only boards that have it load this. RULES are in the notation of boardfile.py."""

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


def check(board):
    if board["network"]:
        from passo.config import network_keys  # most boards have none

        network_keys.check(board)

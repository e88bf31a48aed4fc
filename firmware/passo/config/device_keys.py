"""The keys `card`, `journal`, `network`, `registers` and `tool_change` of a board file: only
boards that have one of them load this. RULES are in the notation of boardfile.py."""

from passo.config.board_error import BoardError, want_input
from passo.config.chip_pins import PIN
from passo.records import REGISTER_BIT

EDGES = {
    "pin": PIN,
    "inputs": (str, ..., 1, 100),  # names of inputs behind 74HC165; the pin is at 1 while one of them is
}
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
    "registers": {
        "clock": PIN,
        "latch": PIN,
        "in": PIN,
        "out": PIN,
        "inputs": (int, 1, 0, 3),  # chips: 74HC165
        "outputs": (int, 1, 0, 3),  # and 74HC595
        "edges": [EDGES, 0, 4],  # pins whose edges have the inputs read at once
        "tool": (int, -1, -1, REGISTER_BIT + 23),  # the output that shows the tool, too; -1: none
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
        if board[key] is not None or key == "registers":
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
    board["settings"] = {  # as an option's, behind 0 Settings puts its value()
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


def _check_registers(board, config):
    """Raise BoardError if two inputs or outputs share a bit, if a bit lies beyond the chips, or if something that has to act at once is on a
    register that the main loop reads. `config`: of the registers; None: there are none."""
    prompt = _prompt(board, config)
    quick = {}  # name of an input: why not
    for name in (board["homing"]["sensors"].values() if board["homing"] else ()):
        quick[name] = "homing's sensor"
    for name in [str(name) for name in (board["interlock"]["limits"].values() if board.get("interlock") else ())]:
        quick[name] = "a limit"
    for key, what in (("inputs", "74HC165"), ("outputs", "74HC595")):
        owners = {}
        if config and key == "outputs" and config["tool"] >= 0:
            owners[config["tool"] - REGISTER_BIT] = "tool"
            if not 0 <= config["tool"] - REGISTER_BIT < 8 * config["outputs"]:
                raise BoardError("registers.tool: %d is no bit of the 74HC595" % config["tool"])
        for item in board[key]:
            bit = item["pin"] - REGISTER_BIT
            if bit < 0:
                if config and key == "inputs" and 23 <= item["pin"] <= 25:
                    raise BoardError("input %s: beside registers it cannot be on pin 23, 24 or 25" % item["name"])
                continue
            if config is None and board.get("shift"):
                continue  # shift_keys.py has looked at it
            if config is None:
                raise BoardError("%s %s: pin %d is a bit of a register; there is none" % (key[:-1], item["name"], item["pin"]))
            if bit >= 8 * config[key]:
                found = key[:-1], item["name"], key, 8 * config[key], REGISTER_BIT, REGISTER_BIT + 8 * config[key] - 1, item["pin"]
                raise BoardError("%s %s: registers.%s has %d bits, pins %d … %d, not %d" % found)
            if bit in owners:
                raise BoardError("bit %d of the %s is claimed by %s and by %s" % (bit, what, owners[bit], item["name"]))
            owners[bit] = item["name"]
            if item.get("halt"):
                raise BoardError("input %s: one that halts needs a pin of its own" % item["name"])
            if item["name"] in quick and key == "inputs" and item["name"] not in prompt:
                raise BoardError("input %s: %s needs a pin of its own, or one of registers.edges" % (item["name"], quick[item["name"]]))
            if item.get("role", "none") != "none":
                raise BoardError("output %s: a relay of the change-over needs a pin of its own" % item["name"])


def _prompt(board, config):
    """Names of the inputs behind registers that have these read at once."""
    names = []
    behind = [item["name"] for item in board["inputs"] if item["pin"] >= REGISTER_BIT]
    for item in config["edges"] if config else ():
        if 23 <= item["pin"] <= 25:
            raise BoardError("registers.edges: none can be on pin 23, 24 or 25")
        for name in item["inputs"].split():
            if name not in behind:
                raise BoardError("registers.edges: %r is no input behind a 74HC165" % name)
            names.append(name)
    return names


_CHECKS = (
    ("card", _check_card), ("journal", _check_journal), ("registers", _check_registers),
    ("tool_change", _check_tool_change),
)  # fmt: skip

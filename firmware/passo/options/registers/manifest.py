"""The key `registers`: inputs and outputs behind shift registers. Only loaded if the board file has it."""

from passo.config.board_error import BoardError
from passo.config.chip_pins import PIN
from passo.records import REGISTER_BIT

_EDGES = {
    "pin": PIN,
    "inputs": (str, ..., 1, 100),  # names of inputs behind 74HC165; the pin is at 1 while one of them is
}
HEAP_KB = 2  # of a Pico with stock MicroPython
RULES = {
    "registers": {
        "clock": PIN,
        "latch": PIN,
        "in": PIN,
        "out": PIN,
        "inputs": (int, 1, 0, 3),  # chips: 74HC165
        "outputs": (int, 1, 0, 3),  # and 74HC595
        "edges": [_EDGES, 0, 4],  # pins whose edges have the inputs read at once
        "tool": (int, -1, -1, REGISTER_BIT + 23),  # the output that shows the tool, too; -1: none
    },
}


def claims(board):
    """Return the pins of the chains and of their edges: [(pin, who)]."""
    config = board["registers"]
    pins = [(config[key], "input of the registers" if key == "in" else "registers' " + key) for key in ("clock", "latch", "in", "out")]
    return pins + [(item["pin"], "input of the registers' edges of " + item["inputs"]) for item in config["edges"]]


def check(board):
    """Raise BoardError if two inputs or outputs share a bit, if a bit lies beyond the chips, or if something that has to act at once is on a
    register that the main loop reads."""
    config = board["registers"]
    prompt = _prompt_inputs(board, config)
    quick = {}  # name of an input: why not
    for name in (board["homing"]["sensors"].values() if board["homing"] else ()):
        quick[name] = "homing's sensor"
    for name in [str(name) for name in (board["additions"].limits or {}).values()]:
        quick[name] = "a limit"
    for key, what in (("inputs", "74HC165"), ("outputs", "74HC595")):
        owners = {}
        if key == "outputs" and config["tool"] >= 0:
            owners[config["tool"] - REGISTER_BIT] = "tool"
            if not 0 <= config["tool"] - REGISTER_BIT < 8 * config["outputs"]:
                raise BoardError("registers.tool: %d is no bit of the 74HC595" % config["tool"])
        for item in board[key]:
            bit = item["pin"] - REGISTER_BIT
            if bit < 0:
                if key == "inputs" and 23 <= item["pin"] <= 25:
                    raise BoardError("input %s: beside registers it cannot be on pin 23, 24 or 25" % item["name"])
                continue
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
    board["additions"].parts["bank"] = "passo.options.registers.port" + ("_rp2" if board["chip"].startswith("rp2") else "")


def _prompt_inputs(board, config):
    """Return the names of the inputs behind registers that registers.edges has read at once. Raises BoardError."""
    names = []
    behind = [item["name"] for item in board["inputs"] if item["pin"] >= REGISTER_BIT]
    for item in config["edges"]:
        if 23 <= item["pin"] <= 25:
            raise BoardError("registers.edges: none can be on pin 23, 24 or 25")
        for name in item["inputs"].split():
            if name not in behind:
                raise BoardError("registers.edges: %r is no input behind a 74HC165" % name)
            names.append(name)
    return names

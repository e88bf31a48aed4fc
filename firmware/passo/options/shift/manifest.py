"""The key `shift`: motors, tool and outputs on 74HC595 shift registers. Only loaded if the board file has it.

Pin 100 of such a board is the first output of the register: QA of the chip whose SER is on `data`; 108 is QA of the next.
"""

from passo.config.board_error import BoardError
from passo.config.chip_pins import PIN
from passo.config.setting_numbers import PULSE_US, STEP_INVERT, longest_pulse_us
from passo.records import REGISTER_BIT

OUTPUTS = 15  # the 16th would follow the others a frame later
FRAME_US = 4
CHIPS = ("esp32", "esp32s3")  # I2S, and a pulse counter to count frames with

RULES = {
    "shift": {"clock": PIN, "latch": PIN, "data": PIN, "enable": (int, -1, -1, 48)},
}


def extend(rules):
    """The tool and outputs may be on the register."""
    last = REGISTER_BIT + OUTPUTS - 1
    rules["tool"] = dict(rules["tool"], pin=(int, ..., 0, last))
    for key, most in (("inputs", 48), ("outputs", last)):
        section, least, longest = rules[key]
        rules[key] = [dict(section, pin=(int, ..., 0, most)), least, longest]


def has_bit(pin):
    """Return True for a pin that is an output of the register."""
    return isinstance(pin, int) and REGISTER_BIT <= pin < REGISTER_BIT + OUTPUTS


def prepare(board):
    """Refuse a board that cannot be shifted, or would step or switch the tool on in a frame of zeros: the chip sends one by itself if it
    gets no more frames.
    """
    if board["chip"] not in CHIPS:
        raise BoardError("shift: an %s cannot; %s can" % (board["chip"], " and ".join(CHIPS)))
    drive = board["drive"]
    if drive["kind"] != "step_dir":
        raise BoardError("shift: a frame of zeros would drop the coils; drive.kind has to be 'step_dir'")
    if board.get("gantry"):
        raise BoardError("shift: no gantry; squaring it steps faster than frames follow")
    for key in ("interlock", "encoders"):
        if board.get(key):
            raise BoardError("shift: no %s yet; frames already on their way would not obey it" % key)
    if board.get("registers"):
        raise BoardError("shift: no registers beside it; its own have outputs to spare")
    if not drive["step_active"]:
        raise BoardError("drive.step_active: a frame of zeros would step; it has to be 1 with shift")
    if not board["tool"]["active"]:
        raise BoardError("tool.active: a frame of zeros would switch the tool on; it has to be 1 with shift")
    for axis in board["axes"]:
        for pin in axis["pins"]:
            _want_bit(pin, "axis %s" % axis["name"])
    _want_bit(board["tool"]["pin"], "tool")
    drive["setup_us"] = -(-drive["setup_us"] // FRAME_US) * FRAME_US  # whole frames: rounding shortens nothing
    board["additions"].parts["bank"] = "passo.options.shift.port_esp32"
    longest_us = longest_pulse_us(board) // FRAME_US * FRAME_US
    board["additions"].settings.update({  # with others the board would not start any more
        PULSE_US: ("step_pulse_us", 0, drive["pulse_us"], 3, longest_us),
        STEP_INVERT: ("step_invert", 0, 0, 0, 0),
    })  # fmt: skip


def claims(board):
    """Return the pins of the register, and the outputs on it: [(pin, who)]."""
    section = board["shift"]
    pins = [(section[key], "shift.%s" % key) for key in ("clock", "latch", "data")]
    pins += [(item["pin"], "output %s" % item["name"]) for item in board["outputs"] if has_bit(item["pin"])]
    return pins + ([(section["enable"], "shift.enable")] if section["enable"] >= 0 else [])


def _want_bit(pin, who):
    """Raise BoardError unless `pin` is an output of the register; `who`: for the text."""
    if not has_bit(pin):
        last = REGISTER_BIT + OUTPUTS - 1
        raise BoardError("%s: with shift it is on an output of the register, %d … %d, not %r" % (who, REGISTER_BIT, last, pin))

"""Checks a board file on load: every key known, of its type and within its bounds, every pin claimed once.

    board = check(BOARD)     # a new dict with the defaults filled in; BoardError names the key and what would be right

The table below is the whole format. A rule is (type, default, least, most); a default of ... means that the key must
be there. `least` and `most` bound a number, or the length of a text or list.
"""

from passo.config.board_error import Additions, BoardError, check_shape, folders, nearest, own_rules, rewritten, want_input
from passo.config.chip_pins import PIN, check_link, check_pin
from passo.records import REGISTER_BIT
from passo.steps.wiring import word_pins

MUST = ...
_PIN_OR_BIT = (int, MUST, 0, REGISTER_BIT + 23)
_PINS = (list, MUST, 1, 6)
_BIT = (int, 1, 0, 1)

_INPUT = {
    "name": (str, MUST, 1, 16),
    "pin": _PIN_OR_BIT,
    "active": _BIT,
    "pull": ("up", "down", "none"),
    "halt": (bool, False, 0, 1),  # becoming active stops the machine at once: emergency stop, limit switch
    "filter_us": (int, 0, 0, 2000),  # a shorter change is noise
}
_OUTPUT = {"name": (str, MUST, 1, 16), "pin": _PIN_OR_BIT, "active": _BIT, "role": ("none", "ours", "theirs")}  # changeover.py's
_AXIS = {
    "name": (str, MUST, 1, 1),
    "pins": _PINS,  # coil drives: the coils in the drive's order; STEP/DIR: [STEP, DIR]
    "steps_per_m": (int, MUST, 1, 100_000_000),
    "travel_steps": (int, MUST, 1, 2_000_000),
    "reversed": (bool, False, 0, 1),
    "max_mm_min": (int, 6000, 1, 900_000),
    "accel_mm_s2": (int, 500, 1, 900_000),
    "jog_steps": (int, 0, 0, 10_000_000),  # of one jog; 0: jog.steps
    "jog_steps_s": (int, 0, 0, 1_000_000),  # its speed; 0: speed.default
}
_DRIVE = {
    "kind": ("step_dir",),  # and those of options: coils that the board itself switches
    "mode": (str, "half", 4, 7),  # how these step
    "pulse_us": (int, 2, 1, 100),
    "setup_us": (int, 5, 0, 1000),
    "step_active": _BIT,
    "hold_ms": (int, 100, 0, 60_000),  # after which the standstill current is enough
}
_TOOL = {
    "pin": PIN,
    "active": _BIT,
    "on_ms": (int, 0, 0, 60_000),  # time until a tool that is switched on takes effect: a pen, a spindle after M3
    "off_ms": (int, 0, 0, 10_000),
}
_HOMING = {
    "sensors": (dict, MUST, 1, 4),
    "seek_steps_s": (int, MUST, 1, 100_000),
    "locate_steps_s": (int, MUST, 1, 10_000),
    "pull_off_steps": (int, MUST, 1, 10_000),
    "debounce_ms": (int, 5, 0, 100),
    "required": (bool, False, 0, 1),
    # Names of the axes, first to last; "": as the board file has them. With a blank in it, those between two blanks at once.
    "order": (str, "", 0, 8),
    "each": (dict, {}, 0, 4),  # by axis: seek_steps_s, locate_steps_s, pull_off_steps, distance_steps (of the search) of its own
    "latch": (bool, False, 0, 1),  # homing can be judged
    "high_end": (str, "", 0, 4),  # names of the axes that home at the positive end of their travel
}
_EACH = ("seek_steps_s", "locate_steps_s", "pull_off_steps")
_PLANNING = {"junction_um": (int, 10, 0, 10_000), "arc_um": (int, 2, 0, 10_000), "independent_ramps": (bool, False, 0, 1),
             "s_curves": (bool, False, 0, 1)}  # fmt: skip
_SPINDLE = {
    "max_rpm": (int, 1000, 1, 900_000),
    "min_rpm": (int, 0, 0, 900_000),
    "pwm": (bool, False, 0, 1),  # the tool takes any power, not just on and off, by a signal of its own:
    "pin": (int, -1, -1, 48),
    "pwm_hz": (int, 5000, 10, 100_000),
    "laser": (bool, False, 0, 1),
    # If the door, or the operator in a hold, has switched them off: the machine waits this long after they are on again.
    "spin_up_ms": (int, 4000, 0, 60_000),  # not for lasers
    "coolant_ms": (int, 1000, 0, 60_000),
}
_SPEED = {
    "unit": ("steps_per_s", "half_period_us"),
    "default": (int, MUST, 1, 1_000_000),
    "min": (int, MUST, 1, 1_000_000),
    "max": (int, MUST, 1, 1_000_000),
    "overhead_us": (int, 0, 0, 10_000),
}
_JOG = {
    "steps": (int, 10, 1, 100_000),
    "up": ("y+", "y-", "x+", "x-"),
    "ahead_ms": (int, 100, 10, 10_000),  # of motion that repeated jogs may ask for in advance: how long it goes on after them
}
_LINK = {
    "name": (str, MUST, 1, 16),
    "port": (str, MUST, 1, 16),
    "tx": (int, 0, 0, 48),
    "rx": (int, 1, 0, 48),
    "baud": (int, 115_200, 300, 1_000_000),
    "protocol": (str, MUST, 1, 16),
    "idle_gap_ms": (int, 5, 1, 1000),
    "frames": (bool, False, 0, 1),  # a host may ask for frames that prove themselves: protocols/frames
    "lost": ("go_on", "pause", "stop", "retract"),  # the machine's action if the host is silent for lost_ms while its job is under way
    "lost_ms": (int, 3000, 100, 600_000),
    "tell_end": (bool, False, 0, 1),  # say unasked that a motion has ended, where the language has a word for it
}
_BOARD = {
    "name": (str, MUST, 1, 32),
    "chip": ("rp2040", "rp2350", "esp32", "esp32s2", "esp32s3", "esp32c3", "esp32c6"),
    "clock_mhz": (int, 0, 0, 400),  # rp2 chips: one of CLOCKS_MHZ; 0: its first
    "psram": (bool, False, 0, 1),  # ESP32: the module has it
    "player": ("pio",),  # rp2 chips: PIO wants consecutive pins; and those of options
    "drive": _DRIVE,
    "axes": [_AXIS, 1, 4],
    "tool": _TOOL,
    "inputs": [_INPUT, 0, 24],
    "outputs": [_OUTPUT, 0, 16],
    "homing": _HOMING,
    "speed": _SPEED,
    "planning": _PLANNING,
    "spindle": _SPINDLE,
    "jog": _JOG,
    "changeover_by": ("command", "motion"),  # the event that takes the motors from the other controller
    "changeover_ms": (int, 20, 0, 10_000),  # between releasing the relays of one controller and closing the other's
    "idle_release_ms": (int, 5000, 0, 3_600_000),  # 0: never
    "store_points": (int, 3000, 10, 100_000),
    "links": [_LINK, 1, 4],
    "commands": (str, "", 0, 16),  # the link that may command at the start; "": the first
}
_WHOLE = "the board file"
_ABSENT = ("homing",)  # None if not there
_OPTIONAL = _ABSENT + ("jog", "planning", "spindle")
CLOCKS_MHZ = {"rp2040": (125, 150, 200), "rp2350": (150,)}  # whole cycles a tick, and USB's 48 MHz stay as they are
MOST_BITS = 13  # of a word's levels, so that 10 ms of ticks fit above them below 2³⁰


def check(board):
    """Return the board with its defaults. Raises BoardError at the first thing wrong."""
    check_shape(board)
    _want_dict(_WHOLE, board)
    before = board.get("additions")  # an Additions of a board that was checked before: its options add all anew
    # None asks for no option.
    board = {key: value for key, value in board.items() if (value is not None or key in _BOARD) and not isinstance(value, Additions)}
    rules = dict(_BOARD)
    own = own_rules(board, rules)
    board, levels = rewritten(board, own)
    _call_each(own, "extend", rules)
    board = _check_section(_WHOLE, board, rules)
    if own:
        board["additions"] = Additions(before)
    if levels:
        board["additions"].levels = levels
    _check_clock(board)
    _call_each(own, "prepare", board)
    _check_pins(board, own)
    _check_order(board)
    _check_homing(board)
    _check_links(board)
    _call_each(own, "check", board)
    _check_bits(board)
    _check_filters(board)
    speed = board["speed"]
    if not speed["min"] <= speed["default"] <= speed["max"]:
        raise BoardError("speed.default: %(default)d is not between %(min)d and %(max)d" % speed)
    return board


def _call_each(manifests, name, what):
    """Call this function of each manifest that has it. `what`: the board, or the rules."""
    for module in manifests:
        if hasattr(module, name):
            getattr(module, name)(what)


def _want_dict(where, data):
    """Raise BoardError if `data` is no dict. `where`: the key, for the message."""
    if not isinstance(data, dict):
        raise BoardError("%s: a dict is wanted, not %r" % (where, data))


def _check_section(where, data, rules):
    """Return a section with its defaults. Raises BoardError at an unknown key or a wrong value."""
    _want_dict(where, data)
    for key in data:
        if key not in rules:
            known = sorted(set(rules) | set(folders("passo.options") if where is _WHOLE else ()))
            raise BoardError("%s: unknown key %r%s; known are %s" % (where, key, nearest(key, known), ", ".join(known)))
    prefix = "" if where is _WHOLE else where + "."
    return {key: _check_value(prefix + key, data, key, rule) for key, rule in rules.items()}


def _check_value(where, data, key, rule):
    """Return data[key], or its default, checked by `rule`. Raises BoardError."""
    if isinstance(rule, dict):
        part = data.get(key)
        if part is None and key not in _OPTIONAL:
            raise BoardError("%s: missing" % where)
        if part is None and key in _ABSENT:
            return None
        return _check_section(where, part or {}, rule)
    if isinstance(rule, list):
        return _check_list(where, data, key, rule)
    if isinstance(rule[0], str):
        value = data.get(key, rule[0])
        if value not in rule:
            raise BoardError("%s: %r is none of %s" % (where, value, ", ".join(rule)))
        return value
    kind, default, least, most = rule
    value = data.get(key, default)
    if value is MUST:
        raise BoardError("%s: missing" % where)
    if not isinstance(value, kind) or kind is int and isinstance(value, bool):
        raise BoardError("%s: %r is no %s" % (where, value, kind.__name__))
    if kind is dict and [name for name in value if not isinstance(name, str)]:
        raise BoardError("%s: names are wanted" % where)
    size = value if kind in (int, bool) else len(value)
    if not least <= size <= most:
        what = "" if kind is int else "of length %d " % size
        raise BoardError("%s: %r %sis not within %d … %d" % (where, value, what, least, most))
    return dict(value) if kind is dict else value  # a copy: check() may add to it


def _check_list(where, data, key, rule):
    """Return a list of sections, each checked. `rule`: [rules, least, most]. Raises BoardError."""
    section, least, most = rule
    items = data.get(key, [])
    if not isinstance(items, (list, tuple)) or not least <= len(items) <= most:
        raise BoardError("%s: a list of %d … %d is wanted" % (where, least, most))
    return [_check_section("%s[%d]" % (where, i), items[i], section) for i in range(len(items))]


def _check_clock(board):
    """Set clock_mhz to the chip's first clock if it is 0. Raises BoardError at one that the chip does not have."""
    chip = board["chip"]
    clocks = CLOCKS_MHZ.get(chip, (0,))
    board["clock_mhz"] = board["clock_mhz"] or clocks[0]
    if board["clock_mhz"] not in clocks:
        if clocks == (0,):
            raise BoardError("clock_mhz: the clock of an %s is not set here; leave it out" % chip)
        raise BoardError("clock_mhz: an %s runs at %s here, not %d" % (chip, " or ".join([str(mhz) for mhz in clocks]), board["clock_mhz"]))


def pin_claims(board, own=None):
    """Return [(pin, who)] of everything that claims a pin, a serial port's two included. A name begins with "input" or ends in " rx" if the chip only
    reads the pin. `own`: the manifests of the board's options; by default they are loaded."""
    claims = [(pin, "axis %s" % axis["name"]) for axis in board["axes"] for pin in axis["pins"]]
    claims.append((board["tool"]["pin"], "tool"))
    if board["spindle"]["pwm"]:
        claims.append((board["spindle"]["pin"], "spindle's power"))
    for what in ("input", "output"):
        claims += [(item["pin"], "%s %s" % (what, item["name"])) for item in board[what + "s"] if item["pin"] < REGISTER_BIT]
    for module in own_rules({key: value for key, value in board.items() if value}, {}) if own is None else own:
        if hasattr(module, "claims"):
            claims += module.claims(board)
    for link in board["links"]:
        if link["port"].startswith("uart"):
            claims += [(link[key], "link %s %s" % (link["name"], key)) for key in ("tx", "rx")]
    return claims


def _check_pins(board, own):
    """Raise BoardError if a pin is claimed twice, or the chip has none such, or a drive has the wrong number of pins."""
    kind = board["drive"]["kind"]
    pins_of = getattr(board.get("additions"), "motor_pins", 2)
    most = (MOST_BITS - 1) // pins_of - len(getattr(board.get("additions"), "more_motors", ()))
    if len(board["axes"]) > most:
        raise BoardError("axes: %d are too many for a %s drive; it moves %d" % (len(board["axes"]), kind, most))
    for axis in board["axes"]:
        if len(axis["pins"]) != pins_of:
            raise BoardError("axis %s: a %s drive has %d pins, not %d" % (axis["name"], kind, pins_of, len(axis["pins"])))
    owners = {}
    for pin, who in pin_claims(board, own):
        outside = any([module.has_bit(pin) for module in own if hasattr(module, "has_bit")])
        if not outside and (not isinstance(pin, int) or not 0 <= pin <= 48):
            raise BoardError("%s: %r is no pin number" % (who, pin))
        if pin in owners:
            raise BoardError("pin %d is claimed by %s and by %s" % (pin, owners[pin], who))
        owners[pin] = who
        if outside:
            continue
        check_pin(board["chip"], pin, who, not who.startswith("input") and who[-3:] != " rx")
    for item in board["inputs"]:
        if item["pull"] == "down" and board["chip"] == "rp2350" and item["pin"] < REGISTER_BIT:
            raise BoardError("input %s: an rp2350 may hold a pin up by its own pull-down (erratum E9); 4.7 kΩ to GND, and 'pull': 'none'" % item["name"])
    for link in board["links"]:
        check_link(board["chip"], link, getattr(board.get("additions"), "ports", ()))


def _check_order(board):
    """Raise BoardError if PIO pins are not consecutive, in the order of a word's bits."""
    if board["chip"].startswith("esp32") or board["player"] != "pio":
        return
    pins = word_pins(board)
    if pins != list(range(pins[0], pins[0] + len(pins))):
        order = "all STEPs, all DIRs, tool" if board["drive"]["kind"] == "step_dir" else "the axes' coils in order, tool"
        raise BoardError("PIO pins not consecutive: %s must be on neighbouring pins, not %s; or set player to 'timer'" % (order, pins))


def _check_links(board):
    """Raise BoardError at a link's name that is there twice, or one unknown in "commands"."""
    names = [link["name"] for link in board["links"]]
    if len(set(names)) != len(names):
        raise BoardError("links: every name once, not %s" % ", ".join(names))
    if board["commands"] and board["commands"] not in names:
        raise BoardError("commands: there is no link %r; known are %s" % (board["commands"], ", ".join(names)))


def _check_bits(board):
    """Raise BoardError if an input or output is a bit of a register and the board has none."""
    if "bank" not in getattr(board.get("additions"), "parts", ()):
        for key in ("inputs", "outputs"):
            for item in board[key]:
                if item["pin"] >= REGISTER_BIT:
                    raise BoardError("%s %s: pin %d is a bit of a register; there is none" % (key[:-1], item["name"], item["pin"]))


def _check_filters(board):
    """Raise BoardError if an input has filter_us that halts the machine, or that is no limit. The interlock has a filter of its own."""
    if "veto" in getattr(board.get("additions"), "parts", ()):  # which filters inputs of its own
        return
    sensors = list(board["homing"]["sensors"].values()) if board["homing"] else []
    for item in board["inputs"]:
        if item["filter_us"] and (item["halt"] or item["name"] not in sensors and item["name"][:6] != "limit_"):
            raise BoardError("input %s: filter_us is for limits and inputs of the interlock that do not halt" % item["name"])


def _check_homing(board):
    """Raise BoardError if a key of homing names an axis or input that is not there, or a value is out of bounds."""
    homing = board["homing"]
    if homing is None:
        return
    axes = [axis["name"] for axis in board["axes"]]
    for axis, sensor in homing["sensors"].items():
        if axis not in axes:
            raise BoardError("homing.sensors: there is no axis %r" % axis)
        want_input(board, "homing.sensors." + axis, sensor)
    for key in ("order", "high_end"):
        for axis in homing[key].replace(" ", ""):
            if axis not in homing["sensors"]:
                raise BoardError("homing.%s: axis %r has no sensor" % (key, axis))
    order = homing["order"].replace(" ", "")
    if order and not len(order) == len(set(order)) == len(homing["sensors"]):
        raise BoardError("homing.order: every axis with a sensor once, not %r" % homing["order"])
    for axis, own in homing["each"].items():
        if axis not in homing["sensors"] or not isinstance(own, dict):
            raise BoardError("homing.each: %r has no sensor, or no dict" % axis)
        for key, value in own.items():
            most = 10_000_000 if key == "distance_steps" else _HOMING[key][3] if key in _EACH else 0
            if not most:
                raise BoardError("homing.each.%s: unknown key %r; known are distance_steps, %s" % (axis, key, ", ".join(_EACH)))
            if not isinstance(value, int) or not 1 <= value <= most:
                raise BoardError("homing.each.%s.%s: %r is not within 1 … %d" % (axis, key, value, most))

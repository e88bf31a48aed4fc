"""The key `drivers`: TMC2209 or TMC2226 drivers that are set up over a UART; and what `spi_drivers` shares with it. Only loaded if the board
file has one of them."""

from passo.config.board_error import BoardError
from passo.config.chip_pins import PIN, check_link
from passo.options.drivers.config import current_scale

_DRIVER = {
    "axis": (str, ..., 1, 1),
    "address": (int, ..., 0, 3),  # as its pins MS1 and MS2 say: MS1 + 2 · MS2
    "current_ma": (int, ..., 50, 2000),  # of a coil, RMS
    "hold_percent": (int, 50, 0, 100),  # of it, at rest
    "microsteps": (int, 16, 1, 256),
    "stealth": (bool, True, 0, 1),  # stealthChop; False: spreadCycle
    "stall": (int, 0, 0, 255),  # its axis homes by stall: half the SG_RESULT below which it has; 0: it does not
    "stall_ma": (int, 0, 0, 2000),  # meanwhile; 0: current_ma
}
RULES = {
    "drivers": {
        "port": (str, ..., 5, 5),
        "tx": PIN,
        "rx": PIN,
        "baud": (int, 115_200, 9600, 500_000),
        "sense_mohm": (int, 110, 10, 1000),  # the resistors beside each driver
        "motors": [_DRIVER, 1, 4],
    },
}


def claims(board):
    """Return the pins of the UART: [(pin, who)]."""
    return [(board["drivers"][key], "drivers " + key) for key in ("tx", "rx")]


def check(board):
    """Check port, pins, drivers and stall homing; add the features. Raises BoardError."""
    config = board["drivers"]
    want_step_dir(board)
    taken = [(link["port"], "link " + link["name"]) for link in board["links"]]
    if board.get("inverter"):
        taken.append((board["inverter"]["port"], "the inverter"))
    for port, who in taken:
        if port == config["port"]:
            raise BoardError("drivers: %s belongs to %s; take another" % (port, who))
    check_link(board["chip"], dict(config, name="drivers"))
    check_motors(board, "drivers", ("axis", "address"), lambda current_ma: current_scale(current_ma, config["sense_mohm"]))
    feel = [motor for motor in config["motors"] if motor["stall"]]
    if feel:
        check_stalls(board, feel, "drivers")
    board["additions"].features["drives"] = "passo.options.drivers." + ("control_stall" if feel else "control"), "Motors"


def want_step_dir(board):
    """Raise BoardError unless the drive is STEP/DIR."""
    if board["drive"]["kind"] != "step_dir":
        raise BoardError("drivers: they want a step_dir drive")


def check_motors(board, key, unique, current_scale):
    """Check the drivers of section `key`. `unique`: keys whose values differ from driver to driver; current_scale(mA) returns None for a current that
    is too high. Raises BoardError."""
    config = board["additions"].drives = board[key]
    names = [axis["name"] for axis in board["axes"]]
    for each in unique:
        found = [motor[each] for motor in config["motors"]]
        if len(set(found)) != len(found):
            raise BoardError("drivers.motors: every %s once, not %r" % (each, found))
    for motor in config["motors"]:
        where = "%s.motors, %s" % (key, motor["axis"])
        if motor["axis"] not in names:
            raise BoardError("%s: there is no such axis" % where)
        if motor["microsteps"] & motor["microsteps"] - 1:
            raise BoardError("%s: microsteps are 1, 2, 4 … 256, not %d" % (where, motor["microsteps"]))
        for current_ma in (motor["current_ma"], motor["stall_ma"]):
            if current_scale(current_ma) is None:
                raise BoardError("%s: %d mA are too much for %d mΩ" % (where, current_ma, config["sense_mohm"]))


def check_stalls(board, feel, key):
    """Have axes home by stall. `feel`: the drivers that do; `key`: that of the board file. Raises BoardError."""
    board["additions"].stalls = "".join([motor["axis"] for motor in feel])
    board["additions"].features["homing"] = "passo.options.drivers.control_stall_homing", "Homing"
    homing = board["homing"]
    names = [motor["axis"] for motor in feel]
    if board.get("kinematics", "none") != "none" and ("x" in names) != ("y" in names):
        raise BoardError("drivers.motors: stall: x and y share two motors: both or none")
    for motor in feel:
        axis = motor["axis"]
        where = "%s.motors, %s: stall" % (key, axis)
        if not homing or axis not in homing["sensors"]:
            raise BoardError("%s: homing.sensors must name the input that its DIAG pin goes to" % where)
        if board.get("interlock") or axis in [motor["name"][0] for motor in board["additions"].more_motors]:
            raise BoardError("%s: not with an interlock, and not of a gantry" % where)
        for group in homing["order"].split() if " " in homing["order"] else ():
            if axis in group and len(group) > 1:
                raise BoardError("%s: homing.order: it homes alone, not with %s" % (where, group))
        pull_off = homing["each"].get(axis, {}).get("pull_off_steps", homing["pull_off_steps"])
        if pull_off < 16 * motor["microsteps"]:
            raise BoardError("%s: its pull_off_steps are %d at least, 16 full steps, not %d" % (where, 16 * motor["microsteps"], pull_off))

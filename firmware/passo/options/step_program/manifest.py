"""The key `step_program`: paths of single steps. Only loaded if the board file has it."""

from passo.config.board_error import BoardError

RULES = {
    "step_program": {
        "interval_us": (int, 100, 1, 250_000),  # the least time between one pulse and the next: it makes the fastest speed
        "default_mm_min": (int, 600, 1, 900_000),  # until the program says otherwise, and for moves by hand
        "cells": (int, 4096, 512, 65_536),  # of memory, four bytes each: a run of equal steps takes one
        "dry_run": (bool, False, 0, 1),  # the tool stays off
        "accel_mm_s2": (int, 0, 0, 900_000),  # `passo pulses ramps` writes speeds into files that accelerate so; 0: none
        # The image of a parallel port in status reports, for its bits 7 to 0 (drives on, z pulse, z dir, y pulse, y dir,
        # x pulse, x dir, tool): the bit each appears at, "-" none; "invert": the mask of those that appear inverted.
        "port_bits": (str, "76543210", 8, 8),
        "port_invert": (int, 0, 0, 255),
    },
}


def rewrite(board):
    """Return (the raw board file, None), or with `port_pins` its pins by the lines of a parallel port, and the masks of its levels. Raises
    BoardError."""
    section = board["step_program"]
    if not isinstance(section, dict) or "port_pins" not in section:
        return board, None
    from passo.options.step_program.manifest_port_pins import apply_pins

    return apply_pins(board)


def check(board):
    """Check steps/m, the interval and the port's bits; add the feature, $181 and $182. Raises BoardError."""
    for axis in board["axes"]:
        if axis["steps_per_m"] < 100:
            raise BoardError("axis %s: a step program wants 100 steps/m or more" % axis["name"])
    config = board["step_program"]
    if board["drive"]["kind"] == "step_dir" and config["interval_us"] < 2 * board["drive"]["pulse_us"]:
        raise BoardError("step_program.interval_us: a pulse of %d µs, and as long without it, take more than %d µs" % (board["drive"]["pulse_us"], config["interval_us"]))
    bits = config["port_bits"].replace("-", "")
    if len(set(bits)) != len(bits) or set(bits) - set("01234567"):
        raise BoardError("step_program.port_bits: each of 0 … 7 once at most, and - for none, not %r" % config["port_bits"])
    rules = {
        181: ("interval_us", 0, config["interval_us"], 1, 250_000),
        182: ("program_speed", 0, config["default_mm_min"], 1, 900_000),
    }
    board["additions"].settings.update(rules)
    board["additions"].features["step_program"] = "passo.options.step_program.control", "StepProgramPlayer"

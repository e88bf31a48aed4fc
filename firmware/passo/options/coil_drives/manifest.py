"""The common part of the manifests of coil drives: no key of a board file. A drive's folder is drive_ and its name in `drive.kind`."""

from passo.config.board_error import BoardError

RULES = {}


def allow_kind(rules, kind):
    """Add `kind` to the values that `drive.kind` may have."""
    rules["drive"] = dict(rules["drive"])
    rules["drive"]["kind"] += (kind,)


def use_drive(board, module, pins):
    """Give each motor `pins` pins; create(board) of `module` returns the drive."""
    board["additions"].drive_module = module
    board["additions"].motor_pins = pins


def check_mode(board, modes):
    """Raise BoardError if `drive.mode` is none of `modes`."""
    drive = board["drive"]
    if drive["mode"] not in modes:
        raise BoardError("drive.mode: %r is none of %s, those of %s" % (drive["mode"], ", ".join(modes), drive["kind"]))

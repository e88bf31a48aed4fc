"""`drive.kind` "pbl3770a": bipolar motors, two PBL3770A each."""

from passo.options.coil_drives.manifest import allow_kind, check_mode, use_drive

SHARES = ("coil_drives",)  # the option whose files it shares
RULES = {}


def extend(rules):
    """Let `drive.kind` be "pbl3770a"."""
    allow_kind(rules, "pbl3770a")


def prepare(board):
    """Give each motor six pins."""
    use_drive(board, "passo.options.drive_pbl3770a.drive", 6)


def check(board):
    """Raise BoardError if `drive.mode` is none of this drive."""
    check_mode(board, ("half", "full", "quarter", "eighth"))

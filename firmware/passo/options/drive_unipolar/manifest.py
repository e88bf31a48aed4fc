"""`drive.kind` "unipolar": unipolar motors, four transistors each."""

from passo.options.coil_drives.manifest import allow_kind, check_mode, use_drive

SHARES = ("coil_drives",)  # the option whose files it shares
RULES = {}


def extend(rules):
    """Let `drive.kind` be "unipolar"."""
    allow_kind(rules, "unipolar")


def prepare(board):
    """Give each motor four pins."""
    use_drive(board, "passo.options.drive_unipolar.drive", 4)


def check(board):
    """Raise BoardError if `drive.mode` is none of this drive."""
    check_mode(board, ("half", "full", "wave"))

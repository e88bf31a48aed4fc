"""`drive.kind` "unipolar": unipolar motors, four transistors each."""

from passo.options.coil_drives.manifest import allow, check_mode, use

SHARES = ("coil_drives",)  # the option whose files it shares
RULES = {}


def extend(rules):
    allow(rules, "unipolar")


def prepare(board):
    use(board, "passo.options.drive_unipolar.drive", 4)


def check(board):
    check_mode(board, ("half", "full", "wave"))

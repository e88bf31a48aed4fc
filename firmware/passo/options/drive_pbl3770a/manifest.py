"""`drive.kind` "pbl3770a": bipolar motors, two PBL3770A each."""

from passo.options.coil_drives.manifest import allow, check_mode, use

SHARES = ("coil_drives",)  # the option whose files it shares
RULES = {}


def extend(rules):
    allow(rules, "pbl3770a")


def prepare(board):
    use(board, "passo.options.drive_pbl3770a.drive", 6)


def check(board):
    check_mode(board, ("half", "full", "quarter", "eighth"))

"""The key `jobs` of a board file: only boards that have it load this. JOBS are its rules, in the notation of boardfile.py."""

from passo.config.board_error import BoardError, want_input

NAME_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-"
LONGEST_NAME = 24
LINK = "job"  # the name of the link that stored jobs come by
JOBS = {
    "language": ("grbl", "plotter", "pulses"),
    "folder": (str, "/jobs", 2, 100),
    "button": (str, "", 0, LONGEST_NAME),  # the job that the input "job" runs
    "start": (str, "", 0, LONGEST_NAME),  # the job that runs when the board is switched on
}


def name_fits(name):
    """True if a job may have this name."""
    return 0 < len(name) <= LONGEST_NAME and name[0] != "." and not [letter for letter in name if letter not in NAME_LETTERS]


def check(board):
    config = board["jobs"]
    if config["language"] not in [link["protocol"] for link in board["links"]]:
        raise BoardError("jobs.language: no link speaks %s" % config["language"])
    if LINK in [link["name"] for link in board["links"]]:
        raise BoardError("links: %r is the link of stored jobs; take another name" % LINK)
    for key in ("button", "start"):
        if config[key] and not name_fits(config[key]):
            raise BoardError("jobs.%s: capitals, digits, '.', '_' and '-', not %r" % (key, config[key]))
    if config["button"]:
        want_input(board, "jobs.button", "job")

"""Names of stored jobs."""

NAME_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-"
LONGEST_NAME = 24
LINK = "job"  # the name of the link that stored jobs come by


def name_fits(name):
    """Return True if a job may have this name."""
    return 0 < len(name) <= LONGEST_NAME and name[0] != "." and not [letter for letter in name if letter not in NAME_LETTERS]

class BoardError(Exception):
    """The board file is wrong: one line that says where, and what would be right."""

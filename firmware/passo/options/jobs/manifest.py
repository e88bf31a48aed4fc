"""The key `jobs`: programs kept on the board, and run without a PC. Only loaded if the board file has it."""

from passo.config.board_error import BoardError, want_input
from passo.options.jobs.commands import JOB
from passo.options.jobs.config_names import LINK, LONGEST_NAME, name_fits

HEAP_KB = 12  # of a Pico with stock MicroPython; host_tools/build/budget.py adds what an upload wants
RULES = {
    "jobs": {
        "language": ("grbl", "plotter", "pulses"),
        "folder": (str, "/jobs", 2, 100),
        "button": (str, "", 0, LONGEST_NAME),  # the job that the input "job" runs
        "start": (str, "", 0, LONGEST_NAME),  # the job that runs when the board is switched on
    },
}


def check(board):
    """Check language and names; add the button, the feature and its link. Raises BoardError."""
    config = board["jobs"]
    additions = board["additions"]
    spoken = [link["protocol"] for link in board["links"]]
    if config["language"] not in spoken:
        raise BoardError("jobs.language: no link speaks %s" % config["language"])
    if LINK in [link["name"] for link in board["links"]]:
        raise BoardError("links: %r is the link of stored jobs; take another name" % LINK)
    for key in ("button", "start"):
        if config[key] and not name_fits(config[key]):
            raise BoardError("jobs.%s: capitals, digits, '.', '_' and '-', not %r" % (key, config[key]))
    if config["button"]:
        want_input(board, "jobs.button", "job")
    additions.named_inputs += (("job", "", JOB, ""),)  # a button
    if "jobs" not in additions.features:
        additions.features["jobs"] = "passo.options.jobs.control", "Jobs"
    additions.file_links.append(("jobs", config["language"]))
    pages = ["page" for link in board["links"] if link["port"] == "page"]
    additions.add_languages("passo.options.jobs.language_", [language for language in RULES["jobs"]["language"] if language in spoken] + pages[:1])

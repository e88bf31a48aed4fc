"""What a board with a network loads, and makes of its links: no other board has it.

    load(board)                     # early, each module after the one that it imports: there is no room for several at once
    serials(board, port)            # the serial line of each link of the board file
    join(links, controller)         # once there are both
"""

from passo.config.board_error import BoardError

_OF_NETWORK = ("websocket", "connection", "session", "guard", "http", "files", "signed", "lines")
_OF_PAGE = ("lease", "jog", "pace", "pages", "api", "any_machine")


def load(board):
    """Import what serials() will ask for. Raises BoardError."""
    try:
        files = __import__("passo_pages").FILES
    except ImportError:  # they are in the file system
        files = None
    if files:
        __import__("vfs").mount(__import__("passo.web.frozen_files", None, None, ("FrozenFiles",)).FrozenFiles(files), "/page")
    for module in _OF_NETWORK:
        __import__("passo.web." + module)
    for link in board["links"]:
        if link["port"] == "page":
            for module in _OF_PAGE:
                __import__("passo.web." + module)
            page_line(board, link["protocol"])


def page_line(board, language):
    """make(server, key, clock_ms): a line that pages speak on, by what speaks a language for them, such as GrblMachine of
    passo/web/grbl_machine.py. Raises BoardError."""
    kind = language[0].upper() + language[1:] + "Machine"
    try:
        line = __import__("passo.web.page_line", None, None, ("PageLine",)).PageLine
        found = getattr(__import__("passo.web." + language + "_machine", None, None, (kind,)), kind)
    except ImportError:
        raise BoardError("network: there is no page for %s on this board" % language)
    jobs = __import__("passo.web.board_jobs", None, None, ("BoardJobs",)).BoardJobs if board["jobs"] else None
    machine = found if language == "grbl" else lambda write, tell: found(write, tell, board)
    return lambda server, key, clock_ms: line(server, machine, key, clock_ms, jobs)


def serials(board, port):
    """The serial line of each link of the board file. Raises BoardError."""
    from passo.web.lines import Radio, make

    radio = port.radio if hasattr(port, "radio") else Radio(board["network"])
    networked = make(board, radio, port.link_ms, page_line)
    return [networked[link["name"]] if link["name"] in networked else port.serial(link) for link in board["links"]]


def join(links, controller):
    """Tell the links over the network whom they serve."""
    for link in links:
        if hasattr(link.serial, "join"):
            link.serial.join(link, controller)

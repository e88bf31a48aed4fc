"""The links of a board with a network: see machine_builder.lines_of().

    load(board)                     # early, each module after the one that it imports: there is no room for several at once
    make_serials(board, port)       # the serial line of each link of the board file
    create(language, link, …)       # its protocol; `language`: a package. A link for pages speaks theirs
    join(links, controller)         # once there are both
"""

from passo.config.board_error import BoardError

_OF_NETWORK = ("websocket", "connection", "session", "guard", "http", "files", "signed", "lines")
_OF_PAGE = ("protocols.page.lease", "protocols.page.jog", "web.pace", "web.pages", "protocols.page.orders", "protocols.page.page_machine", "protocols.page.protocol")


def load(board):
    """Import the modules that make_serials() needs, each behind those that it imports. Raises BoardError."""
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
                __import__("passo." + module)
            _page_class(link["protocol"])


def _page_class(language):
    """Return the class of the machine behind pages for a language, such as GrblPage of passo/protocols/page/grbl.py. Raises BoardError."""
    kind = language[0].upper() + language[1:] + "Page"
    try:
        return getattr(__import__("passo.protocols.page." + language, None, None, (kind,)), kind)
    except ImportError:
        raise BoardError("network: there is no page for %s on this board" % language)


def _page_line():
    """Return the class PageLine, imported now."""
    return __import__("passo.web.page_line", None, None, ("PageLine",)).PageLine


def create(language, link, number, board, controller, shared, most):
    """Return a link's protocol: of the language, or of pages."""
    if link["port"] != "page":
        return language.create(link, number, board, controller, shared, most)
    shown = _page_class(link["protocol"])
    spoken = language.create(link, number, board, controller, shared, most) if shown.speaks else language
    return __import__("passo.protocols.page", None, None, ("create",)).create(shown, number, board, controller, spoken)


def make_serials(board, port):
    """Return the serial line of each link of the board file. Raises BoardError."""
    from passo.web.lines import Radio, make_lines

    radio = port.radio if hasattr(port, "radio") else Radio(board["network"])
    networked = make_lines(board["links"], radio, board["network"]["legacy_http"], port.link_ms, _page_line)
    if board["network"]["broker"]:
        _join_broker(board, networked)
    return [networked[link["name"]] if link["name"] in networked else port.serial(link) for link in board["links"]]


def _join_broker(board, lines):
    """Give the line of pages a client of the broker. Raises BoardError if umqtt is not there."""
    try:
        umqtt = __import__("umqtt.simple", None, None, ("MQTTClient",))
    except ImportError:
        raise BoardError("network.broker: umqtt is not on this board: mpremote mip install umqtt.simple")
    for link in board["links"]:
        line = lines[link["name"]] if link["port"] == "page" else None
        if hasattr(line, "join_broker"):  # else the radio is off
            texts = __import__("passo.error_texts", None, None, ("text",))
            texts.load()  # at the start: an import takes memory in pieces, and time, while the machine moves
            line.join_broker(__import__("passo.web.broker", None, None, ("Broker",)).Broker(board["network"], link["protocol"], line.stop, umqtt, texts.text))


def join(links, controller):
    """Give each networked line its link and the controller."""
    for link in links:
        if hasattr(link.serial, "join"):
            link.serial.join(link, controller)

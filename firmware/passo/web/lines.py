"""Links whose bytes come over the network: to the app they are serial lines.

    lines = make_lines(links, radio, legacy, clock_ms, page_line)     # {name of a link: its line}
    line.join(link, controller)             # once there are both
    line.read(), line.write(data), line.any()

`radio` says where to listen and who belongs to the board's own network: radio.py, or the virtual board's. Without one, or while
the board has no Wi-Fi data, the lines are silent. A link of the port `http` and one of the port `page` share a server.
"""

import sys

from passo.records import NETWORK_PORTS
from passo.web.files import Folder
from passo.web.guard import Guard, make_nonce
from passo.web.http import Server
from passo.web.radio import Radio  # noqa: F401: for modules that make lines
from passo.web.signed import SignedLine

_FROZEN = str(sys.modules["passo"].__path__).startswith(".frozen")  # options/network/builder.py puts the files there
_FOLDER = "/page/" if _FROZEN else __file__[: __file__.rfind("/")] + "/page/" if "/" in __file__ else "page/"


def make_lines(links, radio, legacy, clock_ms, page_line):
    """Make the lines of the links over the network, {name: line}. `links`: of the board file; `legacy`: programs without the key may be admitted;
    `clock_ms()`: the links' clock; `page_line()`: the class of lines for pages."""
    lines = {}
    links = [link for link in links if link["port"] in NETWORK_PORTS]
    listener = radio.listen("http") if radio and [link for link in links if link["port"] != "tcp"] else None
    server = None
    if listener:
        guard = Guard(radio.names, radio.key, make_nonce(), radio.is_own_peer)
        server = Server(listener, Folder(getattr(radio, "folder", _FOLDER)), guard, clock_ms, legacy)
    for link in links:
        name = link["name"]
        lines[name] = Silent()
        if link["port"] == "tcp":
            wired = radio.listen("tcp") if radio else None
            if wired or server:
                lines[name] = SignedLine(wired, radio.key, server)
        elif server and link["port"] == "http":
            lines[name] = server
        elif server:
            lines[name] = page_line()(server, radio.key, clock_ms)
    return lines


class Silent:
    """The radio is off."""

    def any(self):
        return False

    def read(self):
        return b""

    def write(self, data):
        pass

    def select_list(self):
        return []

    def close(self):
        pass

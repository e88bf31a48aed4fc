"""The board's radio: Wi-Fi as an access point or a station, by the file that `passo wifi` writes to the board.

    radio = Radio(config)               # the board file's "network"
    radio.listen("http")                # a socket that listens; None: the radio is off

The file is `wifi.json`: {"mode": "access" or "station", "name": …, "passphrase": …, "key": …}. Without it the radio stays off:
there is no fixed name and no fixed passphrase. The access point is WPA2; 192.168.4.1 is the board.
"""

import json
import socket

from micropython import const

FILE = "wifi.json"
_LEAST = const(8)  # characters of a passphrase: WPA2's bound
_KEY = const(16)  # letters of a key: `passo wifi` makes none that is shorter
_WPA2 = const(4)  # of rp2; an ESP32 has its own name for it
_PORTS = {"http": "http_port", "tcp": "tcp_port"}
_BACKLOG = const(4)


def _count_letters(key):
    """The number of letters in `key` that are of a key's alphabet (host_tools/clients/page_key.py)."""
    return len([code for code in key.encode() if 50 <= code <= 57 or 65 <= code <= 90 and code not in b"IO"])


def read_wifi_file():
    """Return the contents of the file of `passo wifi`, or None if there is none that can be used."""
    try:
        with open(FILE) as file:
            found = json.load(file)
        good = found["mode"] in ("access", "station") and found["name"] and len(found["passphrase"]) >= _LEAST and _count_letters(found["key"]) >= _KEY
        return found if good else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


class Radio:
    def __init__(self, config):
        """`config`: the board file's "network"."""
        self._config = config
        self._wlan = None
        self._access = False
        self.key = None
        self.names = ()
        wanted = read_wifi_file()
        if wanted:
            self._start_radio(wanted)

    def _start_radio(self, wanted):
        """Start the access point, or connect to one, by the contents of wifi.json."""
        import network  # chips without a radio have none

        network.hostname(self._config["host"])  # tells mDNS, too
        self._access = wanted["mode"] == "access"
        self.key = wanted["key"]
        if self._access:
            self._wlan = wlan = network.WLAN(network.AP_IF)
            secure = getattr(network, "AUTH_WPA2_PSK", _WPA2)
            try:
                wlan.config(ssid=wanted["name"], key=wanted["passphrase"], security=secure)
                wlan.active(True)
            except OSError:  # an ESP32's has to be switched on first
                wlan.active(True)
                wlan.config(ssid=wanted["name"], key=wanted["passphrase"], security=secure)
        else:
            self._wlan = wlan = network.WLAN(network.STA_IF)
            wlan.active(True)
            wlan.connect(wanted["name"], wanted["passphrase"])  # goes on by itself
        name = self._config["host"].encode()
        self.names = Names(wlan, (name, name + b".local"))

    def is_own_peer(self, peer):
        """True if an address is of the board's own access point's network."""
        if not self._access:
            return False
        here = self._wlan.ifconfig()[0]
        return peer[: peer.rfind(".")] == here[: here.rfind(".")]

    def listen(self, kind):
        """Return a socket that listens on the port for "http" or "tcp"; None: the radio is off."""
        if self._wlan is None:
            return None
        made = socket.socket()
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind(("0.0.0.0", self._config[_PORTS[kind]]))
        made.listen(_BACKLOG)
        return made


class Names:
    """The names of this board: those given, and its address, which a station gets late."""

    def __init__(self, wlan, names):
        self._wlan = wlan
        self._names = names

    def __contains__(self, name):
        return name in self._names or name == self._wlan.ifconfig()[0].encode()

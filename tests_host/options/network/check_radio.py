"""The radio against a `network` module that writes down what it is asked for, as a Pico W has it and as an ESP32 has it."""

import json
import os
import sys

from passo.web import radio

ACCESS = {"mode": "access", "name": "tocha", "passphrase": "oito letras", "key": "ABCDEFGHJKLMNPQR"}
STATION = {"mode": "station", "name": "oficina", "passphrase": "outra frase", "key": "ABCDEFGHJKLMNPQR"}
CONFIG = {"host": "passo", "http_port": 0, "tcp_port": 0}


class Wlan:
    def __init__(self, chip):
        self._chip = chip
        self.on = False
        self.done = []
        self.address = "0.0.0.0"

    def active(self, on):
        self.on = on
        self.done.append("active")

    def config(self, **what):
        if self._chip == "esp32" and not self.on:
            raise OSError("Wifi Not Started")
        self.done.append(what)

    def connect(self, name, passphrase):
        assert self.on
        self.done.append((name, passphrase))

    def ifconfig(self):
        return (self.address, "255.255.255.0", self.address, self.address)


class Network:
    """Of a chip: an ESP32 has a name for WPA2, and takes a configuration only once the radio is on."""

    AP_IF = 1
    STA_IF = 0

    def __init__(self, chip):
        if chip == "esp32":
            self.AUTH_WPA2_PSK = 3
        self._chip = chip
        self.made = {}
        self.named = None

    def hostname(self, name):
        assert not self.made, "before the radio is on, or mDNS does not know it"
        self.named = name

    def WLAN(self, kind):
        return self.made.setdefault(kind, Wlan(self._chip))


class Started:
    """A radio with the file that `passo wifi` writes: a dict, a text, or None."""

    def __init__(self, written, chip="rp2040"):
        self.network = Network(chip)
        before = sys.modules.get("network")
        sys.modules["network"] = self.network
        usual = radio.FILE
        radio.FILE = "wifi_of_check_%s.json" % chip
        try:
            if written is not None:
                with open(radio.FILE, "w") as file:
                    file.write(written if isinstance(written, str) else json.dumps(written))
            self.radio = radio.Radio(CONFIG)
        finally:
            del sys.modules["network"]
            if before:
                sys.modules["network"] = before
            if written is not None:
                os.remove(radio.FILE)
            radio.FILE = usual


def changed(data, **more):
    found = dict(data)
    found.update(more)
    return found


def check_an_access_point():
    for chip, secure in (("rp2040", 4), ("esp32", 3)):
        started = Started(ACCESS, chip)
        wlan = started.network.made[Network.AP_IF]
        wanted = {"ssid": "tocha", "key": "oito letras", "security": secure}
        assert started.network.named == "passo" and list(started.network.made) == [Network.AP_IF]
        assert wlan.on and [each for each in wlan.done if each != "active"] == [wanted], "WPA2, and nothing else"
        if chip == "rp2040":
            assert wlan.done[0] == wanted, "it is never open, not for a moment"
        wlan.address = "192.168.4.1"
        assert started.radio.is_own_peer("192.168.4.7") and not started.radio.is_own_peer("192.168.1.7") and not started.radio.is_own_peer("10.192.168.4")
        for name, known in ((b"passo", True), (b"passo.local", True), (b"192.168.4.1", True), (b"192.168.4.2", False), (b"evil.example", False)):
            assert (name in started.radio.names) == known, name
        assert started.radio.key == ACCESS["key"]


def check_a_station():
    for chip in ("rp2040", "esp32"):
        started = Started(STATION, chip)
        wlan = started.network.made[Network.STA_IF]
        assert list(started.network.made) == [Network.STA_IF] and wlan.done == ["active", ("oficina", "outra frase")]
        assert b"192.168.1.20" not in started.radio.names
        wlan.address = "192.168.1.20"  # which it gets late
        assert b"192.168.1.20" in started.radio.names and b"passo.local" in started.radio.names
        assert not started.radio.is_own_peer("192.168.1.7"), "a foreign network's neighbours are not its own"


def check_the_radio_stays_off():
    """Without data, or with data that are not whole: no network is opened, least of all one without a passphrase."""
    for written in (
        changed(ACCESS, key="ABCDEFGHJKLMNPQ"), changed(ACCESS, key="IO01" * 8), changed(ACCESS, key="abcdefghjklmnpqrst"), changed(STATION, key=5),
        None, "", "{", "[]", "null", "3", changed(ACCESS, passphrase=""), changed(ACCESS, passphrase="sieben7"), changed(ACCESS, name=""),
        changed(ACCESS, mode="open"), changed(ACCESS, key=""), changed(ACCESS, passphrase=None), {"mode": "access"}, changed(STATION, mode=""),
    ):  # fmt: skip
        started = Started(written)
        assert not started.network.made and started.network.named is None, written
        assert started.radio.listen("http") is None and started.radio.key is None and not started.radio.is_own_peer("192.168.4.2")


def check_it_listens():
    if sys.implementation.name != "cpython":
        return  # the unix port takes no address of two parts
    started = Started(ACCESS)
    for kind in ("http", "tcp"):
        made = started.radio.listen(kind)
        assert made.getsockname()[0] == "0.0.0.0"
        made.close()

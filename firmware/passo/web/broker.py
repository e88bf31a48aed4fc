"""The board publishes its state to an MQTT broker, and takes STOP from it: topics as in docs/use/shop.md.

    broker = Broker(config, language, line.stop, umqtt.simple, text_of)     # calls stop() if a STOP comes; text_of(number of an alarm)
    broker.poll(now_ms)                         # True: the state is wanted
    broker.publish_state(state)                 # bytes, JSON as pages get it

micropython-lib's umqtt makes the packets (MQTT 3.1.1). It would wait for the network, and the main loop must not. So umqtt writes into a buffer (Wire),
which poll() sends as the network takes it, and Wire gives umqtt the answers that it waits for at once; poll() checks the broker's real ones.
Only STOP is subscribed to, so each message is a STOP; a retained one is ignored. No TLS: that would take 40 kB.
"""

import json
import socket

from micropython import const

from passo import errors
from passo.records import COUNT_MASK
from passo.web.connection import AGAIN

KEEP_S = const(10)  # half as long again without a sign, and the broker says "gone"
_PORT = const(1883)
_ROOM = const(640)  # bytes that the network has not taken yet
_READ = const(64)  # bytes a call
_LOOK_MS = const(500)  # between two states
_PING_MS = const(5000)
_SILENT_MS = const(15_000)  # then the connection is given up
_AGAIN_MS = const(5000)  # until the next one
_UNDER_WAY = (115, 36, 119, 10035)  # errors of a socket that is being connected
_CONNACK = const(0x20)
_MESSAGE = const(0x30)
_RETAINED = const(1)
_SUBACK = const(0x90)
_HEADS = const(8)  # bytes of a message beside topic and text


class Wire:
    """A socket for umqtt."""

    def __init__(self):
        self.said = bytearray(_ROOM)
        self.used = 0
        self.expected = b""  # the bytes that umqtt reads next

    def settimeout(self, seconds):
        """Do nothing: this socket never waits."""

    setblocking = connect = settimeout

    def read(self, count):
        """Return the bytes that umqtt expects, `count` at most."""
        found = self.expected[:count]
        self.expected = self.expected[count:]
        return found

    def write(self, data, count=-1):
        """Append bytes to the buffer, for poll() to send. Raises OSError if _ROOM does not suffice."""
        count = len(data) if count < 0 else count
        if self.used + count > _ROOM:
            raise OSError(AGAIN[0])
        self.said[self.used : self.used + count] = data[:count]
        self.used += count

    def drop_sent(self, count):
        """Drop the first `count` bytes of the buffer, which have been sent."""
        left = self.used - count
        self.said[:left] = self.said[count : self.used]
        self.used = left


class Broker:
    def __init__(self, config, language, stop, umqtt, text_of):
        """`config`: the board file's network, checked; `language`: of its page's link."""
        self._umqtt = umqtt
        umqtt.socket = self  # it makes a socket, and looks for an address
        self._text_of = text_of
        self._host, _, port = config["broker"].partition(":")  # numbers: there is no time to ask for names
        self._port = int(port or _PORT)
        self._user = config["broker_user"].encode(), config["broker_password"].encode()
        self._name = config["host"].encode()
        self._own = b"passo/" + self._name + b"/"
        self._language = language.encode()
        self._stop = stop
        self._wire = Wire()
        self._address = socket.getaddrinfo(self._host, self._port)[0][-1]
        self._socket = self._client = None
        self._told = {}  # topic: text
        self._tried_ms = self._heard_ms = self._pinged_ms = self._looked_ms = -1
        self._kind = self._length = self._shift = self._left = 0  # of the packet that comes

    # --- what umqtt takes for its module of sockets

    def socket(self):
        return self._wire

    def getaddrinfo(self, host, port):
        return ((host, port),)

    # --- the connection

    def poll(self, now_ms):
        """Connect, or send and read what the network takes and has. Returns True each _LOOK_MS: the state is wanted."""
        if self._socket is None:
            if self._tried_ms < 0 or (now_ms - self._tried_ms) & COUNT_MASK >= _AGAIN_MS:
                self._tried_ms = now_ms
                self._close_on_error(self._connect_broker, now_ms)
            return False
        self._close_on_error(self._exchange_bytes, now_ms)
        if self._socket is None or (now_ms - self._looked_ms) & COUNT_MASK < _LOOK_MS:
            return False
        self._looked_ms = now_ms
        return True

    def select_list(self):
        """The sockets that select() is to wait for."""
        return [self._socket] if self._socket else []

    def close(self):
        """Close the connection; the broker then publishes the last will, "gone"."""
        if self._socket:
            self._socket.close()
            self._socket = None

    def _close_on_error(self, work, now_ms):
        """Call work(now_ms), and close the connection if it raises OSError."""
        try:
            work(now_ms)
        except OSError:
            self.close()

    def _connect_broker(self, now_ms):
        """Begin a connection without waiting, and write its first packets into the buffer. Raises OSError."""
        made = self._socket = socket.socket()
        made.setblocking(False)
        try:
            made.connect(self._address)
        except OSError as error:
            if error.errno not in _UNDER_WAY:
                raise
        self._heard_ms = self._pinged_ms = self._looked_ms = now_ms
        self._kind = self._left = 0
        self._told = {}
        wire = self._wire
        wire.used = 0
        client = self._client = self._umqtt.MQTTClient(b"passo-" + self._name, self._host, self._port, *self._user, KEEP_S)
        client.set_last_will(self._own + b"state", b"gone", True)
        client.set_callback(self._stop)
        wire.expected = bytes((_CONNACK, 2, 0, 0))
        client.connect()
        for number, topic in ((1, b"passo/"), (2, self._own)):
            wire.expected = bytes((_SUBACK, 3, 0, number, 0))
            client.subscribe(topic + b"stop")
        self._publish_topic(b"language", self._language)

    def _exchange_bytes(self, now_ms):
        """Send and read what the network takes and has. Raises OSError if the connection is of no use any more."""
        wire = self._wire
        if (now_ms - self._heard_ms) & COUNT_MASK >= _SILENT_MS:
            raise OSError(0)
        if (now_ms - self._pinged_ms) & COUNT_MASK >= _PING_MS and wire.used < _ROOM // 2:
            self._pinged_ms = now_ms
            self._client.ping()
        try:
            if wire.used:
                wire.drop_sent(self._socket.send(memoryview(wire.said)[: wire.used]))
            data = self._socket.recv(_READ)
        except OSError as error:
            if error.errno in AGAIN:
                return
            raise
        if not data:
            raise OSError(0)
        self._heard_ms = now_ms
        for byte in data:
            self._parse_byte(byte)

    def _parse_byte(self, byte):
        """Take a byte of an MQTT 3.1.1 packet: its kind, its length (seven bits a byte), its content. Calls stop() at a message. Raises OSError
        if the broker refuses the connection."""
        if not self._kind:
            self._kind = byte
            self._length = self._shift = 0
        elif self._left:
            self._left -= 1
            if not self._left:
                if self._kind == _CONNACK and byte:  # the broker refuses the user or the password
                    raise OSError(byte)
                self._kind = 0
        else:
            self._length |= (byte & 0x7F) << self._shift
            self._shift += 7
            if byte & 0x80:
                return
            self._left = self._length
            if self._kind & 0xF0 == _MESSAGE and not self._kind & _RETAINED:
                self._stop()
            if not self._left:
                self._kind = 0

    # --- the topics

    def publish_state(self, text):
        """Publish the topics of a state, JSON as pages get it."""
        if self._socket is None:
            return
        state = json.loads(text)
        share, comma, job = (state.get("stored") or "").partition(",")
        alarm = state["alarm"] or (errors.LOCKED if state["state"] == "Alarm" else 0)
        self._close_on_error(self._publish_all, (
            (b"state", state["state"].lower()), (b"job", job.rstrip("?") if comma else ""), (b"progress", share if comma else ""),
            (b"place", json.dumps(state["w"]) if state.get("w") else ""), (b"alarm", self._text_of(alarm) if alarm else ""),
        ))  # fmt: skip

    def _publish_all(self, topics):
        for topic, text in topics:
            self._publish_topic(topic, text.encode())

    def _publish_topic(self, topic, text):
        """Publish a topic, retained, if its text has changed and there is room; else the next state will do."""
        if self._told.get(topic) != text and self._wire.used + len(self._own) + len(topic) + len(text) + _HEADS <= _ROOM:
            self._told[topic] = text
            self._client.publish(self._own + topic, text, True)

"""A machine's connection to the broker, MQTT 5: its state retained, its last will, its log.

    link = Link(Broker("192.168.1.20"), "plotter-3")
    link.tell({"state": "idle", …})         # publishes the topics that have changed, all of them behind each connection
    link.log({"what": "alarm", …})          # not retained; waits while there is no connection, the oldest are dropped
    link.stops()                            # True once after each STOP, for this machine or for all
    link.close()                            # "gone", as the last will says if this process dies

Topics are passo/NAME/… A connection each: a last will belongs to one.
"""

import collections
import json
import ssl
import sys
import threading
from typing import NamedTuple, Optional

import paho.mqtt.client as mqtt
from paho.mqtt.enums import CallbackAPIVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties
from paho.mqtt.reasoncodes import ReasonCode
from paho.mqtt.subscribeoptions import SubscribeOptions

from host_tools.failure import Failure, reason
from host_tools.language import _
from host_tools.shop.telling import GONE

ROOT = "passo"
STOP = "stop"  # passo/stop: all machines; passo/NAME/stop: that one. Any text
_KEEP_ALIVE_S = 10  # half as long again without a sign, and the broker publishes the last will
_AGAIN_S = 1, 10  # until the next attempt to connect, at least and at most
_MOST_WAITING = 1000  # events
_PORT, _TLS_PORT = 1883, 8883


class Broker(NamedTuple):
    """Where the broker is, and who speaks. `ca`: file of the authority that has signed its certificate; None: no TLS."""

    host: str
    port: int = 0
    user: str = ""
    password: str = ""
    ca: Optional[str] = None

    def client(self, name):
        """A client of paho, not connected. Raises Failure if the authority's file cannot be used."""
        client = mqtt.Client(CallbackAPIVersion.VERSION2, name, protocol=mqtt.MQTTv5)
        if self.user:
            client.username_pw_set(self.user, self.password)
        if self.ca:
            try:
                client.tls_set(self.ca, tls_version=ssl.PROTOCOL_TLS_CLIENT)
            except (OSError, ssl.SSLError) as error:
                raise Failure("{}: no certificate of an authority: {}", self.ca, reason(error)) from error
        return client

    def connect(self, client):
        """Connect it, and again whenever the connection is lost, in a thread of its own."""
        client.reconnect_delay_set(*_AGAIN_S)
        client.connect_async(self.host, self.port or (_TLS_PORT if self.ca else _PORT), _KEEP_ALIVE_S)
        client.loop_start()


class Link:
    def __init__(self, broker, name, refused=None, more=None):
        """`refused(text)`: hears, from another thread, why there is no connection; `more`: {topic: text}, retained, beside the
        machine's own topics."""
        self._more = more or {}
        self._topic = f"{ROOT}/{name}/"
        self._refused = refused or (lambda text: None)
        self._why = ""  # the last reason that it has heard
        self._told = {}
        self._fresh = threading.Event()  # connected anew: the broker may have forgotten all
        self._stop = threading.Event()
        self._waiting = collections.deque(maxlen=_MOST_WAITING)
        self._client = broker.client(f"{ROOT}-{name}")
        self._client.will_set(self._topic + "state", GONE, 1, True)
        self._client.on_connect = self._connected
        self._client.on_message = self._hear
        self._client.on_connect_fail = lambda client, userdata: self._fail(_("no broker answers: {}", reason(sys.exc_info()[1])))
        self._client.on_disconnect = self._disconnected
        broker.connect(self._client)

    def _connected(self, client, userdata, flags, code, properties):
        if code.is_failure:
            self._fail(_("the broker refuses: {}", code))
            return
        self._why = ""
        # One that is retained would stop the machine again at each connection, long after.
        options = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
        client.subscribe([(f"{ROOT}/{STOP}", options), (self._topic + STOP, options)])
        self._fresh.set()

    def _disconnected(self, client, userdata, flags, code, properties):
        if code.is_failure:
            self._fail(_("the connection to the broker is lost: {}", code))

    def _fail(self, why):
        if why != self._why:
            self._why = why
            self._refused(why)

    def _hear(self, client, userdata, message):
        self._stop.set()

    def stops(self):
        if not self._stop.is_set():
            return False
        self._stop.clear()
        return True

    @property
    def up(self):
        return self._client.is_connected()

    def tell(self, topics):
        if not self.up:
            return
        if self._fresh.is_set():
            self._fresh.clear()
            self._told = {}
            for topic, text in self._more.items():
                self._client.publish(topic, text, 1, True)
        for topic, text in topics.items():
            if self._told.get(topic) != text:
                self._told[topic] = text
                self._client.publish(self._topic + topic, text, 1, True)
        while self._waiting:
            self._client.publish(self._topic + "log", self._waiting.popleft(), 1)

    def log(self, event):
        self._waiting.append(json.dumps(event, ensure_ascii=False))

    def close(self):
        """The broker publishes the last will, as it does without this, and at once."""
        with_will = ReasonCode(PacketTypes.DISCONNECT, "Disconnect with will message")
        self._client.disconnect(with_will, Properties(PacketTypes.DISCONNECT))
        self._client.loop_stop()

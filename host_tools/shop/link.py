"""A machine's connection to the broker, MQTT 5: its state retained, its last will, its log.

    link = Link(Broker("192.168.1.20"), "plotter-3")
    link.publish_topics({"state": "idle", …})   # publishes the topics that have changed, all of them behind each connection
    link.add_event({"what": "alarm", …})    # not retained; waits while there is no connection, the oldest are dropped
    link.doubled = function                 # called with a text if another agent speaks for the machine
    link.stopped = function                 # called for each STOP, for this machine or for all, from the connection's own thread
    link.take_orders()                      # the shop's messages, [(SHOP or ORDER, text)], if the machine takes jobs
    link.parcel.ask_file(sha, parts)        # a file that the shop has put on the broker
    link.parcel.file_data()                 # its bytes, once they are all there and right
    link.close()                            # "gone", as the last will says if this process dies

Topics are passo/NAME/… A connection each: a last will belongs to one.

One agent speaks for a machine: two would give one job to two boards. Before it does, it asks at the broker whether another one does already
(passo/NAME/who, answered at passo/NAME/agent), for a second; and again behind each loss of the connection, which another one may have taken over.
If there is another, or a board of that name that tells its state to the broker itself, this one says so, tells nothing, and takes no orders; it hears STOP all the same.
"""

import collections
import functools
import hashlib
import json
import os
import re
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
from host_tools.shop.state_topics import GONE

ROOT = "passo"
STOP = "stop"  # passo/stop: all machines; passo/NAME/stop: that one. Any text
SHOP = "shop"  # passo/shop: the nonce for messages of machines to the shop
ORDER = "order"  # passo/NAME/order: the shop's, signed
FILE = "file"  # passo/file/SHA-256/NUMBER: a piece of a job's file
WHO, AGENT = "who", "agent"  # passo/NAME/who: an agent asks, with a text of its own, which passo/NAME/agent repeats if there is another
STATE = "state"  # told while an agent only listens: a board of that name speaks for itself
_ANSWER_S = 1.0  # an agent that is there has answered
PIECE = 32_768  # bytes
_KEEP_ALIVE_S = 10  # half as long again without a sign, and the broker publishes the last will
_AGAIN_S = 1, 10  # until the next attempt to connect, at least and at most
_MOST_WAITING = 1000  # events
_MOST_TOLD = 200  # letters of an error
_NUMBER = re.compile(r"[0-9]{1,4}")  # of a piece
_PORT, _TLS_PORT = 1883, 8883


def complain_of_errors(handler):
    """Wrap a method that handles the broker's messages: errors go to `self.complain(text)`. Else they would end the connection's thread, and STOP
    with it."""

    @functools.wraps(handler)
    def handle_safely(self, *arguments):
        """Return the handler's result; hand an exception to complain() and return None."""
        try:
            return handler(self, *arguments)
        except Exception as error:
            self.complain(wrong_message(error))

    return handle_safely


def wrong_message(error):
    """A sentence about a message, of a broker or a board, that could not be carried out."""
    return _("a message could not be carried out: {}", f"{type(error).__name__}: {reason(error)}"[:_MOST_TOLD])


class Broker(NamedTuple):
    """Address of the broker, and the user at it. `ca`: file of the authority that has signed its certificate; None: no TLS."""

    host: str
    port: int = 0
    user: str = ""
    password: str = ""
    ca: Optional[str] = None

    def make_client(self, name):
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

    def connect_client(self, client):
        """Connect `client`, and again whenever the connection is lost, in a thread of its own."""
        client.reconnect_delay_set(*_AGAIN_S)
        client.connect_async(self.host, self.port or (_TLS_PORT if self.ca else _PORT), _KEEP_ALIVE_S)
        client.loop_start()


class Parcel:
    """The file of a job, in pieces that the shop keeps on the broker."""

    def __init__(self, client):
        self.client = client
        self._topic, self._sha, self._pieces = "", "", []
        self._fresh = False  # a piece has come since the file was looked at
        self.wrong = False  # all pieces are there, and are another file

    def ask_file(self, sha, parts):
        """Begin to collect a file in `parts` pieces; `sha`: its SHA-256 in hex."""
        self.drop()
        self._fresh = self.wrong = False
        self._sha, self._pieces = sha, [None] * parts
        self._topic = f"{ROOT}/{FILE}/{sha}/"
        self.subscribe()

    def subscribe(self):
        if self._topic:
            self.client.subscribe(self._topic + "+", 1)

    def take_piece(self, topic, data):
        """Take a message of the broker, if it is a piece of the file."""
        number = topic[len(self._topic) :]
        if self._topic and topic.startswith(self._topic) and _NUMBER.fullmatch(number) and int(number) < len(self._pieces):
            self._pieces[int(number)] = data
            self._fresh = True

    def file_data(self):
        """Return all bytes of the file, once; None: some are missing, or it is not the file that the shop has signed (`wrong`)."""
        if not self._fresh or None in self._pieces:
            return None
        self._fresh = False
        data = b"".join(self._pieces)
        self.wrong = hashlib.sha256(data).hexdigest() != self._sha
        return None if self.wrong else data

    def drop(self):
        """Forget the file, and unsubscribe from its pieces."""
        if self._topic:
            self.client.unsubscribe(self._topic + "+")
        self._topic, self._sha, self._pieces = "", "", []


class Link:
    def __init__(self, broker, name, refused=None, more=None, works=False):
        """`refused(text)` is called, from another thread, with the reason why there is no connection; `more`: {topic: text}, retained, beside
        the machine's own topics; `works`: the machine takes jobs of a shop."""
        self._works = works
        self._heard = collections.deque(maxlen=_MOST_WAITING)
        self._more = more or {}
        self._topic = f"{ROOT}/{name}/"
        self._refused = refused or (lambda text: None)
        self._why = ""  # the last reason that it has heard
        self._told = {}
        self.connections = 0  # begun
        self._fresh = threading.Event()  # connected anew: the broker may have forgotten all
        self.stopped = lambda: None
        self._waiting = collections.deque(maxlen=_MOST_WAITING)
        self._broker, self._name = broker, name
        self._own = os.urandom(8).hex()
        self._mark = Properties(PacketTypes.PUBLISH)
        self._mark.UserProperty = ("by", self._own)  # a state with it is no other agent's
        self.doubled = lambda text: None
        self._double = ""  # a sentence, if another agent speaks for the machine
        self._asking = None  # the timer of the answer
        self._closing = False
        self._lock = threading.RLock()  # of the change from one connection to the next
        self._client = self._listener = self._make_listener()  # None: this agent speaks for the machine
        self.parcel = Parcel(self._client)
        broker.connect_client(self._client)

    def _make_client(self, name, connected):
        """Make a client of paho with this link's handlers; `connected`: the one for a connection. Raises Failure."""
        client = self._broker.make_client(name)
        client.on_connect = connected
        client.on_message = self._take_message
        client.on_connect_fail = self._on_connect_fail
        client.on_disconnect = self._on_disconnect
        return client

    def _make_listener(self):
        return self._make_client(f"{ROOT}-{self._name}-{self._own}", self._on_listener_connect)

    # --- who speaks for the machine

    @complain_of_errors
    def _on_listener_connect(self, client, userdata, flags, code, properties):
        """Connected without the machine's name: hear STOP, and ask for another agent if none is known of yet."""
        if code.is_failure:
            self._complain_once(_("the broker refuses: {}", code))
            return
        self._hear_stop(client)
        with self._lock:
            if self._double or self._closing or client is not self._client:
                return
            # Another agent of this name may publish its state before this subscription; at the start a retained state proves nothing.
            handling = SubscribeOptions.RETAIN_SEND_ON_SUBSCRIBE if self.connections else SubscribeOptions.RETAIN_DO_NOT_SEND
            state = SubscribeOptions(qos=1, retainHandling=handling)
            client.subscribe([(self._topic + WHO, 1), (self._topic + AGENT, 1), (self._topic + STATE, state)])
            client.publish(self._topic + WHO, self._own, 1)
            if self._asking:
                self._asking.cancel()
            self._asking = threading.Timer(_ANSWER_S, self._speak_for_machine)
            self._asking.daemon = True
            self._asking.start()

    @complain_of_errors
    def _speak_for_machine(self):
        """Connect in the machine's name: no other agent has answered."""
        with self._lock:
            self._asking = None
            if self._double or self._closing or self._client is not self._listener or not self._client.is_connected():
                return
            self._client = self.parcel.client = self._make_client(f"{ROOT}-{self._name}", self._on_connect)
            self._client.will_set(self._topic + "state", GONE, 1, True)
            self._broker.connect_client(self._client)

    @complain_of_errors
    def _yield_machine(self):
        """Tell nothing and take no orders any more, because another agent speaks for the machine; still hear STOP."""
        with self._lock:
            if self._double or not self._listener:
                return
            self._double = _("another agent speaks for {} at the broker: this one tells nothing and takes no orders. End one of the two, or give it another NAME; then start this one anew", self._name)
            if self._asking:
                self._asking.cancel()
            spoke = self._client if self._client is not self._listener else None
            self._client = self._listener
            self._heard.clear()
        if spoke:
            _end_connection(spoke)
        self._refused(self._double)
        self.doubled(self._double)

    def _hear_stop(self, client):
        # One that is retained would stop the machine again at each connection, long after.
        options = SubscribeOptions(qos=1, retainHandling=SubscribeOptions.RETAIN_DO_NOT_SEND)
        client.subscribe([(f"{ROOT}/{STOP}", options), (self._topic + STOP, options)])

    def _answer_agent(self, asks):
        """Answer another agent's question who speaks for the machine. Of two that ask at the same time, the one with the higher text stays."""
        with self._lock:
            if asks == self._own or self._double:
                return
            stays = self._client is not self._listener or asks < self._own
            if stays:
                self._client.publish(self._topic + AGENT, asks, 1)
        if not stays:
            self._yield_machine()

    # --- the connection

    @complain_of_errors
    def _on_connect_fail(self, client, userdata):
        self._complain_once(_("no broker answers: {}", reason(sys.exc_info()[1])))

    @complain_of_errors
    def _on_connect(self, client, userdata, flags, code, properties):
        """Subscribe in the machine's name, and end the listener; the next publish_topics() publishes all topics."""
        if code.is_failure:
            self._complain_once(_("the broker refuses: {}", code))
            return
        self._why = ""
        self.connections += 1
        self._hear_stop(client)
        client.subscribe(self._topic + WHO, 1)
        with self._lock:
            listener, self._listener = self._listener, None
        if listener:
            _end_connection(listener)
        if self._works:
            client.subscribe([(f"{ROOT}/{SHOP}", 1), (self._topic + ORDER, 1)])
            self.parcel.subscribe()
        self._fresh.set()

    @complain_of_errors
    def _on_disconnect(self, client, userdata, flags, code, properties):
        """Listen again without the machine's name: another agent may have taken it over."""
        with self._lock:
            ended = []
            if client is self._client and client is not self._listener and not self._closing:  # another one may have taken it: ask again
                ended = [client] + [self._listener] * bool(self._listener)
                self._client = self.parcel.client = self._listener = self._make_listener()
                self._broker.connect_client(self._client)
        for each in ended:
            _end_connection(each)
        if code.is_failure:
            self._complain_once(_("the connection to the broker is lost: {}", code))

    def _complain_once(self, why):
        """Pass a reason to `refused`, unless it is the last one again."""
        if why != self._why:
            self._why = why
            self._refused(why)

    complain = _complain_once

    @complain_of_errors
    def _take_message(self, client, userdata, message):
        """Take a message of the broker: STOP, a question or answer about the agent, an order, or a piece of a file."""
        what = message.topic.rpartition("/")[2]
        if what == STOP:
            self.stopped()
        elif what == WHO:
            self._answer_agent(message.payload.decode(errors="replace"))
        elif what == AGENT:
            if message.payload.decode(errors="replace") == self._own:
                self._yield_machine()
        elif what == STATE:
            own = ("by", self._own) in getattr(message.properties, "UserProperty", [])
            if client is self._client and client is self._listener and not own and message.payload not in (b"", GONE.encode()):
                self._yield_machine()
        elif what in (SHOP, ORDER):
            self._heard.append((what, message.payload.decode(errors="replace")))
        else:
            self.parcel.take_piece(message.topic, message.payload)

    def take_orders(self):
        """Return the shop's messages since the last call, [(SHOP or ORDER, text)]."""
        found = []
        while self._heard:
            found.append(self._heard.popleft())
        return found

    @property
    def is_up(self):
        """True if this agent speaks for the machine and is connected."""
        return self._client is not self._listener and self._client.is_connected()

    def publish_topics(self, topics):
        """Publish the topics that have changed, {topic: text}, retained, and waiting events; nothing without a connection."""
        if not self.is_up:
            return
        if self._fresh.is_set():
            self._fresh.clear()
            self._told = {}
            for topic, text in self._more.items():
                self._client.publish(topic, text, 1, True)
        for topic, text in topics.items():
            if self._told.get(topic) != text:
                self._told[topic] = text
                self._client.publish(self._topic + topic, text, 1, True, self._mark)
        while self._waiting:
            self._client.publish(self._topic + "log", self._waiting.popleft(), 1)

    def add_event(self, event):
        self._waiting.append(json.dumps(event, ensure_ascii=False))

    def close(self):
        """The broker publishes the last will, as it does without this, and at once."""
        with self._lock:
            self._closing = True
            clients = {self._client, self._listener or self._client}
            if self._asking:
                self._asking.cancel()
        for client in clients:
            _end_connection(client)


def _end_connection(client):
    """End a connection, with its last will, and its thread."""
    with_will = ReasonCode(PacketTypes.DISCONNECT, "Disconnect with will message")
    client.disconnect(with_will, Properties(PacketTypes.DISCONNECT))
    client.loop_stop()

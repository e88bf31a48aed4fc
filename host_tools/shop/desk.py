"""The shop at the broker: it hears which machines are released, and gives each a job of the book.

    desk = Desk(broker, key, book)
    desk.machines       # {name: what it has told last, with "state", "progress", …}
    desk.stop_all()
    desk.close()

What the broker loses is said again: a machine tells with each connection what it has, and the desk compares that with the book. An order
is signed for the nonce of the machine's release, so it is carried out once. One for a job that was given before says so ("again"): the machine
asks whoever stands there.
"""

import os
import threading

import paho.mqtt.client as mqtt

from host_tools.shop.book import BEGUN, GIVEN, WAITING
from host_tools.shop.link import FILE, ORDER, PIECE, ROOT, SHOP, STOP
from host_tools.shop.signed import MACHINE, Opener, sealed
from host_tools.shop.signed import SHOP as FROM_SHOP
from host_tools.shop.telling import GONE, LOST, TOPICS
from passo.web.guard import nonce

_STATES = {"fetch": GIVEN, "run": BEGUN, "waits": WAITING, "goes": WAITING}
_TOOL = "tool"
LASER_CLASSES = "1", "1C", "1M", "2", "2M", "3R", "3B", "4"  # of IEC 60825-1, the harmless ones first
_AWAY = GONE, LOST


def fits(job, machine):
    """True if a machine, as it tells of itself, can draw a job."""
    wants = job.wants
    area, room = wants.get("area") or [0, 0], machine.get("area") or [0, 0]
    return (
        wants.get("kind") == machine.get("kind")
        and wants.get(_TOOL, "") in ("", machine.get(_TOOL, ""))
        and _is_safe(machine.get("laser", ""), wants.get("laser", ""))
        and all(not have or need <= have + 0.001 for need, have in zip(area, room))
    )


def _is_safe(has, most):
    """True if a laser's class is `most` or a more harmless one. `most` "": any will do; `has` "": nobody has said."""
    return not most or has in LASER_CLASSES[: LASER_CLASSES.index(most) + 1]


class Desk:
    def __init__(self, broker, key, book):
        self._key, self._book = key, book
        self._nonce = nonce()
        self._openers = {}
        self._ordered = {}  # machine: the text of its order, while it has not been taken
        self._files = set()  # SHA-256 of those on the broker
        self._lock = threading.RLock()
        self.machines = {}
        self._client = broker.client(f"{ROOT}-shop-{os.urandom(4).hex()}")
        self._client.on_connect = self._connected
        self._client.on_message = self._hear
        broker.connect(self._client)

    @property
    def up(self):
        return self._client.is_connected()

    def close(self):
        self._client.disconnect()
        self._client.loop_stop()

    def stop_all(self):
        self._client.publish(f"{ROOT}/{STOP}", "shop", 1)

    def _connected(self, client, userdata, flags, code, properties):
        if code.is_failure:
            return
        client.subscribe([(f"{ROOT}/+/work", 1)] + [(f"{ROOT}/+/{topic}", 0) for topic in (*TOPICS, "language")])
        client.publish(f"{ROOT}/{SHOP}", self._nonce, 1, True)
        with self._lock:  # the broker may have forgotten all
            for sha in self._files:
                self._put(sha)
            for name, text in self._ordered.items():
                client.publish(f"{ROOT}/{name}/{ORDER}", text, 1, True)

    # --- what machines tell

    def _hear(self, client, userdata, message):
        _root, name, topic = message.topic.split("/")
        text = message.payload.decode(errors="replace")
        with self._lock:
            if topic != "work":
                before = self.machines.setdefault(name, {}).get(topic)
                self.machines[name][topic] = text
                if topic == "state" and before in _AWAY:  # it may have been released meanwhile, or have said so before it said that it is back
                    self.look(name)
                return
            opener = self._openers.setdefault(name, Opener(self._key, MACHINE, f"{self._nonce} {name}"))
            told = opener.open(text)
            if told:
                self.machines.setdefault(name, {}).update(told)
                self._answer(name, told)

    def _answer(self, name, told):
        book = self._book
        job = book.open_of(name)
        if told["ended"] and job and told["ended"][0] == job.id:
            book.end(job, *told["ended"][1:])
            self._forget(name, job)
            job = None
        if job and told["job"] == job.id:
            self._forget(name)
            book.follow(job, _STATES.get(told["how"], GIVEN), told["line"], told["text"])
        elif job:
            self._order(name, job, told["nonce"])
        elif told["how"] == "free":
            self.look(name)

    def look(self, only=None):
        """Give jobs to the machines that are released: to one, or after the queue has grown."""
        with self._lock:
            for name, told in self.machines.items():
                if only in (None, name) and told.get("how") == "free" and told.get("state") not in _AWAY:
                    job = self._book.give(name, told["nonce"], lambda job, told=told: fits(job, told))
                    if job:
                        self._order(name, job, told["nonce"])

    # --- orders

    def _order(self, name, job, to):
        parts = -(-len(self._book.data(job.sha)) // PIECE)
        if job.sha not in self._files:
            self._files.add(job.sha)
            self._put(job.sha)
        body = {"id": job.id, "name": job.name, "sha": job.sha, "parts": parts, "again": to != job.nonce}
        text = self._ordered[name] = sealed(self._key, FROM_SHOP, to, 1, body)
        self._client.publish(f"{ROOT}/{name}/{ORDER}", text, 1, True)

    def _forget(self, name, job=None):
        """The machine has taken its order; with the job's end nobody wants its file, unless another machine does."""
        if self._ordered.pop(name, None) is not None:
            self._client.publish(f"{ROOT}/{name}/{ORDER}", "", 1, True)
        if job and not self._book.wanted(job.sha):
            for number in range(-(-len(self._book.data(job.sha)) // PIECE)):
                self._client.publish(f"{ROOT}/{FILE}/{job.sha}/{number}", b"", 1, True)
            self._files.discard(job.sha)

    def _put(self, sha):
        data = self._book.data(sha)
        for number in range(-(-len(data) // PIECE)):
            self._client.publish(f"{ROOT}/{FILE}/{sha}/{number}", data[number * PIECE : (number + 1) * PIECE], 1, True)

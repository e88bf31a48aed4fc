"""The shop at the broker: it hears which machines are released, and gives each a job of the book.

    dispatcher = Dispatcher(broker, key, book)
    dispatcher.machines       # {name: its last message, with "state", "progress", …}
    dispatcher.stop_all()
    dispatcher.close()

Lost messages are repaired: with each connection a machine sends its whole state, and the dispatcher compares it with the book. An order
is signed for the nonce of the machine's release, so it is carried out once. One for a job that was given before says so ("again"): the machine
asks whoever stands there.

Messages of machines are numbered by the clocks of their PCs, so that the dispatcher takes each one once. If one is signed right, but older than the last,
a clock may have been set back: the shop publishes another nonce, and all machines send their state anew, signed for it.

If the book cannot be written (the disk is full, or another program has the file), the dispatcher tries again each second with the last message of each
machine. Neither messages nor STOP wait for the disk: the thread that receives messages sends STOP.
"""

import os
import sys
import threading

import paho.mqtt.client as mqtt

from host_tools.language import _
from host_tools.shop.job_table import BEGUN, GIVEN, LEFT, OPEN, WAITING, JobTableError
from host_tools.shop.link import FILE, ORDER, PIECE, ROOT, SHOP, STOP, complain_of_errors, wrong_message
from host_tools.shop.machines import Machines
from host_tools.shop.signed import sign_message
from host_tools.shop.signed import SHOP as FROM_SHOP
from host_tools.shop.state_topics import GONE, LOST, TOPICS
from passo import errors
from passo.web.guard import make_nonce

_RENEW_S = 2.0  # between two nonces, at least
_AGAIN_S = 1.0  # between two attempts to write the book
_LEFT_S = 2.0  # a STOP has been acknowledged by the broker
_WORD, _QUEUE, _PIECES = "word", "queue", "pieces"  # tasks of the thread: a machine's message, jobs for one or all, a file to publish
# A machine's message: the type of each field. `ended`: None or [id, how, line, text]; `area`: mm of X and Y.
_TOLD = {"how": str, "job": str, "nonce": str, "line": int, "text": str, "ended": (list, type(None)), "area": list, "kind": str, "tool": str, "laser": str, "page": str}
_ENDED = str, str, int, str
_MOST_LINES = 1 << 40
_STATES = {"fetch": GIVEN, "run": BEGUN, "waits": WAITING, "goes": WAITING}
_TOOL = "tool"
LASER_CLASSES = "1", "1C", "1M", "2", "2M", "3R", "3B", "4"  # of IEC 60825-1, the harmless ones first
_AWAY = GONE, LOST


def job_fits(job, machine):
    """True if a machine can draw a job: kind, tool, laser class and area (mm) suit. `machine`: the fields of its message."""
    wants = job.wants
    area, room = wants.get("area") or [0, 0], machine.get("area") or [0, 0]
    return (
        wants.get("kind") == machine.get("kind")
        and wants.get(_TOOL, "") in ("", machine.get(_TOOL, ""))
        and _is_safe(machine.get("laser", ""), wants.get("laser", ""))
        and all(not have or need <= have + 0.001 for need, have in zip(area, room))
    )


def _is_safe(has, most):
    """True if a laser's class `has` is `most` or a more harmless one (IEC 60825-1). `most` "": any will do; `has` "": unknown, never safe."""
    return not most or has in LASER_CLASSES[: LASER_CLASSES.index(most) + 1]


def read_told(told):
    """A machine's message without the fields that the shop does not know; None: a field is missing, or of another type."""
    told = {name: told[name] for name in _TOLD if name in told}
    told = {"tool": "", "laser": "", "page": "", **told}
    right = set(told) == set(_TOLD) and all(_is_a(value, _TOLD[name]) for name, value in told.items())
    ended = told["ended"] if right else None
    right = right and (ended is None or len(ended) == len(_ENDED) and all(map(_is_a, ended, _ENDED)))
    right = right and all(0 <= line <= _MOST_LINES for line in (told["line"], *(ended or ())[2:3]))
    return told if right and all(_is_a(each, (int, float)) for each in told["area"]) else None


def _is_a(value, types):
    return isinstance(value, types) and not isinstance(value, bool)


def is_reached(machine):
    """True if a machine, as it tells of itself, has proven the key and is there: it may have its job."""
    return bool(machine and machine.get("how") and machine.get("state") != GONE)


class Dispatcher:
    def __init__(self, broker, key, book):
        self._key, self._book = key, book
        self._nonce = make_nonce()
        self._heard = Machines(key, self._nonce)
        self._renewing = None  # the timer of the next nonce
        self._ordered = {}  # machine: the text of its order, while it has not been taken
        self._files = set()  # SHA-256 of those on the broker
        self._lock = threading.RLock()
        self.machines = self._heard.known
        self._told = {}  # machine: its last word
        self._again = set()  # (what, name): not done yet, for the book could not be written
        self._trying = None  # the thread that tries again
        self._closed = threading.Event()
        self._complained = ""
        self._client = broker.make_client(f"{ROOT}-shop-{os.urandom(4).hex()}")
        self._client.on_connect = self._on_connect
        self._client.on_message = self._take_message
        broker.connect_client(self._client)

    @property
    def is_up(self):
        """True if the broker is connected."""
        return self._client.is_connected()

    def close(self):
        """End the threads and the connection."""
        self._closed.set()
        if self._renewing:
            self._renewing.cancel()
        self._client.disconnect()
        self._client.loop_stop()

    def complain(self, text):
        """Print a sentence on the standard error output, unless it is the last one again."""
        if text != self._complained:
            self._complained = text
            print(text, file=sys.stderr, flush=True)

    def stop_all(self):
        """Stop all machines. Returns 0 once the broker has the message, else NOT_SENT; waits for that, _LEFT_S at most."""
        if not self.is_up:
            return errors.NOT_SENT  # sent once it is there again, it would stop machines that somebody has started meanwhile
        told = self._client.publish(f"{ROOT}/{STOP}", "shop", 1)
        try:
            told.wait_for_publish(_LEFT_S)
        except (ValueError, RuntimeError):
            return errors.NOT_SENT
        return 0 if told.is_published() else errors.NOT_SENT

    @complain_of_errors
    def _on_connect(self, client, userdata, flags, code, properties):
        """Subscribe, publish the nonce, and publish all orders and files anew: the broker may have forgotten them."""
        if code.is_failure:
            return
        self._subscribe_topics()
        client.publish(f"{ROOT}/{SHOP}", self._nonce, 1, True)
        with self._lock:  # the broker may have forgotten all
            for name, text in self._ordered.items():
                client.publish(f"{ROOT}/{name}/{ORDER}", text, 1, True)
            for sha in self._files:
                self._do_or_retry(_PIECES, sha)

    def _subscribe_topics(self):
        self._client.subscribe([(f"{ROOT}/+/work", 1)] + [(f"{ROOT}/+/{topic}", 0) for topic in (*TOPICS, "language")])

    # --- the book

    def _do_or_retry(self, what, name):
        """Do a task on the book at once, or once it can be written again. `what`: _WORD, _QUEUE or _PIECES; `name`: a machine, or a file's sum."""
        if not self._again and self._try_task(what, name):
            return
        self._again.add((what, name))
        if self._trying is None:
            self._trying = threading.Thread(target=self._try_again, daemon=True)
            self._trying.start()

    def _try_task(self, what, name):
        """Do a task on the book. Returns False if the book cannot be written now."""
        try:
            {_WORD: self._compare_book, _QUEUE: self._give_jobs, _PIECES: self._publish_file}[what](name)
        except JobTableError:
            return False
        except Exception as error:  # of this one only: the others go on
            self.complain(wrong_message(error))
        return True

    def _try_again(self):
        """The thread that tries waiting tasks each _AGAIN_S; it ends once all are done."""
        while not self._closed.wait(_AGAIN_S):
            with self._lock:
                while self._again:
                    first = next(iter(self._again))
                    if not self._try_task(*first):
                        break
                    self._again.discard(first)
                else:
                    self._trying = None
                    return

    # --- what machines tell

    @complain_of_errors
    def _take_message(self, client, userdata, message):
        """Take a machine's message; a signed one becomes a task on the book. Publishes another nonce if a message is older than the last."""
        _root, name, topic = message.topic.split("/")
        text = message.payload.decode(errors="replace")
        with self._lock:
            if topic != "work":
                before = self._heard.note_topic(name, topic, text)
                if topic == "state" and before in _AWAY:  # it may have been released meanwhile, or have said so before it said that it is back
                    self.look(name)
                return
            told = self._heard.open(name, text)
            told = told and read_told(told)
            if told:
                self._told[name] = told
                self.machines[name].update(told)
                self._do_or_retry(_WORD, name)
            if self._heard.missed:  # the broker tells all again
                self._heard.missed = False
                self._subscribe_topics()
            if self._heard.stale and not self._renewing:
                self._renewing = threading.Timer(_RENEW_S, self._renew_nonce)
                self._renewing.daemon = True
                self._renewing.start()

    @complain_of_errors
    def _renew_nonce(self):
        """Publish another nonce, for which machines sign their state anew."""
        with self._lock:
            self._renewing = None
            self._nonce = make_nonce()
            self._heard.renew(self._nonce)
            self._client.publish(f"{ROOT}/{SHOP}", self._nonce, 1, True)

    def _compare_book(self, name):
        """Compare a machine's last message with the book: end, follow or order its job, or give it a new one. Raises JobTableError."""
        book, told = self._book, self._told[name]
        for job_id in (told["job"], *(told["ended"] or ())[:1]):
            book.reopen_job(job_id, name)
        job = book.open_of(name)
        if told["ended"] and job and told["ended"][0] == job.id:
            book.end(job, *told["ended"][1:])
            self._forget_order(name, job)
            job = None
        if job and told["job"] == job.id:
            self._forget_order(name)
            book.note_progress(job, _STATES.get(told["how"], GIVEN), told["line"], told["text"])
        elif job:
            self._order_job(name, job, told["nonce"])
        elif told["how"] == "free":
            self._give_jobs(name)

    def end(self, job_id):
        """End a job whose machine is not reached, for somebody who has looked at the machine. Returns 0 or an error."""
        with self._lock:
            job = self._book.job_by_id(job_id)
            if job is None or job.state not in OPEN:
                return errors.NO_SUCH_JOB
            if is_reached(self.machines.get(job.machine)):
                return errors.BUSY
            self._book.end(job, LEFT, job.line, _("ended on the shop's page: {} was not reached", job.machine))
            self._forget_order(job.machine, job)
        return 0

    def look(self, only=None):
        """Give jobs to the machines that are released: to one, or after the queue has grown."""
        with self._lock:
            self._do_or_retry(_QUEUE, only)

    def _give_jobs(self, only):
        """Give a job to each machine that is released, or to `only` that one. Raises JobTableError."""
        for name, told in self.machines.items():
            if only in (None, name) and told.get("how") == "free" and told.get("state") not in _AWAY:
                job = self._book.give_job(name, told["nonce"], lambda job, told=told: job_fits(job, told))
                if job:
                    self._order_job(name, job, told["nonce"])

    # --- orders

    def _order_job(self, name, job, to):
        """Publish a job's file and the order for it, signed for the nonce `to`. Raises JobTableError."""
        parts = -(-len(self._book.file_data(job.sha)) // PIECE)
        if job.sha not in self._files:
            self._publish_file(job.sha)
            self._files.add(job.sha)
        body = {"id": job.id, "name": job.name, "sha": job.sha, "parts": parts, "again": to != job.nonce, "begun": job.begun is not None}
        text = self._ordered[name] = sign_message(self._key, FROM_SHOP, to, 1, body)
        self._client.publish(f"{ROOT}/{name}/{ORDER}", text, 1, True)

    def _forget_order(self, name, job=None):
        """Withdraw an order from the broker: the machine has taken it. `job`: it has ended, so withdraw its file too, unless another has it."""
        if self._ordered.pop(name, None) is not None:
            self._client.publish(f"{ROOT}/{name}/{ORDER}", "", 1, True)
        if job and not self._book.has_open_job(job.sha):
            for number in range(-(-len(self._book.file_data(job.sha)) // PIECE)):
                self._client.publish(f"{ROOT}/{FILE}/{job.sha}/{number}", b"", 1, True)
            self._files.discard(job.sha)

    def _publish_file(self, sha):
        """Publish a job's file in pieces of PIECE bytes, retained. Raises JobTableError."""
        data = self._book.file_data(sha)
        for number in range(-(-len(data) // PIECE)):
            self._client.publish(f"{ROOT}/{FILE}/{sha}/{number}", data[number * PIECE : (number + 1) * PIECE], 1, True)

"""A small HTTP server inside the main loop: a request at a time for the machine, files, and pushed events.

    server = Server(listener, files, guard, clock_ms, legacy)
    server.poll(now_ms)             # once a cycle
    request = server.read()         # polls, too; for the language: number, flags, path and body; b"" if there is none
    server.write(b"…")              # its answer: the number, and what it says
    server.sockets[b"/ws"] = owner  # WebSockets: owner.open(), .take_message() and .forget_connection(), see page_line.py
    server.calls[b"/stop"] = stop   # POST: stop(body) gives the answer, JSON

Microdot and asyncio would take more memory than a Pico W has beside the machine, and a main loop of their own. This one does a
bounded piece of work a call: it takes one connection, and goes on with two. It holds at most SLOTS requests, PAGES pages that
events are pushed to, and as many WebSockets as their owners admit; one more takes the place of the oldest request that is not
whole, or of an answer of which nothing has been taken for a second, so slow ones keep nobody out.
"""

import socket as sockets
from select import POLLIN, POLLOUT, poll

from micropython import const

from passo.records import COUNT_MASK, REQUEST_JSON, REQUEST_PROVEN
from passo.web.connection import ANSWERED, ASKED, BODY, EVENTS, HEAD, SOCKET, Connection
from passo.web.websocket import CLOSE, PING, PONG, frame

SLOTS = const(6)  # as many as a browser opens at once
PAGES = const(2)
_STEPS = const(2)  # connections that are gone on with in one call
_WHOLE_MS = const(3000)  # by then a request is whole, and answered
_LOOK_MS = const(50)  # between two searches for connections that take too long
_SENT_MS = const(10_000)  # and its answer has been taken
_UNREAD_MS = const(1000)  # one of which nothing is taken makes room
_ALIVE_MS = const(2000)  # a WebSocket without a sign of life is asked for one
_GONE_MS = const(8000)  # and given up
_PUSH_MS = const(170)  # a pass of the main loop comes on top: five pushes a second, or more
_PUSHED = const(255)  # the number of the request whose answer is pushed
_MOST_S = const(60)  # requests a second for the machine
_BEGIN = b'<!doctype html><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>Passo</title><link rel="icon" href="data:,"><pre id="answer">'
_BUSY = b"too many requests\n"
_STOPPED = b"dropped: the machine was stopped\n"


class Server:
    def __init__(self, listener, files, guard, clock_ms, legacy):
        """`listener`: a socket that listens; `files`: a Folder; `guard`: checks requests; `clock_ms()`: the links' clock; `legacy`: clients
        without a key may be admitted.
        """
        listener.setblocking(False)
        self._listener = listener
        self._listener_fd = listener.fileno() if hasattr(listener, "fileno") else None
        self._poll = poll()
        self._poll.register(listener, POLLIN)
        self._ready = self._poll.ipoll if hasattr(self._poll, "ipoll") else self._poll.poll  # ipoll makes no list
        self._found = []
        self.files = files
        self._guard = guard
        self._clock_ms = clock_ms
        self._legacy = legacy
        self._posts = self._gets = ()
        self._page = None
        self.sockets = {}  # path: owner
        self.calls = {}  # path: function
        self.connections = []
        self._requests = []
        self._number = 0
        self._now_ms = self._looked_ms = 0
        self._pushed_ms = 0
        self._pushing = False
        self._second_ms = 0
        self._count = 0

    # --- the app's side: a line of requests and answers

    def join(self, link, controller):
        """The language of `link` answers requests: it says which paths, and its GETS begin with the one that is shown at / and pushed to
        pages; its PAGE is the file of the folder that stands behind each answer in HTML."""
        protocol = link.protocol
        self._guard.set_admission(controller.features["admission"].is_admitted if self._legacy else None, protocol.FREE, protocol.KEYED)
        self._posts, self._gets, self._page = protocol.POSTS, protocol.GETS, protocol.PAGE

    def any(self):
        return bool(self._requests)

    def read(self):
        """Return the next request for the language: number, flags, path and body; b"": none."""
        self.poll(self._clock_ms())
        return self._requests.pop(0) if self._requests else b""

    def write(self, data):
        """Send the language's answer to the request of its number, or to all pages that get events."""
        number = data[0]
        data = data[1:]
        if number == _PUSHED:
            self._pushing = False
            for connection in self.connections:
                if connection.state == EVENTS and connection.send_event(data):
                    self.send(connection)
            return
        for connection in self.connections:
            if connection.number == number and connection.state == ASKED:
                more = self._guard.headers()
                if connection.json:
                    connection.answer(200, b"application/json", data, more)
                else:
                    body = _BEGIN + data + b"</pre>\n"
                    connection.answer(200, b"text/html; charset=utf-8", body, more, self.files.path + self._page, 0, self.files.file_size(self._page))
                self.send(connection)
                return

    # --- the network's side

    def poll(self, now_ms):
        """Accept a connection, advance _STEPS connections at most, drop those that take too long. Call it once a cycle."""
        self._now_ms = now_ms
        steps = _STEPS
        for ready in self._ready(0):
            self._found.append(ready[0])
        while self._found:
            found = self._found.pop()
            if found is self._listener or found == self._listener_fd:
                self._accept_connection(now_ms)
            elif steps:
                steps -= 1
                for connection in self.connections:
                    if connection.socket is found or connection.fd == found:
                        self._advance_connection(connection, now_ms)
                        break
        if (now_ms - self._looked_ms) & COUNT_MASK >= _LOOK_MS:
            self._looked_ms = now_ms
            for connection in self.connections:
                if self._takes_too_long(connection, now_ms):
                    self.drop(connection)
                    break
        if self._gets and not self._pushing and (now_ms - self._pushed_ms) & COUNT_MASK >= _PUSH_MS and self._count_pages():
            self._pushed_ms = now_ms
            self._pushing = True
            self._requests.append(bytes((_PUSHED, REQUEST_JSON)) + self._gets[0])

    def _takes_too_long(self, connection, now_ms):
        """True if a connection has taken too long for its request, its answer or a sign of life. Pings a silent WebSocket."""
        waited = (now_ms - connection.since_ms) & COUNT_MASK
        if connection.state == SOCKET:
            silent = (now_ms - connection.heard_ms) & COUNT_MASK
            if silent > _ALIVE_MS and not connection.asked:
                connection.asked = True
                self.send(connection, frame(PING, b""))
            return silent > _GONE_MS or waited > _SENT_MS and connection.is_sending()
        if connection.state == EVENTS:
            return waited > _SENT_MS and connection.is_sending()
        return waited > (_SENT_MS if connection.state == ANSWERED else _WHOLE_MS)

    def select_list(self):
        """The sockets that select() is to wait for."""
        return [self._listener] + [each.socket for each in self.connections if each.state in (HEAD, BODY, SOCKET)]

    def close(self):
        """Drop all connections, and stop to listen."""
        for connection in list(self.connections):
            self.drop(connection)
        self._listener.close()

    def _count_pages(self):
        return len([1 for each in self.connections if each.state == EVENTS])

    def _accept_connection(self, now_ms):
        """Accept a connection. If SLOTS are taken, drop one whose request is not whole or that reads nothing; else leave it waiting."""
        if len([1 for each in self.connections if each.state < EVENTS]) >= SLOTS:  # the others are pages
            for connection in self.connections:
                unread = connection.state == ANSWERED and (now_ms - connection.taken_ms) & COUNT_MASK > _UNREAD_MS
                if connection.state in (HEAD, BODY) or unread:
                    self.drop(connection)
                    break
            else:
                return
        try:
            socket, address = self._listener.accept()
        except OSError:
            return
        socket.setblocking(False)
        if hasattr(sockets, "TCP_NODELAY"):  # an answer does not wait for bytes pushed before it
            socket.setsockopt(sockets.IPPROTO_TCP, sockets.TCP_NODELAY, 1)
        connection = Connection(socket, address[0], now_ms)
        self.connections.append(connection)
        self._poll.register(socket, POLLIN)
        self._advance_connection(connection, now_ms)

    def _advance_connection(self, connection, now_ms):
        """Do the next piece of work of a connection: receive, answer or send. Drops one that has gone or is wrong."""
        try:
            if connection.state in (HEAD, BODY):
                if connection.receive():
                    self._answer_request(connection, now_ms)
            elif connection.state == SOCKET:
                for kind, data in connection.receive():
                    connection.heard_ms = now_ms
                    connection.asked = False
                    if kind == PING:
                        self.send(connection, frame(PONG, data))
                    elif kind == CLOSE or kind != PONG and not connection.owner.take_message(connection, data, now_ms):
                        raise OSError(0)
                if connection.waits:
                    self.send(connection)
            elif connection.state == ASKED:
                return  # the answer is still to come; send() notices a client that has gone
            elif connection.is_sending():
                self.send(connection)
            else:
                connection.socket.recv(64)  # of events only the end is of interest
                self.drop(connection)
        except (OSError, ValueError, MemoryError):
            self.drop(connection)

    def send(self, connection, data=b""):
        """Send `data` after the bytes that wait: at once as many as the network takes, the rest later."""
        if not connection.waits:
            connection.taken_ms = self._now_ms
        try:
            more = connection.send(self._now_ms, data)
        except OSError:
            self.drop(connection)
            return
        if more != connection.waits:
            connection.waits = more
            self._poll.modify(connection.socket, (POLLIN | POLLOUT if connection.state == SOCKET else POLLOUT) if more else POLLIN)
        if connection.state == ANSWERED and not more:
            self.drop(connection)

    def drop(self, connection):
        """Close a connection, and tell the owner of its WebSocket."""
        if connection in self.connections:
            self._poll.unregister(connection.socket)
            self.connections.remove(connection)
            connection.close()
            if connection.owner:
                connection.owner.forget_connection(connection)

    # --- a request that is whole

    def _answer_request(self, connection, now_ms):
        """Answer a whole request: an error, a call, a WebSocket, a file, or by the language."""
        path = connection.path
        owner = self.sockets.get(path)
        status = connection.wrong or self._guard.refusal_status(connection, owner and owner.browser)
        if status:
            self._answer_status(connection, status)
        elif path in self._posts or path in self._gets:
            self._queue_request(connection, path, now_ms)
        elif path in self.calls and connection.method == b"POST":
            connection.answer(200, b"application/json", self.calls[path](connection.body))
            self.send(connection)
        elif owner and connection.key:
            self._open_socket(connection, owner, now_ms)
        else:
            self._answer_file(connection, path, now_ms)

    def _open_socket(self, connection, owner, now_ms):
        """Make a connection the WebSocket of `owner`; 503 if it admits no more."""
        hello = owner.open(connection, now_ms)
        if hello is None:
            self._answer_status(connection, 503)
            return
        connection.begin_socket(owner)
        connection.since_ms = connection.heard_ms = now_ms
        self.send(connection, hello)

    def _answer_file(self, connection, path, now_ms):
        """Answer with a file, with the first GET's answer for /, or with events for /EVENTS."""
        found = self.files.find_file(path)
        if not found and not (self._gets and path in (b"/", b"/EVENTS")):
            self._answer_status(connection, 404)
        elif connection.method != b"GET":
            self._answer_status(connection, 405)
        elif found:
            kind, more, file, start, size = found
            connection.answer(200, kind, b"", more, file, start, size)
            self.send(connection)
        elif path == b"/":
            self._queue_request(connection, self._gets[0], now_ms)
        elif self._count_pages() >= PAGES:
            self._answer_status(connection, 503)
        else:
            connection.begin_events()
            self.send(connection)

    def _queue_request(self, connection, path, now_ms):
        """Queue a request for the language, a STOP before all others; 503 if there are too many."""
        if (connection.method == b"POST") != (path in self._posts) or connection.method not in (b"POST", b"GET"):
            self._answer_status(connection, 405)
            return
        if (now_ms - self._second_ms) & COUNT_MASK >= 1000:
            self._second_ms = now_ms
            self._count = 0
        free = self._guard.is_free(path)
        if not free:
            self._count += 1
        if len(self._requests) >= SLOTS + 1 or self._count > _MOST_S and not free:
            self._answer_status(connection, 503)
            return
        self._number = self._number % (_PUSHED - 1) + 1
        connection.number = self._number
        flags = REQUEST_JSON if connection.json else 0
        if not free and self._guard.is_proven(connection, now_ms):
            flags |= REQUEST_PROVEN
        request = bytes((self._number, flags)) + path + b" " + connection.body
        if free:
            if path in self._posts:
                self._refuse_older(connection, now_ms)
            self._requests.insert(0, request)
        else:
            self._requests.append(request)

    def _refuse_older(self, connection, now_ms):
        """Refuse all proven requests that came before this STOP. If it has a proof, those still under way count as old, too."""
        if connection.proof:
            self._guard.is_proven(connection, now_ms)
        waiting, self._requests = self._requests, []
        for request in waiting:
            if request[1] & REQUEST_PROVEN:
                for each in self.connections:
                    if each.number == request[0] and each.state == ASKED:
                        self._answer_status(each, 409, _STOPPED)
                        break
            else:
                self._requests.append(request)

    def _answer_status(self, connection, status, body=b""):
        body = body or (_BUSY if status == 503 else b"%d\n" % status)
        connection.answer(status, b"text/plain", body)
        self.send(connection)

"""A link that pages speak on: served by the board itself, to the app a serial line like any other.

    line = PageLine(server, radio.key, clock_ms)
    line.join(link, controller)
    line.read(), line.write(data), line.any()

Messages that are signed, fresh and within the rate go to the language of pages (protocols/page), whose messages these are; its answers go to their pages.
"""

import json

from micropython import const

from passo import errors
from passo.protocols.page.orders import order_of
from passo.protocols.page.protocol import ALL, FIRST, FREE, GONE, MOST, PROVEN, TOLD
from passo.records import COUNT_MASK
from passo.web.pages import Pages, refusal_answer
from passo.web.websocket import TEXT, frame

_PUSH_MS = const(190)  # between two states, whatever a pass of the main loop takes: five a second
_PAGES = const(4)  # at once: each takes 2 to 4 kB
_STOP = b'{"do":"stop"}'
_STOPPED = b'{"t": "answer", "do": "stop", "error": 0}'


class PageLine:
    browser = True  # its WebSockets are opened by a page of this server

    def __init__(self, server, key, clock_ms):
        """`server`: a Server; `key`: text; `clock_ms()`: the links' clock."""
        self._server = server
        self._clock_ms = clock_ms
        self._messages = []  # (None, for the language), or (connection, an answer that waits for those before it)
        self._pushed_ms = 0
        self._number = 0
        self._language = None
        self._broker = None
        self.pages = Pages(key, _PAGES)
        server.sockets[b"/ws"] = self
        server.calls[b"/stop"] = self._stop_machine

    def join(self, link, controller):
        self._language = link.protocol

    def join_broker(self, broker):
        """Take a Broker, which gets the states for pages, too."""
        self._broker = broker

    # --- the app's side

    def any(self):
        return bool(self._messages)

    def read(self):
        """The next message for the language, or b""."""
        now_ms = self._clock_ms()
        if not self._messages:  # else who has more waits: none of them may pile up
            self._server.poll(now_ms)
        while self._messages:
            connection, message = self._messages.pop(0)
            if connection is None:
                return message
            if connection.page:
                self._server.send(connection, message)
        late_ms = (now_ms - self._pushed_ms) & COUNT_MASK
        wanted = self._broker and self._broker.poll(now_ms)
        if self._messages or late_ms < _PUSH_MS or not (self.pages.pages or wanted):
            return b""
        self._pushed_ms = now_ms if late_ms >= 2 * _PUSH_MS else (self._pushed_ms + _PUSH_MS) & COUNT_MASK
        return bytes((ALL, len(self.pages.pages)))

    def write(self, data):
        """Send the language's messages, separated by line feeds, to their pages, and the state to the broker."""
        for message in bytes(data).split(b"\n"):
            number = message[0]
            if number == ALL:
                self._push_state(message[1], frame(TEXT, message[2:]))
                if self._broker:
                    self._broker.publish_state(message[2:])
            elif number == TOLD:
                self.pages.tell(frame(TEXT, message[2:]))
            else:
                for page in self.pages.pages:
                    if page.number == number:
                        self._server.send(page.socket, frame(TEXT, message[2:]))
                        break

    def select_list(self):
        return self._server.select_list() + (self._broker.select_list() if self._broker else [])

    def close(self):
        """Close the broker's connection and the server."""
        if self._broker:
            self._broker.close()
        self._server.close()

    # --- the pages'

    def _push_state(self, version, state):
        """Send the state, a frame, to each page whose time has come, behind it the page's messages. Skips a page that is still sending."""
        now_ms = self._clock_ms()
        for page in list(self.pages.pages):
            if page.socket.is_sending():
                continue  # it is slower than this: the next state is as good
            said = b"".join(page.told)
            page.told = []
            if page.pace.is_due(version, now_ms):
                said = state + said
            if said:
                self._server.send(page.socket, said)

    def open(self, connection, now_ms):
        """Add a page for a WebSocket, and return its first message; None: there are too many. Drops a page that has proven nothing to make room."""
        if self.pages.is_full():
            for page in self.pages.pages:
                if not page.session.opened:
                    self._server.drop(page.socket)
                    break
        page = connection.page = self.pages.add_page(connection, self._language.first_message(), now_ms)
        if page is None:
            return None
        page.number = FIRST + self._number
        self._number = (self._number + 1) % MOST
        hello = message_frame(page.hello)
        page.hello = None  # it has done its duty
        return hello

    def take_message(self, connection, data, now_ms):
        """Take a message of a page. Returns False if the page must be closed. Raises ValueError if it is no text."""
        page = connection.page
        if page is None:
            return False
        text, proven = self.pages.open(page, data.decode(), now_ms)
        answer = proven if text is None else self._answer_look(page, text) if '"look"' in text else None
        if answer is not None:
            self._messages.append((connection, message_frame(answer)))
        elif text is not None:
            self._messages.append((None, bytes((page.number, PROVEN if proven else FREE)) + text.encode()))
        return answer is not None or text is not None

    def _answer_look(self, page, text):
        """Return the answer, if the order sets how often the page gets the state."""
        try:
            return self.pages.look(page, order_of(text))
        except ValueError:
            return None  # the language answers

    def forget_connection(self, connection):
        """Remove the page of a connection that has ended, and tell the language."""
        page, connection.page = connection.page, None
        if page:
            self.pages.remove_page(page)
            self._messages.append((None, bytes((page.number, GONE))))

    def stop(self, *_):
        self._stop_machine(b"")

    def _stop_machine(self, body):
        """Queue a STOP that came by a request of its own, and refuse the orders that pages sent before it. Returns the answer, JSON."""
        self.pages.refuse_older(body)
        self._messages = [message for message in [self._rest_after_stop(*message) for message in self._messages] if message]
        self._messages.insert(0, (None, bytes((FIRST + MOST, FREE)) + _STOP))
        return _STOPPED

    def _rest_after_stop(self, connection, message):
        """Return a waiting message as it is after a STOP: a proven order becomes its refusal; None: its page has gone."""
        if connection is not None or message[1] != PROVEN:
            return connection, message
        for page in self.pages.pages:
            if page.number == message[0]:
                return page.socket, message_frame(refusal_answer(errors.STOPPED))
        return None


def message_frame(message):
    """The WebSocket frame of a message, a dict, as bytes."""
    return frame(TEXT, json.dumps(message).encode())

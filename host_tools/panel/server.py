"""The page and its orders over HTTP and WebSocket, with microdot.

    server = Server(api, key, names, page)          # names: the Host names that it answers to
    await server.serve("127.0.0.1", 8080)

Requests are bounded in size, number and time; Host and Origin must be this server's. A WebSocket brings state and answers to the
page, and orders from it; one that ends, ends its jog.

Idle connections keep nobody out: a new one takes the place of the oldest whose request is not whole, then of the oldest that does not
read its answer; a new page takes the place of a page that has proven nothing. The server pings a silent page, and closes it if no sign of
life comes. The bounds are those of a board's own server (passo/web/http.py).
"""

import asyncio
import json
import os
import time
from concurrent.futures import ThreadPoolExecutor
from ipaddress import ip_address

from host_tools.build.pages import error_list, page_words
from host_tools.page.slow_order import SlowOrder
from host_tools.page.pages import PanelPages
from host_tools.site import offline
from microdot import Microdot, Request, Response
from microdot.websocket import WebSocket, WebSocketError, websocket_upgrade
from passo import errors
from passo.records import COUNT_MASK
from passo.web.guard import is_own_request

_LOOK_S = 0.01
PUSH_MS = 50
_CONNECTIONS = 24
_PAGES = 8
_REQUEST_S = 5  # a request's head and body
_ANSWER_S = 10  # and its answer has been taken
_UNREAD_S = 1  # an answer of which nothing is taken makes room
_ALIVE_MS = 2000  # a page without a sign of life is asked for one
_GONE_MS = 8000  # and given up
_HEAD_BYTES = 8192
_MESSAGE_BYTES = 49_152
_BODY_BYTES = 4096
_UNSENT = 65_536  # of a page that does not read
_TYPES = {"html": "text/html; charset=utf-8", "js": "text/javascript; charset=utf-8", "css": "text/css; charset=utf-8",
          "svg": "image/svg+xml", "json": "application/json"}  # fmt: skip
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self';"
    " manifest-src 'self'; worker-src 'self';"
    " base-uri 'none'; form-action 'self'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}


def clock_ms():
    """Milliseconds modulo 2²⁹."""
    return int(time.monotonic() * 1000) & COUNT_MASK


class Bounded:
    """A reader whose request must be whole in time, and no longer than allowed."""

    def __init__(self, reader, transport):
        self._reader = reader
        self._left = _HEAD_BYTES + _BODY_BYTES
        self._deadline = time.monotonic() + _REQUEST_S
        self.transport = transport
        self.open = False  # a WebSocket: without an end
        self.whole_s = None  # when the request was whole
        self.heard_ms = clock_ms()  # when something has come
        self.asked = False  # for a sign of life

    async def _read_in_time(self, coroutine, count):
        """Return what `coroutine` reads. Raises OSError once a request is too long, or TimeoutError if it is not whole within _REQUEST_S."""
        if self.open:
            data = await coroutine
            self.heard_ms = clock_ms()
            self.asked = False
            return data
        left = self._deadline - time.monotonic()
        if left <= 0 or self._left <= 0:
            coroutine.close()
            raise OSError(errors.BUSY)
        data = await asyncio.wait_for(coroutine, left)
        self._left -= len(data)
        return data

    async def readline(self):
        return await self._read_in_time(self._reader.readline(), 0)

    async def readexactly(self, count):
        return await self._read_in_time(self._reader.readexactly(count), count)

    async def read(self, count=-1):
        return await self._read_in_time(self._reader.read(count), count)


class App(Microdot):
    """Microdot with bounds around it."""

    def __init__(self):
        super().__init__()
        self._connections = []  # readers, the oldest first

    def _make_room(self):
        """Make room for one more connection. Returns False if there is none: all the others are being answered."""
        asking = [each for each in self._connections if not each.open]
        if len(asking) < _CONNECTIONS:
            return True
        late_s = time.monotonic() - _UNREAD_S
        for each in [each for each in asking if each.whole_s is None] + [each for each in asking if each.whole_s and each.whole_s < late_s]:
            each.transport.abort()
            self._connections.remove(each)
            return True
        return False

    async def handle_request(self, reader, writer):
        """Serve one connection, within the bounds. Its errors end it, and nothing else."""
        transport = writer.transport
        if not self._make_room():
            transport.abort()
            return
        bounded = Bounded(reader, transport)
        self._connections.append(bounded)
        try:
            await self._handle_request(bounded, writer)
        except (Exception, asyncio.CancelledError):  # of one connection: torn, late, oversized. It ends, and nothing else does
            pass
        finally:
            if bounded in self._connections:
                self._connections.remove(bounded)
            try:
                writer.close()
            except OSError:
                pass

    async def _handle_request(self, reader, writer):
        """Read a request, dispatch it, and send the answer within _ANSWER_S."""
        request = await Request.create(self, reader, writer, writer.get_extra_info("peername"))
        if request is None:
            return
        reader.whole_s = time.monotonic()
        response = await self.dispatch_request(request)
        if response != Response.already_handled:
            await asyncio.wait_for(response.write(writer), _ANSWER_S)
            await asyncio.wait_for(writer.aclose(), _ANSWER_S)


class Server:
    def __init__(self, api, key, names, folder, about=None, pages=None, files=None):
        """`api`: an Orders; `names`: host names (without port) that a request may name; `folder`: the page's files; `about`: more for
        the first message to a page; `pages` and `files` {name: path} replace the panel's own; then files are sent without the changes for use offline."""
        self.pages = pages or PanelPages(api, key, _PAGES)
        self.api = api
        self._names = {name.encode() for name in names}
        self._about = about or {}
        self._files = files or {name: folder + "/" + name for name in os.listdir(folder) if name.split(".")[-1] in _TYPES}
        self._as_they_are = files is not None
        self._offline = {}
        self._pushed_ms = clock_ms()
        self.app = App()
        self._worker = ThreadPoolExecutor(1)  # for work that takes a moment, one after the other
        self._maker = ThreadPoolExecutor(1)  # for work that may take minutes: drawings that become jobs, estimates
        self._making = []  # (name of the file, future) of those
        self._late = set()  # tasks of answers to it
        Request.max_content_length = Request.max_body_length = _BODY_BYTES
        Request.max_readline = _HEAD_BYTES // 4
        WebSocket.max_message_length = _MESSAGE_BYTES
        self._add_routes()

    # --- requests

    def _add_routes(self):
        """Add the server's paths: the page's files, /ws, /stop, /errors.json."""
        app = self.app

        @app.before_request
        async def check_host(request):
            if not self._is_own_request(request):
                return "wrong host", 403

        @app.after_request
        async def add_headers(request, response):
            for name in HEADERS:
                response.headers[name] = HEADERS[name]

        @app.get("/")
        async def send_index(request):
            return self._file_response("index.html")

        @app.get("/ws")
        async def open_socket(request):
            return await self._serve_page(request)

        @app.post("/stop")
        async def stop(request):
            """Stop the machine. Refuses a request older than the last; slow work runs in a thread."""
            self.pages.refuse_older(request.body)
            answer = self.api.begin({"do": "stop"}, False)
            later = answer["error"]
            return self.api.finish(answer, await asyncio.to_thread(later.work)) if isinstance(later, SlowOrder) else answer

        @app.get("/errors.json")
        async def list_errors(request):
            return error_list()

        @app.get("/<name>")
        async def send_file(request, name):
            return self._file_response(name)

    def _is_own_request(self, request):
        host, origin = [request.headers.get(name, "").lower().encode() or None for name in ("Host", "Origin")]
        return is_own_request(host, origin, self._names, request.path == "/ws")

    def _file_response(self, name):
        """Return the response with a file of the page, or 404."""
        data = self._file_data(name)
        if data is None:
            return "not here", 404
        return Response(data, 200, {"Content-Type": _TYPES[name.split(".")[-1]]})

    def _file_data(self, name):
        """The bytes of a file, as they are now; None: there is no such file."""
        if name in offline.NAMES and not self._as_they_are:
            if not self._offline:
                served = {each: self._file_data(each) for each in self._files}
                self._offline = offline.make_files({**served, "errors.json": json.dumps(error_list()).encode()}, "network")
            return self._offline[name]
        path = self._files.get(name)
        if path is None:
            return None
        if name == "pt.json" and not self._as_they_are:
            return json.dumps(page_words(), ensure_ascii=False).encode()
        with open(path, "rb") as file:
            data = file.read()
        return offline.add_to_page(data.decode()).encode() if name == "index.html" and not self._as_they_are else data

    # --- a page

    async def _serve_page(self, request):
        """Serve a page's WebSocket until it ends; 503 if there are too many pages."""
        if self.pages.is_full() and not self._drop_unproven():
            return "too many pages", 503
        socket = await websocket_upgrade(request)
        request.sock[0].open = True
        page = self.pages.add_page(socket, self.pages.first_fields(self._about), clock_ms(), not ip_address(request.client_addr[0]).is_loopback)
        try:
            answer = page and page.hello
            while answer is not None:
                if isinstance(answer.get("error"), SlowOrder):
                    task = asyncio.ensure_future(self._finish_order(page, answer))
                    self._late.add(task)
                    task.add_done_callback(self._late.discard)
                else:
                    await socket.send(json.dumps(answer))
                data = await socket.receive()
                answer = self.pages.answer_message(page, data, clock_ms()) if isinstance(data, str) else None
        except (OSError, WebSocketError, ValueError, EOFError):
            pass
        finally:
            if page:
                self.pages.remove_page(page)
        return Response.already_handled

    def run_beside(self, work):
        """Return a future of work(), done in a thread while the loop goes on."""
        return asyncio.get_running_loop().run_in_executor(self._worker, work)

    async def result_of(self, later):
        """Return the result of a SlowOrder's work, done in a thread. A slow one delays only orders for the same job."""
        if not later.slow:
            waits = [future for name, future in self._making if later.waits_for(name)]
            if waits:
                await asyncio.wait(waits)
            return await self.run_beside(later.work)
        made = later.job, asyncio.get_running_loop().run_in_executor(self._maker, later.work)
        self._making.append(made)
        try:
            return await made[1]
        finally:
            self._making.remove(made)

    async def _finish_order(self, page, answer):
        """Answer an order once its work is done; meanwhile the page may say something else."""
        try:
            try:
                answer = self.pages.finish(page, answer, await self.result_of(answer["error"]))
            except OSError:  # a full disk
                answer = {**answer, "error": errors.NOT_WRITTEN}
            if answer is not None:
                await page.socket.send(json.dumps(answer))
        except BaseException:
            self._drop_page(page)
            raise

    def _drop_unproven(self):
        """Close the oldest page that has proven nothing. Returns False if there is none."""
        for page in self.pages.pages:
            if not page.session.opened:
                self._drop_page(page)
                return True
        return False

    def _drop_page(self, page):
        page.socket.request.sock[0].transport.abort()
        self.pages.remove_page(page)

    def _is_alive(self, page, now_ms):
        """Return False if a page has given no sign of life for _GONE_MS. Pings it after _ALIVE_MS."""
        reader, writer = page.socket.request.sock[:2]
        silent_ms = (now_ms - reader.heard_ms) & COUNT_MASK
        if silent_ms > _GONE_MS:
            return False
        if silent_ms > _ALIVE_MS and not reader.asked:
            reader.asked = True
            writer.write(bytes(WebSocket._encode_websocket_frame(WebSocket.PING, b"")))
        return True

    def _forgive_silence(self, now_ms):
        """Count each page's silence anew if the panel itself stood still, and so has asked for no sign of life."""
        stood_ms = (now_ms - self._pushed_ms) & COUNT_MASK
        self._pushed_ms = now_ms
        if stood_ms > _ALIVE_MS:
            for page in self.pages.pages:
                reader = page.socket.request.sock[0]
                reader.heard_ms, reader.asked = now_ms, False

    def change_machine(self, api, about):
        """Serve another machine from now on, and send its first message to all pages."""
        self.api = self.pages.api = api
        self._about = about
        self.pages.tell({"t": "machine", **self.pages.first_fields(about)})

    async def push_state(self, now_ms):
        """Send each page the state, as often as it wants it, and its waiting messages. Closes a page that does not read, or gives no sign of life."""
        text = self.pages.next_state(now_ms)
        self._forgive_silence(now_ms)
        for page in list(self.pages.pages):
            writer = page.socket.request.sock[1]
            transport = getattr(writer, "transport", None)
            if transport is not None and transport.get_write_buffer_size() > _UNSENT or not self._is_alive(page, now_ms):
                self._drop_page(page)
                continue
            told, page.told = page.told, []
            for each in [text] * page.pace.is_due(self.pages.version, now_ms) + [json.dumps(event) for event in told]:
                try:
                    writer.write(bytes(WebSocket._encode_websocket_frame(WebSocket.TEXT, each)))
                except (OSError, RuntimeError):
                    break

    async def serve(self, host, port):
        """Listen and serve until the task is cancelled. Raises OSError if the port is in use."""
        await self.app.start_server(host=host, port=port)

    async def wait_for_port(self, serving):
        """Wait until `serving`, the task of serve(), listens, and return its port. Raises what serve() has raised."""
        while not getattr(self.app, "server", None):
            if serving.done():
                serving.result()
            await asyncio.sleep(_LOOK_S)
        return self.app.server.sockets[0].getsockname()[1]

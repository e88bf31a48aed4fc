"""The page on the machine's own PC: the person at the machine says "paper is in", go on, give up.

    close, port = serve(8091, key, machines, do, stop)  # machines(): a list of dicts; do(name, what), stop(name): "" or why not

It is served at 127.0.0.1 only, to this PC's own page: a page of another site has another Origin, or another Host, and is refused. Any program
of this PC can reach it, so an order is proven by a key as one to a board is (passo/web/guard.py); STOP is not.
"""

import asyncio
import json
import threading
from pathlib import Path
from types import SimpleNamespace

from host_tools.failure import Failure, reason
from host_tools.language import error_text, in_languages
from host_tools.panel.server import HEADERS, App, clock_ms
from host_tools.resources import FIRMWARE
from microdot import Request, Response
from passo import errors
from passo.protocols.page.orders import order_of
from passo.web.guard import Guard, is_own_request, make_nonce

_OWN = Path(__file__).parent / "page"
_SHARED = FIRMWARE / "passo" / "web" / "page"
_NAMES = (b"127.0.0.1", b"localhost")
_TYPES = {"html": "text/html; charset=utf-8", "js": "text/javascript; charset=utf-8", "css": "text/css; charset=utf-8", "json": "application/json", "svg": "image/svg+xml"}
_FILES = {
    **{name: _OWN for name in ("machine.html", "machine.js", "tiles.js", "shop.css", "pt.json")}, **{name: _SHARED for name in ("panel.css", "titles.js", "words.js", "sha256.js", "icon.svg")},
}  # fmt: skip
_MOST_BYTES = 4096


def make_app(key, machines, do, stop):
    """Make the web application of the page; arguments as for serve()."""
    app = App()
    guard = Guard(_NAMES, key, make_nonce(), lambda peer: False)
    Request.max_content_length = Request.max_body_length = _MOST_BYTES

    def request_header(request, name):
        return request.headers.get(name, "").lower().encode() or None

    def file_response(name):
        if name not in _FILES:
            return "not here", 404
        return Response((_FILES[name] / name).read_bytes(), 200, {"Content-Type": _TYPES[name.split(".")[-1]]})

    @app.before_request
    async def check_host(request):
        if not is_own_request(request_header(request, "Host"), request_header(request, "Origin"), _NAMES, request.method == "POST"):
            return "wrong host", 403

    @app.after_request
    async def add_headers(request, response):
        """Add the page's own headers and those of the guard to a response."""
        response.headers.update(HEADERS)
        for line in guard.headers().decode().splitlines():
            name, _, value = line.partition(": ")
            response.headers[name] = value

    @app.get("/")
    async def send_index(request):
        return file_response("machine.html")

    @app.get("/machines")
    async def list_machines(request):
        found = [each | {key: in_languages(each.get(key, "")) for key in ("text", "alarm")} for each in await asyncio.to_thread(machines)]
        return json.dumps(found), 200, {"Content-Type": "application/json"}

    @app.get("/<name>")
    async def send_file(request, name):
        return file_response(name)

    @app.post("/do")
    async def carry_out(request):
        """Carry out an order of the page, {"name", "do"}: STOP without a proof, others with one."""
        try:
            body = order_of(request.body.decode())
            name, what = body["name"], body["do"]
        except (ValueError, LookupError, TypeError):
            return {"text": "no order"}, 400
        if not isinstance(name, str) or not isinstance(what, str):
            return {"text": "no order"}, 400
        if what == "stop":
            return {"text": in_languages(await asyncio.to_thread(stop, name))}
        proof = (request.headers.get("X-Passo") or "").encode()
        signed = SimpleNamespace(proof=proof, peer=None, method=b"POST", path=b"/do", body=request.body)
        if not guard.is_proven(signed, clock_ms()):
            return {"text": in_languages(error_text(errors.NO_SESSION))}, 403
        return {"text": in_languages(await asyncio.to_thread(do, name, what))}

    return app


def serve(port, key, machines, do, stop):
    """Serve the page from a thread; returns (the function that ends it, port). Raises Failure if the port is in use."""
    app = make_app(key, machines, do, stop)
    loop = asyncio.new_event_loop()
    ready, failed, opened = threading.Event(), [], []

    async def listen():
        """Listen and serve until the task is cancelled."""
        try:
            server = await app.start_server("127.0.0.1", port, start_serving=False)
            await server.start_serving()
            opened.append(server.sockets[0].getsockname()[1])
        except OSError as error:
            failed.append(error)
            return
        finally:
            ready.set()
        async with server:
            await server.serve_forever()

    def run():
        """Serve the page in this thread until the task is cancelled, then close the loop."""
        task[0] = loop.create_task(listen())
        try:
            loop.run_until_complete(task[0])
        except asyncio.CancelledError:
            pass
        loop.close()

    task = [None]
    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    ready.wait()
    if failed:
        raise Failure("--at-machine {}: {}", port, reason(failed[0])) from failed[0]

    def close():
        loop.call_soon_threadsafe(task[0].cancel)
        thread.join(5)

    return close, opened[0]

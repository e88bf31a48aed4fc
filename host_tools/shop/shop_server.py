"""`passo shop`: one page of all machines, served as that of a panel is (host_tools/panel/server.py): orders are signed, STOP needs no key.

    shop = Shop(dispatcher, book, key, host)
    await shop.run("127.0.0.1", 8090, ready)
"""

import asyncio
import json
import signal
import time
from pathlib import Path

from host_tools.failure import Failure, reason
from host_tools.language import _, in_languages
from host_tools.page.slow_order import SlowOrder
from host_tools.page.pages import ServedPages
from host_tools.panel.panel import FOLDER, names_of
from host_tools.panel.server import PUSH_MS, Server, clock_ms, error_list
from host_tools.shop import uploads
from host_tools.shop.job_table import OPEN, JobTableError
from host_tools.shop.dispatcher import LASER_CLASSES, is_reached
from host_tools.shop.link import wrong_message
from microdot import Response
from passo import errors
from passo.protocols.page.orders import Wrong, number_field, text_field

_OWN = Path(__file__).parent / "page"
_SHARED = ("panel.css", "titles.js", "words.js", "link.js", "sha256.js", "gcode_path.js", "program.js", "icon.svg")
_PAGES = 30
_MOST_COPIES = 200
_PIECE = 32_768
_SHOWN = 300  # jobs
_HEARD_S = 15.0  # every machine that is there has told by then, or is gone
_TRIES, _AGAIN_S = 10, 0.5  # to write a job into the book
_READ_AGAIN_S = 1.0  # a book that could not be read
_TOLD = ("how", "job", "line", "kind", "tool", "laser", "page", "language", "state", "progress", "left")
_SAID = ("text", "alarm")  # in the language of the agent: a page has its own


class ShopPages(ServedPages):

    def __init__(self, shop, key):
        ServedPages.__init__(self, key, _PAGES)
        self.version = None
        self._shop = shop

    def first_fields(self, more):
        return {"kinds": uploads.list_kinds()}

    def answer_order(self, page, order, proven):
        return self._shop.begin(order, proven, page)

    def finish(self, page, answer, result):
        return self._shop.finish(answer, result)

    def next_state(self, now_ms):
        """The state for all pages, JSON. `version` changes with more than progress and time left."""
        state = self._shop.page_state()
        self.version = json.dumps([state["jobs"], [{**each, "progress": "", "left": ""} for each in state["machines"]], state["trouble"], state["broker"], state["adrift"]])
        return json.dumps({"t": "state", **state})


class Shop:
    def __init__(self, dispatcher, book, key, host):
        self.dispatcher, self.book = dispatcher, book
        self._orders = {"drop": self._take_piece, "withdraw": self._withdraw_job, "again": self._queue_again, "end": self._end_job}
        self._coming = {}  # (page, name of the file): its text so far
        self._tasks = set()
        self._checks = asyncio.Lock()  # one file after the other: their order is that of the queue
        self._seen, self._jobs, self._counts, self._used = None, [], {}, []
        self._begun_s = time.monotonic()
        self._look_s = 0.0  # not before: the book could not be read
        files = {path.name: str(path) for path in _OWN.iterdir()} | {name: f"{FOLDER}/{name}" for name in _SHARED}
        self.server = Server(self, key, names_of(host), "", pages=ShopPages(self, key), files={**files, "index.html": files["shop.html"]})

        @self.server.app.get("/texts/refused.json")
        async def list_refusals(request):
            return {number: in_languages(text) for number, text in error_list().items()}

        @self.server.app.get("/job/<job_id>")
        async def send_program(request, job_id):
            """Return a job's file as text: 404 without such a job, 503 with the cause if the table of jobs fails."""
            try:
                job = book.job_by_id(job_id)
                data = job and book.file_data(job.sha)
            except JobTableError as error:
                return reason(error), 503
            if job is None:
                return "not here", 404
            return Response(data, 200, {"Content-Type": "text/plain; charset=utf-8"})

    # --- orders

    def answer_order(self, order, proven, page=None):
        answer = self.begin(order, proven, page)
        return self.finish(answer, answer["error"].work()) if isinstance(answer["error"], SlowOrder) else answer

    def begin(self, order, proven, page=None):
        """The answer to an order, a dict. For STOP, which waits for the broker, its "error" is a SlowOrder, and finish() returns the answer."""
        do = order.get("do") if isinstance(order, dict) else None
        if do == "stop":
            return {"t": "answer", "do": do, "error": SlowOrder(self.dispatcher.stop_all)}
        if not proven:
            return {"t": "answer", "do": str(do)[:20], "error": errors.NO_SESSION}
        try:
            error = self._orders[do](order, page)
        except (Wrong, LookupError, TypeError, ValueError, ArithmeticError):
            error = errors.ORDER_FIELD
        except OSError:
            error = errors.NOT_WRITTEN
        return {"t": "answer", "do": str(do)[:20], "error": error}

    def finish(self, answer, result):
        return {**answer, "error": answer["error"].then(result) or 0}

    def _take_piece(self, order, page):
        """Take a piece of a file. The last piece starts the check, whose result goes to the pages."""
        name, piece = order["name"], order["text"]
        if not isinstance(name, str) or not isinstance(piece, str) or len(piece) > _PIECE:
            raise Wrong("text")
        at = int(number_field(order, "at", 0, uploads.MOST_BYTES))
        so_far = self._coming.get((page, name), "") if at else ""
        if len(so_far) != at:
            return errors.JOB_PIECE
        self._coming.pop((page, name), None)
        if at + len(piece) > uploads.MOST_BYTES:
            return errors.JOB_SIZE
        self._coming[page, name] = so_far + piece
        if len(self._coming) > _PAGES:  # of pages that have gone: the one that has waited longest for its next piece
            del self._coming[next(iter(self._coming))]
        if order.get("last"):
            kind, copies = text_field(order, "kind", 40), int(number_field(order, "copies", 1, _MOST_COPIES))
            if kind not in uploads.list_kinds():
                raise Wrong("kind")
            laser = order.get("laser", "")
            if laser not in ("", *LASER_CLASSES):
                raise Wrong("laser")
            wants = {"kind": kind, "tool": text_field(order, "tool", 40), "laser": laser, "material": str(order.get("material", ""))[:40]}
            task = asyncio.ensure_future(self._queue_file(name, self._coming.pop((page, name)), wants, copies))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)
        return 0

    async def _queue_file(self, name, said, wants, copies):
        """Check a file and put it into the book. Send the pages the result, or the error."""
        why = ""
        try:
            async with self._checks:
                made, data, facts = await asyncio.to_thread(uploads.job_of, name, said.encode("utf-8", "replace"), wants["kind"])
            await self._add_to_book(data, made, {**wants, **facts}, copies)
        except Failure as failure:
            why = failure.message()
        except Exception as error:  # a full disk, a file on which a reader fails
            why = _("{}: it could not be queued: {}", name, reason(error) or type(error).__name__)
        self.server.pages.tell({"t": "dropped", "name": name, "text": in_languages(why), **({} if why else {"copies": copies})})
        if not why:
            self.dispatcher.look()

    async def _add_to_book(self, data, name, wants, copies):
        """Add a file's jobs to the book, in _TRIES attempts. Raises JobTableError if none works."""
        for left in reversed(range(_TRIES)):
            try:
                return await asyncio.to_thread(self.book.add_jobs, data, name, wants, copies)
            except JobTableError:
                if not left:
                    raise
            await asyncio.sleep(_AGAIN_S)

    def _withdraw_job(self, order, page):
        return 0 if self.book.withdraw_job(text_field(order, "job", 8)) else errors.NO_SUCH_JOB

    def _queue_again(self, order, page):
        """Queue a job once more, as a new one. Returns 0 or an error."""
        job = self.book.job_by_id(text_field(order, "job", 8))
        if job is None:
            return errors.NO_SUCH_JOB
        self.book.add_jobs(self.book.file_data(job.sha), job.name, job.wants)
        self.dispatcher.look()
        return 0

    def _end_job(self, order, page):
        """End a job whose machine is not reached: it has another name now, or is no more. Returns 0 or an error."""
        return self.dispatcher.end(text_field(order, "job", 8))

    # --- what is shown

    def page_state(self):
        """The state for the pages, a dict: machines, jobs, counts, times of materials, trouble."""
        self._read_book()
        trouble = self.book.trouble
        machines = [
            {"name": name, **{key: told.get(key, "") for key in _TOLD}, **{key: in_languages(told.get(key, "")) for key in _SAID}}
            for name, told in sorted(list(self.dispatcher.machines.items())) if told.get("state") or told.get("how")
        ]  # fmt: skip
        return {
            "machines": machines, "jobs": self._jobs, "counts": self._counts, "used": self._used, "broker": self.dispatcher.is_up,
            "adrift": self._jobs_adrift() if self.dispatcher.is_up and time.monotonic() - self._begun_s > _HEARD_S else [],
            "trouble": in_languages(_("The book of jobs cannot be written: {}. The shop tries again each second.", trouble) if trouble else ""),
        }  # fmt: skip

    def _jobs_adrift(self):
        """The ids of jobs whose machine is not reached: an order of the page may end them."""
        return [job["id"] for job in self._jobs if job["state"] in OPEN and not is_reached(self.dispatcher.machines.get(job["machine"]))]

    def _read_book(self):
        """Read the book, if it has changed."""
        book, now_s = self.book, time.monotonic()
        if self._seen == book.changed or now_s < self._look_s:
            return
        try:
            seen, jobs, counts, used = book.changed, book.jobs(_SHOWN), book.count_states(), book.times_of_materials()
        except JobTableError:
            self._look_s = now_s + _READ_AGAIN_S
            return
        self._seen, self._counts, self._used = seen, counts, used
        self._jobs = [
            {"id": job.id, "name": job.name, "state": job.state, "machine": job.machine, "wants": job.wants, "line": job.line, "text": in_languages(job.text), "sha": job.sha}
            for job in jobs
        ]  # fmt: skip

    async def _push_state(self):
        """Send the state to all pages; hand an exception to complain()."""
        try:
            await self.server.push_state(clock_ms())
        except Exception as error:  # a machine may send anything: keep STOP working
            self.dispatcher.complain(wrong_message(error))

    async def run(self, host, port, ready):
        """Serve until SIGTERM or SIGINT. Calls `ready(port)` once the server listens. Raises OSError if the port is in use."""
        loop = asyncio.get_running_loop()
        stopped = asyncio.Event()
        for signal_ in (signal.SIGTERM, signal.SIGINT):
            loop.add_signal_handler(signal_, stopped.set)
        serving = asyncio.ensure_future(self.server.serve(host, port))
        try:
            ready(await self.server.wait_for_port(serving))
            while not stopped.is_set():
                await self._push_state()
                await asyncio.sleep(4 * PUSH_MS / 1000)
        finally:
            serving.cancel()

"""`passo prove` from the page: a process of its own, which has the board's port for itself and measures beside the panel's loop.

    proving = ProveProcess(lambda: ["--port", "/dev/ttyACM0"], lend, tell)
    PanelOrders(machine, store, teach, choose, proving)     # {"do": "prove", "what": "begin", "pins": true, "language": "pt"}
    await proving.run()                                     # what lend() begins: to the end of the process

Messages {"t": "prove", …} show its progress on all pages; a page that comes later asks by {"do": "prove", "what": "get"}. STOP ends it.
"""

import asyncio
import json

from host_tools import interpreter
from host_tools.language import LANGUAGES
from passo import errors
from passo.protocols.page.orders import text_field

_LINE_BYTES = 1 << 20
_END_S = 20  # for the board to be let go
RUNS, DONE, ENDED, FAILED = "runs", "done", "ended", "failed"


class ProveProcess:
    def __init__(self, board, lend, tell):
        """`board()`: the options of `passo prove` that name the board; `lend()`: 0 once run() is about to be called, with the board's port
        free, or why it is not; `tell(event)`."""
        self._board = board
        self._lend = lend
        self._tell = tell
        self._process = None
        self._asked = ()  # pins, language of the process that is about to begin
        self._given_up = False
        self._shown = {"t": "prove", "how": ""}

    def carry_out(self, order):
        """Carry out a page's order: `what` is begin, get or end. Returns 0, an error, or the message with the progress. Raises Wrong."""
        what = text_field(order, "what", 8)
        if what == "get":
            return dict(self._shown)
        if what == "end":
            self.end()
            return 0
        if what != "begin":
            return errors.UNKNOWN_COMMAND
        language = text_field(order, "language", 8)
        if language not in LANGUAGES:
            return errors.ORDER_FIELD
        error = self._lend()
        if not error:
            self._asked = bool(order.get("pins")), language
            self._given_up = False
            self._show_progress(t="prove", how=RUNS, part="", number=0, of=1, rows=[], header="", said="", summary=[], report="")
        return error

    def end(self):
        """End it early: the board goes back to its own work."""
        self._given_up = True
        if self._process and self._process.stdin:
            self._process.stdin.close()

    async def run(self):
        """Run the process to its end; the port is free meanwhile. Shows the result on all pages."""
        pins, language = self._asked
        try:
            if not self._given_up:
                await self._run_process(["--lang", language, "prove", "--lines", *self._board(), *["--yes-drivers"] * pins])
        finally:
            self._process = None
            self._show_progress(how=DONE if self._shown["report"] else ENDED if self._given_up else FAILED)

    async def _run_process(self, words):
        """Run `passo` with `words`, and take each line of its output; kill it _END_S after its end of output."""
        pipe = asyncio.subprocess.PIPE
        self._process = process = await asyncio.create_subprocess_exec(
            *interpreter.passo(), *words, stdin=pipe, stdout=pipe, stderr=asyncio.subprocess.STDOUT, limit=_LINE_BYTES
        )  # fmt: skip
        try:
            if self._given_up:
                self.end()
            async for line in process.stdout:
                self._take_row(line.decode("utf-8", "replace").strip())
            await asyncio.wait_for(process.wait(), _END_S)
        finally:
            if process.returncode is None:
                process.kill()
                await process.wait()

    def _take_row(self, line):
        """Take a line of the process: progress or a row of results in JSON, or text."""
        told = json.loads(line) if line[:1] == "{" else {"said": line.removeprefix("passo: ")}
        if "what" in told:
            told = {"rows": [*self._shown["rows"], {name: told[name] for name in ("key", "what", "found", "promised", "verdict", "advice")}]}
        self._show_progress(**told)

    def _show_progress(self, **changes):
        self._shown = {**self._shown, **changes}
        self._tell(self._shown)

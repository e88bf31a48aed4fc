"""The process of `passo panel`: one loop for the board, the pages, and the sender beside them."""

import asyncio
import os
import signal
import socket
import sys

from host_tools.clients import page_key
from host_tools.failure import Failure
from host_tools.panel import languages
from host_tools.panel.own_boards import OwnBoards
from host_tools.panel.prove_process import ProveProcess
from host_tools.page.orders import PanelOrders
from host_tools.panel.server import PUSH_MS, Server, clock_ms
from host_tools.panel.store import Store
from host_tools.resources import FIRMWARE
from passo import errors

_HALF_WAY = ("Hold", "Door")  # stands, but with motion that is to be gone on with
FOLDER = FIRMWARE / "passo" / "web" / "page"
TICK_S = 0.01
_SWITCH_S = 0.0005  # Python's switch interval: the loop's longest wait for another thread
SETTLE_S = 0.3  # a move that began just before has been reported by then


def names_of(host):
    """The names that a browser may use for a server bound to `host`."""
    names = {"127.0.0.1", "localhost", "[::1]", host}
    if host not in ("127.0.0.1", "localhost", "::1"):
        here = socket.gethostname().lower()
        names |= {here, here + ".local"}
        try:
            names |= {found[4][0] for found in socket.getaddrinfo(here, None)}
        except OSError:
            pass
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("192.0.2.1", 9))  # sends nothing: asks which address would be used
                names.add(probe.getsockname()[0])
            except OSError:
                pass
    return names


class Panel:
    def __init__(self, make_port, jobs, guest, host, language, board, machines=(), change=None, proved=None, own=None):
        """`make_port(changed)`: a Port; `jobs`: folder; `guest`: a serial line for a sender, or None; `language` of the board, and its
        file's table; `machines`: names of board files to choose from, the present one first, "" if it is not known; `change(name)`: port,
        link and table of another one, or a Failure: it has the port for itself, and may take a minute; `proved()`: options that name the board to
        `passo prove`, None: it cannot be proven;
        `own`: (folder of the user's board files, {name: board file} of `machines`), None: the page cannot make any."""
        self._loop = None
        self._port = make_port(self._note_port)
        self._guest = guest
        self._watched = []
        self._asked = False  # the pages show the guest's request
        self._change = change
        self._changing = None  # the task that has the port: a change of machine, or a proof
        self._proving = ProveProcess(proved, self._lend_port, self._tell_pages) if proved else None
        self._jobs = jobs
        self._machines = list(machines)
        self._files = own[1] if own else {}
        self._own = OwnBoards(*own, lambda: self._machines[0], self._list_machines) if own else None
        self.key = page_key.make_key(os.urandom)
        self._create_machine(language, board)
        self.server = Server(self.api, self.key, names_of(host), str(FOLDER), self._about)
        self._stopped = asyncio.Event()

    def _create_machine(self, language, board):
        """Make the machine of a language, and the page's orders to it."""
        spoken = languages.create(language, board, self._port.write, self._tell_pages, self._guest.write if self._guest else None)
        self.machine = spoken.machine
        self.machine.beside = self._run_beside
        folder = self._jobs if language == "grbl" else self._jobs / language
        store = Store(folder, spoken.read, spoken.made, spoken.facts) if spoken.read else None
        spoken.join(store)
        self.api = PanelOrders(self.machine, store, spoken.teach, self._choose_machine if self._change else None, self._proving, self._own)
        self._about = {"machines": self._machines, **spoken.about}

    def _list_machines(self):
        """Update the list of machines, and tell all pages."""
        known = [name for name in self._machines if name in self._files or not name]
        self._machines[:] = known + [name for name in list(self._files) if name not in known]  # list(): an order may add one meanwhile
        self._tell_pages({"t": "machines", "machines": list(self._machines)})

    def _run_beside(self, work, then):
        self.server.run_beside(work).add_done_callback(lambda done: then(done.result()))

    def _tell_pages(self, event):
        self.server.pages.tell(event)

    def _note_port(self, fd, opened):
        """Read the board's port from now on, or no more: it has been opened, or is about to be closed."""
        if self._loop is None:
            return
        self.machine.note_port(opened)
        if opened:
            self._loop.add_reader(fd, self._read_board)
        else:
            self._loop.remove_reader(fd)

    def _read_board(self):
        """Read the board's bytes and feed them to the machine, then let the sender beside the page speak."""
        data = self._port.read()
        if data:
            self.machine.feed(data, clock_ms())
            if self._guest:
                self.machine.guest.poll()

    def _read_guest(self):
        """Poll the operator's consent to the sender beside the page, if it needs one, and feed its bytes to the machine."""
        if self._guest.consent:
            self._admit_guest(self._guest.consent)
        data = self._guest.read()
        if data:
            self.machine.guest.feed(data)

    def _choose_machine(self, name):
        """Begin the change to another machine. Returns 0 or an error; a message to all pages shows how the change ends."""
        if not name or name not in self._machines:
            return errors.ORDER_FIELD
        return self._lend_port(lambda: self._become_machine(name))

    def _lend_port(self, use=None):
        """Begin a task that has the port for itself: `use()`, or a proof. Returns 0, or an error if the board is at work."""
        error = errors.BUSY if self._changing else self._restart_refusal()
        if not error:
            self._changing = asyncio.ensure_future(use() if use else self._prove_board())
        return error

    async def _prove_board(self):
        """Let `passo prove` have the board's port, and take it back behind it."""
        try:
            if await self._wait_and_check():
                self._proving.end()
            else:
                self._port.lend_port()
                self.machine.lose_board()
            await self._proving.run()
        finally:
            self._port.take_back(self._port.name, self._port.baud)
            self._changing = None

    def _restart_refusal(self):
        """0, or the error that says why the board may not be stopped and started anew now."""
        if self.machine.state["link"] and self.machine.refusal():
            return self.machine.refusal()
        return errors.BUSY if self.machine.busy_error() or self.machine.state["state"] in _HALF_WAY else 0

    async def _wait_and_check(self):
        """Wait SETTLE_S for the report of a move that began just before, and check again. Returns 0 or an error, which the log shows."""
        await asyncio.sleep(SETTLE_S)
        error = self._restart_refusal()
        if error:
            self.machine.log_error(error)
        return error

    async def _become_machine(self, name):
        """Stop the board, make it machine `name`, and show the result on all pages."""
        try:
            if await self._wait_and_check():
                return
            self._port.lend_port()
            self.machine.lose_board()
            self._tell_pages({"t": "changing", "name": name})
            port, link, board = await self._loop.run_in_executor(None, self._change, name)
        except Failure as failure:
            self._port.take_back(self._port.name, self._port.baud)
            self._tell_pages({"t": "refused", "text": failure.message()})
            return
        finally:
            self._changing = None
        self._machines = [name] + [other for other in self._machines if other not in ("", name)]
        self._create_machine(link["protocol"], board)
        self._port.take_back(port, link.get("baud") or languages.BAUD[link["protocol"]])
        self.server.change_machine(self.api, self._about)

    def _watch_guest(self):
        """Read the guest's port as its bytes come. A pty without a client is always ready, so it is not in the list that select() watches."""
        watched = self._guest.select_list()
        for fd in self._watched:
            if fd not in watched:
                self._loop.remove_reader(fd)
        for fd in watched:
            if fd not in self._watched:
                self._loop.add_reader(fd, self._read_guest)
        self._watched = watched
        self._read_guest()

    def _admit_guest(self, consent):
        """Show a sender's request on the pages; let it in once a page hands the command over, or somebody answers in the terminal."""
        if consent.asked and not self._asked:
            self._asked = True
            self._tell_pages({"t": "asks", "name": self._guest.name})
        if self.machine.guest.commanded:
            consent.give_consent()
        consent.poll()

    async def run(self, host, port, ready):
        """Serve until end(). Calls `ready(port)` once the server listens. Raises LinkError or OSError if a port cannot be opened."""
        self._loop = asyncio.get_running_loop()
        sys.setswitchinterval(_SWITCH_S)
        for number in (signal.SIGTERM, signal.SIGINT):
            self._loop.add_signal_handler(number, self.end)
        self._port.open()
        serving = asyncio.ensure_future(self.server.serve(host, port))
        try:
            ready(await self.server.wait_for_port(serving))
            await self._run_loop()
        finally:
            self.machine.end_jog()
            serving.cancel()
            if self._proving:
                self._proving.end()
            if self._changing:  # a board whose files are half copied would not start
                await asyncio.wait([self._changing])
            self._port.close()

    def end(self):
        """Serve no more."""
        self._stopped.set()

    async def _run_loop(self):
        """Poll port, machine and guest each TICK_S, and push the state each PUSH_MS, until end()."""
        pushed = clock_ms()
        while not self._stopped.is_set():
            now = clock_ms()
            self._port.look()
            self.machine.poll(now)
            self.api.poll()
            if self._guest:
                self._watch_guest()
            if now - pushed >= PUSH_MS or now < pushed:
                pushed = now
                await self.server.push_state(now)
            await asyncio.sleep(TICK_S)

"""`passo panel --demo` as a process of its own, and a client of its WebSocket that is not the page.

    with PanelProcess(folder) as panel:
        page = panel.page()                         # with the key
        page.order("unlock")                        # the answer, a dict
        page.until(lambda state: state["state"] == "Idle")
    panel.trace()                                   # [(ticks, x, y, z)] of each step, once it has ended
"""

import csv
import json
import queue
import re
import signal
import subprocess
import threading
import time

import websocket

from host_tools import interpreter
from patience import patience
from passo.web.session import Session

TICK_US = 0.08
LIMIT_S = 60  # for anything that ends by itself


class PanelProcess:
    def __init__(self, folder, *options):
        self.folder = folder
        self._pages = []
        self.trace_file = folder / "trace.csv"
        self.jobs = folder / "jobs"
        demo = [] if "--port" in options else ["--demo", "--trace", str(self.trace_file)]
        words = [*interpreter.passo(), "panel", "--http", "0", "--jobs", str(self.jobs), *demo, *options]
        self._process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        said = ""
        while "Ctrl-C" not in said:
            line = self._process.stdout.readline()
            assert line, "the panel did not start: " + said
            said += line
        self.address, self.key = re.search(r"page: (\S+)#key=(\S+)", said).groups()
        guest = re.search(r"port: (\S+)", said)
        self.guest = guest and guest[1]  # the port for a sender
        self.host = self.address[7:-1]
        self.port = int(self.host.split(":")[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._process.terminate()
        assert self._process.wait(patience(30)) == 0
        self._process.stdout.close()

    def stand_still(self, seconds):
        """Stop its process for that long."""
        self._process.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        self._process.send_signal(signal.SIGCONT)

    def page(self, key=None, reads=True):
        made = PageClient(self.host, self.key if key is None else key, reads=reads)
        self._pages.append(made)
        return made

    def leave_pages(self):
        """Close the pages that page() has opened: the panel takes eight, and one more the place of one that has proven nothing."""
        while self._pages:
            self._pages.pop().socket.close()

    def trace(self):
        """(ticks of 80 ns, x, y, z) in steps, row by row."""
        with open(self.trace_file, newline="") as file:
            return [(round(float(row["t_us"]) / TICK_US), int(row["x"]), int(row["y"]), int(row["z"])) for row in csv.DictReader(file)]


class PageClient:
    def __init__(self, host, key, origin=None, reads=True):
        """`reads`: answers pings whatever the test does meanwhile, as a browser does; else only while a test listens to it. The panel gives
        up a page that is silent for 8 s."""
        self.socket = websocket.create_connection(f"ws://{host}/ws", origin=origin or f"http://{host}", timeout=patience(LIMIT_S))
        self.hello = json.loads(self.socket.recv())
        self.socket.settimeout(None if reads else patience(LIMIT_S))
        self._session = Session(key, self.hello["nonce"])
        self.count = 0
        self.state = {}
        self.lease = 0
        self.told = []
        self._received = queue.SimpleQueue() if reads else None
        if reads:
            threading.Thread(target=self._receive, daemon=True).start()

    def _receive(self):
        try:
            while True:
                self._received.put(self.socket.recv())
        except Exception as error:  # it belongs to who waits for a message
            self._received.put(error)

    def message(self, order):
        """An order with its proof."""
        self.count += 1
        body = json.dumps({**order, "id": self.count})
        return f"{self.count}.{self._session.proof(str(self.count), body)}.{body}"

    def order(self, do, **fields):
        self.socket.send(self.message({"do": do, **fields}))
        number = self.count
        return self._find(lambda message: message.get("id") == number)

    def hear(self):
        received = self._received.get(timeout=patience(LIMIT_S)) if self._received else self.socket.recv()
        if isinstance(received, Exception):
            self._received.put(received)
            raise received
        message = json.loads(received)
        if message["t"] == "state":
            self.state = message
        else:
            self.told.append(message)
        return message

    def _find(self, wanted):
        deadline = time.monotonic() + patience(LIMIT_S)
        while time.monotonic() < deadline:
            message = self.hear()
            if wanted(message):
                return message
        raise TimeoutError(str(self.state) + str(self.told[-10:]))

    def said(self, kind):
        """The next message of a kind that nobody has asked for."""
        while not [message for message in self.told if message["t"] == kind]:
            self._find(lambda message: message["t"] == kind)
        found = next(message for message in self.told if message["t"] == kind)
        self.told.remove(found)
        return found

    def until(self, wanted):
        """Listen until a state is as wanted."""
        return self._find(lambda message: message["t"] == "state" and wanted(message))

    def ready(self):
        """Unlocked, and known."""
        self.until(lambda state: state["link"])
        self.unlock()
        return self

    def unlock(self):
        """Unlock the machine. The state that says so may come before the order's answer, and no other behind it."""
        assert self.order("unlock")["error"] == 0
        if self.state.get("state") != "Idle":
            self.until(lambda state: state["state"] == "Idle")

    def put(self, name, text):
        for at in range(0, len(text), 30_000):
            answer = self.order("job_part", name=name, at=at, text=text[at : at + 30_000], last=at + 30_000 >= len(text))
            assert answer["error"] == 0, answer

    def run(self, name):
        assert self.order("run", name=name)["error"] == 0
        return self.until(lambda state: state["job"] and state["job"]["how"] in ("done", "failed"))["job"]

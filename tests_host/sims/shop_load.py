"""A shop under load: virtual plotters, agents and a real Mosquitto that are killed and parted; the strokes drawn are counted from the traces.

    python tests_host/sims/shop_load.py 100 1000 --agents-killed 50 --brokers-killed 10 --partitions 10 --power-cuts 20

A job draws its number: a stroke for each of ten bits, one above the other, 5 mm long or 10. The script plays the people at the machines: it puts paper in at
rest, and says "go" when a machine waits. Faults come while machines draw: the people put no more paper in than lets the last
fault find a job.
"""

import argparse
import json
import os
import random
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import requests

from host_tools import interpreter

MOSQUITTO = shutil.which("mosquitto", path=os.environ.get("PATH", "") + ":/usr/sbin")
BITS = 10
FIRST_MM, APART_MM, SHORT_MM, LONG_MM = 5, 3, 5, 10
STEPS_MM = 10
AN_AGENT = 5  # machines
KIND = "small_plotter"
_RESERVE = 2  # jobs that are kept for each fault to come
_IDLE_MS = 50  # a board at rest looks at its line as bytes come, and no more often than that


def board_file(folder):
    """A plotter with large steps, so that traces are short."""
    from host_tools import boards

    board = dict(boards.load("corexy_plotter"), name=KIND)
    board["axes"] = [dict(axis, steps_per_m=1000 * STEPS_MM, travel_steps=600) for axis in board["axes"]]
    board["homing"] = dict(board["homing"], seek_steps_s=600, pull_off_steps=20)
    board["inputs"] = [*board["inputs"], {"name": "resume", "pin": 22, "active": 0, "pull": "up"}]
    board["speed"] = dict(board["speed"], default=1000, max=2500)
    path = folder / f"{KIND}.py"
    path.write_text(f"BOARD = {board!r}\n")
    return path


def program(number):
    lines = ["G21 G90"]
    for bit in range(BITS):
        y = FIRST_MM + APART_MM * bit
        lines += [f"G0 X{FIRST_MM} Y{y}", "M3 S1000", f"G1 X{FIRST_MM + (LONG_MM if number >> bit & 1 else SHORT_MM)} F3000", "M5"]
    return "\n".join([*lines, "G0 X2 Y2", ""]).encode()


# --- what was drawn


def strokes(traces):
    """[(y, x from, x to)] in steps, of the pen that is down, in the order of drawing; None between two traces: the power was cut."""
    found, left, right, at_y = [], None, None, None
    for path in traces:
        if found and found[-1]:
            found.append(None)
        with open(path) as file:
            for row in list(file)[1:]:
                fields = row.split(",")
                if len(fields) != 6:
                    continue
                x, y, down = int(fields[1]), int(fields[2]), int(fields[5]) > 500
                if left is not None and (not down or y != at_y):
                    found.append((at_y, left, right))
                    left = None
                if down:
                    left, right, at_y = (x, x, y) if left is None else (min(left, x), max(right, x), y)
        if left is not None:
            found.append((at_y, left, right))
            left = None
    return [stroke for stroke in found if stroke is None or stroke[2] > stroke[1]]


class Numbers:
    """Reads numbers out of strokes. A stroke may be in pieces; behind a power cut the last ones may come again, as they were."""

    def __init__(self):
        self.numbers, self.faults, self.twice = [], [], 0
        self._pieces, self._now, self._cut = {}, -1, False

    def close(self):
        value = 0
        for bit in range(BITS):
            length = (self._pieces.get(bit, (0, 0))[1] - FIRST_MM * STEPS_MM) / STEPS_MM
            if abs(length - LONG_MM) < 0.5:
                value |= 1 << bit
            elif abs(length - SHORT_MM) >= 0.5 or bit not in self._pieces:
                self.faults.append(f"bit {bit} of a job is {self._pieces.get(bit)}")
        self.numbers.append(value)
        self._pieces, self._now = {}, -1

    def _piece(self, bit, left, right):
        first, last = self._pieces.get(bit, (left, left))
        self.twice += max(0, min(last, right) - max(first, left))
        if left > last + 1:
            self.faults.append(f"a gap of {left - last} steps")
        if bit + 1 in self._pieces and right != last:
            self.faults.append(f"bit {bit} is drawn again to {right}, and was to {last}")
        self._pieces[bit] = min(first, left), max(last, right)
        self._now = bit

    def take(self, stroke):
        if stroke is None:
            self._cut = True
            return
        y, left, right = stroke
        bit = round((y / STEPS_MM - FIRST_MM) / APART_MM)
        if bit == 0 and self._now == BITS - 1:
            self.close()
        back = self._cut and 0 <= bit < self._now
        self._cut = False
        if not (back or self._now <= bit <= self._now + 1 < BITS + 1 and 0 <= bit < BITS):
            self.faults.append(f"stroke of bit {bit} behind bit {self._now}")
            self._pieces = {}
        self._piece(bit, left, right)


def read_numbers(found):
    """(numbers in the order of drawing, steps drawn twice, what is no number)."""
    reader = Numbers()
    for stroke in found:
        reader.take(stroke)
    if reader._pieces:
        reader.close()
    return reader.numbers, reader.twice, reader.faults


# --- a board, as a process


class _Cut(BaseException):
    """The power is gone, wherever the firmware is."""


def board(folder, mode):
    """Run the board of `folder`, in "fast" or "real" time. SIGUSR1: its power is cut; SIGUSR2: its button is pressed, or let go. Its file `moved` has the wall clock's seconds at the last step."""
    from host_tools import boards
    from host_tools.build.pc_kernels import use_compiled
    from host_tools.sim.machine import Machine
    from host_tools.sim.serial_line import PtyLine, wait_for_bytes

    use_compiled()
    traces = sorted(folder.glob("trace-*.csv"))
    config = boards.load(str(folder.parent / f"{KIND}.py"))
    place = (20 + len(traces), 30)
    (folder / "flash").mkdir(exist_ok=True)
    line = PtyLine(folder / "port")
    lines = {"usb": line, "pc": PtyLine()}
    machine = Machine(
        config, lines, mode, lambda ms: wait_for_bytes([line], max(ms, _IDLE_MS)), trace=folder / f"trace-{len(traces):03}.csv", idle=False, flash=folder / "flash", start=place
    )
    stopped = []
    signal.signal(signal.SIGTERM, lambda *_: stopped.append(True))

    def cut(*_):
        raise _Cut

    signal.signal(signal.SIGUSR1, cut)
    pressed = []
    signal.signal(signal.SIGUSR2, lambda *_: pressed.append(True))
    print("ready", flush=True)
    flushed = time.monotonic()
    at, moved = None, 0.0
    try:
        while not stopped:
            machine.cycle()
            if len(pressed) % 2 != machine.port.input("resume"):
                machine.plant.set_input(machine.port.now, "resume", len(pressed) % 2)
            if machine.plant.position != at:
                at, moved = list(machine.plant.position), time.time()
            if time.monotonic() - flushed > 2:
                machine.flush()
                (folder / "moved.new").write_text(str(moved))
                os.replace(folder / "moved.new", folder / "moved")
                flushed = time.monotonic()
        machine.close()
    except _Cut:
        machine.trace.flush()
        (folder / "port").unlink()
        os._exit(0)
    finally:
        (folder / "port").unlink(missing_ok=True)  # the system gives its number to the next who opens a pty


# --- the network


class Proxy:
    """Between agents and broker; cut() parts them for a while."""

    def __init__(self, to):
        self._to = to
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        self._pairs = {}
        self._lock = threading.Lock()
        self.until_s = 0.0
        self._open = True
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def cut(self, seconds):
        """Lose all packets for this time, without a sign to either end, as a network that parts does."""
        self.until_s = time.monotonic() + seconds

    def _run(self):
        poll = select.poll()
        poll.register(self._server, select.POLLIN)
        by_fd = {}
        parted = False
        while self._open:
            if time.monotonic() < self.until_s:
                parted = True
                time.sleep(0.05)
                continue
            if parted:  # the bytes sent meanwhile are lost, and the connections, too
                parted = False
                for one in list(by_fd.values()):
                    one.close()
                by_fd.clear()
                poll = select.poll()
                poll.register(self._server, select.POLLIN)
                self._pairs.clear()
            for fd, _event in poll.poll(100):
                if fd == self._server.fileno():
                    client, _ = self._server.accept()
                    try:
                        broker = socket.create_connection(("127.0.0.1", self._to), 5)
                    except OSError:
                        client.close()
                        continue
                    for one, other in ((client, broker), (broker, client)):
                        by_fd[one.fileno()] = one
                        self._pairs[one.fileno()] = other
                        poll.register(one, select.POLLIN)
                    continue
                one, other = by_fd.get(fd), self._pairs.get(fd)
                if one is None:
                    continue
                try:
                    data = one.recv(65536)
                    if data:
                        other.sendall(data)
                        continue
                except OSError:
                    pass
                for each in (one, other):
                    if by_fd.pop(each.fileno(), None):
                        poll.unregister(each)
                        self._pairs.pop(each.fileno(), None)
                    each.close()
        for one in by_fd.values():
            one.close()
        self._server.close()

    def close(self):
        self._open = False
        self._thread.join(10)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


# --- the whole


class Load:
    def __init__(self, folder, machines, jobs, an_agent=AN_AGENT, seed=1, parted_s=30.0, mode="fast", make=program):
        from host_tools.shop.job_table import JobTable
        from host_tools.shop.dispatcher import Dispatcher
        from host_tools.shop.link import Broker
        from host_tools.clients import page_key

        self.folder = folder
        self.random = random.Random(seed)
        self.parted_s = parted_s
        self.mode = mode
        self.names = [f"m{number:03}" for number in range(machines)]
        self.board_file = board_file(folder)
        self.count = {}
        self.drawing = []  # machines that do, as their own pages tell it
        self.free = 0  # machines with paper in and no job
        self.struck = []  # how many drew at each fault
        self.boards, self.agents = {}, {}
        self.groups = [self.names[at : at + an_agent] for at in range(0, machines, an_agent)]
        self.broker_port = free_port()
        self.broker = None
        (folder / "mosquitto.conf").write_text(f"listener {self.broker_port} 127.0.0.1\nallow_anonymous true\n")
        self.start_broker()
        self.proxy = Proxy(self.broker_port)
        self.page_key = page_key.make_key(os.urandom)
        self.page_key_file = folder / "page.key"
        self.page_key_file.touch(0o600)
        self.page_key_file.write_text(self.page_key)
        key = page_key.make_key(os.urandom)
        self.key_file = folder / "shop.key"
        self.key_file.write_text(key)
        self.key_file.chmod(0o600)
        for name in self.names:
            (folder / name).mkdir()
        for name in self.names:
            self.start_board(name)
        self.book = JobTable(folder / "shop.sqlite")
        self.jobs = {}
        for number in range(jobs):
            data = make(number)
            self.jobs[self.book.add_jobs(data, f"{number}.gcode", {"kind": KIND})[0]] = number
        self.dispatcher = Dispatcher(Broker("127.0.0.1", self.proxy.port), key, self.book)
        for at in range(len(self.groups)):
            self.start_agent(at)

    def start_broker(self):
        self.broker = subprocess.Popen([MOSQUITTO, "-c", self.folder / "mosquitto.conf"], stderr=subprocess.DEVNULL)

    def start_board(self, name):
        self.boards[name] = subprocess.Popen([*interpreter.python(), __file__, "--board", str(self.folder / name), self.mode], stdout=subprocess.PIPE, stderr=open(self.folder / name / "stderr", "ab"))

    def start_agent(self, at):
        """As docs/use/passo-agent.service does: before the boards, which have processors of their own in a shop. If this user may not, like all others."""
        ports = [word for name in self.groups[at] for word in ("--port", f"{name}={self.folder}/{name}/port")]
        out = self.folder / f"agent-{at}.out"
        self.agents[at] = subprocess.Popen(
            ["nice", "-n", "-10", *interpreter.passo(), "agent", *ports, "--protocol", "grbl", "--board", str(self.board_file), "--broker", f"127.0.0.1:{self.proxy.port}",
             "--shop-key", str(self.key_file), "--at-machine", "0", "--page-key", str(self.page_key_file)],
            stdout=open(out, "wb"), stderr=open(self.folder / f"agent-{at}", "ab"),
        )  # fmt: skip

    def people(self, papers):
        """Play the people at the machines: look at each page once, and do its request. Puts in at most `papers`."""
        from machine_page import MachinePage  # a board, which is this script, too, has no use for it

        drawing, self.free = [], 0
        for at in self.agents:
            found = re.search(r"page: (\S+)/\n", (self.folder / f"agent-{at}.out").read_text())
            if not found:  # it is beginning
                continue
            page = MachinePage(found[1], self.page_key)
            try:
                for machine in page.machines():
                    if machine["how"] == "run":
                        drawing.append(machine["name"])
                    self.free += machine["how"] == "free"
                    what = {"rest": "release", "waits": "go"}.get(machine["how"])
                    if what == "release":
                        papers -= 1
                    if what and (what == "go" or papers >= 0):
                        self.count[what] = self.count.get(what, 0) + 1
                        page.do(machine["name"], what)
            except (requests.RequestException, ValueError):
                pass
        self.drawing = drawing

    def kill_agent(self):
        """Of a machine that draws."""
        name = self.random.choice(self.drawing)
        at = next(at for at, group in enumerate(self.groups) if name in group)
        self.agents[at].kill()
        self.agents[at].wait()
        self.start_agent(at)

    def kill_broker(self):
        self.broker.kill()
        self.broker.wait()
        self.start_broker()

    def cut_power(self):
        """Of a machine that draws."""
        name = self.random.choice(self.drawing)
        process = self.boards[name]
        process.send_signal(signal.SIGUSR1)
        process.wait(60)
        process.stdout.close()
        self.start_board(name)

    def part(self):
        self.proxy.cut(self.parted_s)

    def run(self, limit_s, faults):
        """`faults`: functions, spread over the jobs. Until all jobs have ended, and all faults have been."""
        faults = list(faults)
        total, count = len(self.jobs), len(faults)
        begun = time.monotonic()
        told = 0
        while time.monotonic() - begun < limit_s:
            counts = self.book.count_states()
            done = counts.get("done", 0)
            if done >= told:
                print(f"{time.monotonic() - begun:.0f} s: {counts}, {len(faults)} faults left, load {os.getloadavg()[0]:.1f}", flush=True)
                told = done + max(1, total // 20)
            if done == total and not faults:
                return time.monotonic() - begun
            due = total * (count - len(faults)) // (count + 1)
            if faults and done >= due and self.drawing and (faults[0] != self.part or time.monotonic() > self.proxy.until_s):
                self.struck.append(len(self.drawing))
                faults.pop(0)()
            under_way = total - counts.get("queued", 0) - done
            papers = min(due + len(self.names), total - _RESERVE * len(faults)) - done - under_way - self.free
            self.people(max(papers, 0 if under_way or self.free else 1))
            time.sleep(0.2)
        raise AssertionError(f"not done in {limit_s} s: {self.book.count_states()}, {[(name, told.get('how'), told.get('state'), told.get('text')) for name, told in self.dispatcher.machines.items()]}")

    def drawn(self):
        """{machine: (numbers, steps drawn twice, faults)}, from the traces."""
        for process in self.boards.values():
            process.terminate()
        for process in self.boards.values():
            process.wait(120)
        return {name: read_numbers(strokes(sorted((self.folder / name).glob("trace-*.csv")))) for name in self.names}

    def by_book(self):
        """{machine: numbers in the order of the queue}: a machine is given the first job that waits."""
        found = {name: [] for name in self.names}
        for job in sorted(self.book.jobs(100_000), key=lambda job: job.number):
            if job.machine:
                found[job.machine].append(self.jobs[job.id])
        return found

    def close(self):
        for process in [*self.agents.values(), *self.boards.values(), self.broker]:
            if process:
                process.kill()
                process.wait()
                if process.stdout:
                    process.stdout.close()
        self.dispatcher.close()
        self.proxy.close()
        self.book.close()


def check(load):
    """Raise AssertionError unless each job was drawn exactly once, in the order of its machine. Returns the steps drawn twice."""
    drawn = load.drawn()
    faults = {name: found[2] for name, found in drawn.items() if found[2]}
    assert not faults, faults
    numbers = [number for found in drawn.values() for number in found[0]]
    assert sorted(numbers) == sorted(load.jobs.values()), (len(numbers), sorted(set(load.jobs.values()) - set(numbers)), sorted({number for number in numbers if numbers.count(number) > 1}))
    by_book = load.by_book()
    for name, found in drawn.items():
        assert found[0] == by_book[name], (name, found[0], by_book[name])
    return sum(found[1] for found in drawn.values())


def usage(process):
    """(MB, seconds of CPU) of a process."""
    rss = int(next(line for line in Path(f"/proc/{process.pid}/status").read_text().splitlines() if line.startswith("VmRSS")).split()[1]) / 1024
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return rss, (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main():
    import tempfile

    if sys.argv[1:2] == ["--board"]:
        return board(Path(sys.argv[2]), sys.argv[3])
    parser = argparse.ArgumentParser()
    parser.add_argument("machines", type=int)
    parser.add_argument("jobs", type=int)
    for name in ("agents-killed", "brokers-killed", "partitions", "power-cuts"):
        parser.add_argument(f"--{name}", type=int, default=0)
    parser.add_argument("--parted-s", type=float, default=30.0)
    parser.add_argument("--limit-s", type=float, default=3000.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", action="store_true")
    given = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="shop-"))
    load = Load(folder, given.machines, given.jobs, seed=given.seed, parted_s=given.parted_s)
    try:
        faults = [load.kill_agent] * given.agents_killed + [load.kill_broker] * given.brokers_killed + [load.cut_power] * given.power_cuts
        faults += [load.part] * given.partitions
        load.random.shuffle(faults)
        took = load.run(given.limit_s, faults)
        used = [usage(process) for process in load.agents.values()]
        twice = check(load)
        print(json.dumps({
            "jobs": given.jobs, "machines": given.machines, "seconds": round(took), "drawn twice, mm": twice / STEPS_MM, "people": load.count,
            "faults": len(load.struck), "machines drawing at a fault": [min(load.struck, default=0), sum(load.struck) // max(len(load.struck), 1)],
            "agent MB": round(max(used)[0]), "machines an agent": AN_AGENT, "agents' CPU, s": round(sum(each[1] for each in used)),
        }))  # fmt: skip
    finally:
        load.close()
        if not given.keep:
            shutil.rmtree(folder, ignore_errors=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

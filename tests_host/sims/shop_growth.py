"""How the shop grows: simulated agents, without boards, at a real Mosquitto, and the cost of each job for the shop and the broker.

    python tests_host/sims/shop_growth.py MACHINES [JOBS_EACH]

An agent here has the connection, the signatures and the files of a real one (host_tools/shop/link.py), one for each machine; a job takes it
two seconds, and it is released again at once.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from shop_load import MOSQUITTO, free_port, program, usage

from host_tools import interpreter

JOB_S = 2.0
A_PROCESS = 250  # machines


class Machine:
    def __init__(self, key, name, link):
        self.key, self.name, self.link = key, name, link
        self.shop, self.how, self.order, self.ended, self.count, self.said = "", "free", None, None, int(time.time()), None
        self.waits = []  # seconds from a release to its order
        self._renew()

    def _renew(self):
        from host_tools.shop.signed import SHOP, Opener
        from passo.web.guard import make_nonce

        self.nonce = make_nonce()
        self.opener = Opener(self.key, SHOP, self.nonce)
        self.since = time.monotonic()

    def poll(self, now):
        from host_tools.shop import link as topics
        from host_tools.shop.signed import MACHINE, sign_message

        for what, text in self.link.take_orders():
            if what == topics.SHOP:
                self.shop = text
            elif self.how == "free" and (order := self.opener.open(text)):
                self.waits.append(now - self.since)
                self.order, self.how = order, "fetch"
                self.link.parcel.ask_file(order["sha"], order["parts"])
        if self.how == "fetch" and self.link.parcel.file_data():
            self.how, self.since = "run", now
        elif self.how == "run" and now - self.since > JOB_S:
            self.ended, self.order, self.how = [self.order["id"], "done", 1, ""], None, "free"
            self.link.parcel.drop()
            self._renew()
        body = {"how": self.how, "job": self.order["id"] if self.order else "", "nonce": self.nonce, "line": 0, "text": "", "ended": self.ended, "area": [60, 60], "kind": "k"}
        if self.shop and (self.shop, body) != self.said:
            self.count += 1
            self.said = self.shop, body
            self.text = sign_message(self.key, MACHINE, f"{self.shop} {self.name}", self.count, body)
        self.link.publish_topics({"state": "run" if self.how == "run" else "idle", **({"work": self.text} if self.said else {})})


def agents(port, key, first, count):
    """Simulate machines until standard input ends; then print how long each release waited."""
    import select

    from host_tools.shop.link import Broker, Link

    machines = [Machine(key, f"m{number:05}", Link(Broker("127.0.0.1", port), f"m{number:05}", works=True)) for number in range(first, first + count)]
    while not select.select([sys.stdin], [], [], 0.02)[0]:
        now = time.monotonic()
        for machine in machines:
            machine.poll(now)
    print(json.dumps([wait for machine in machines for wait in machine.waits[1:]]))  # the first one waits for the queue
    sys.stdout.flush()
    os._exit(0)  # not the good-byes of hundreds of threads


def measure(folder, count, each):
    from host_tools.shop.job_table import JobTable
    from host_tools.shop.dispatcher import Dispatcher
    from host_tools.shop.link import Broker
    from host_tools.clients import page_key

    port, key = free_port(), page_key.make_key(os.urandom)
    (folder / "mosquitto.conf").write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\n")
    broker = subprocess.Popen([MOSQUITTO, "-c", folder / "mosquitto.conf"], stderr=subprocess.DEVNULL)
    book = JobTable(folder / "shop.sqlite")
    dispatcher = Dispatcher(Broker("127.0.0.1", port), key, book)
    programs = [
        subprocess.Popen([*interpreter.python(), __file__, "--agents", str(port), key, str(first), str(min(A_PROCESS, count - first))], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for first in range(0, count, A_PROCESS)
    ]
    try:
        limit = time.monotonic() + 300
        while sum(told.get("how") == "free" for told in list(dispatcher.machines.values())) < count:
            assert time.monotonic() < limit, len(dispatcher.machines)
            time.sleep(0.2)
        own, theirs, begun = time.process_time(), usage(broker)[1], time.monotonic()
        for number in range(count * each):
            book.add_jobs(program(number % 1024), f"{number}", {"kind": "k"})
        added = time.process_time() - own
        dispatcher.look()
        while book.count_states().get("done", 0) < count * each:
            assert time.monotonic() < limit + 600, book.count_states()
            time.sleep(0.2)
        took = time.monotonic() - begun
        own, theirs = time.process_time() - own - added, usage(broker)[1] - theirs
        waits = []
        for each_program in programs:
            waits += json.loads(each_program.communicate("end\n", 60)[0])
        waits = sorted(waits)
        jobs = count * each
        return {
            "machines": count, "jobs": jobs, "seconds": round(took, 1), "shop ms a job": round(1000 * own / jobs, 2), "shop MB": round(usage(_Own)[0]),
            "broker ms a job": round(1000 * theirs / jobs, 2), "broker MB": round(usage(broker)[0]), "release to order, s": {"median": round(waits[len(waits) // 2], 2), "worst": round(waits[-1], 2)},
        }  # fmt: skip
    finally:
        for each_program in (*programs, broker):
            each_program.kill()
            each_program.wait()
        dispatcher.close()
        book.close()


class _Own:
    pid = os.getpid()


def main():
    if sys.argv[1] == "--agents":
        agents(int(sys.argv[2]), sys.argv[3], int(sys.argv[4]), int(sys.argv[5]))
    folder = Path(tempfile.mkdtemp(prefix="shop-growth-"))
    try:
        print(json.dumps(measure(folder, int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 3)))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()

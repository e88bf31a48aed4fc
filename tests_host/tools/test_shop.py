"""The shop's queue: its book, what is signed, who gives a job, and what a machine at rest, killed or asked again does."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest
import requests
from test_agent import Shop, needs_broker

from host_tools.failure import Failure
from host_tools.shop import drop
from host_tools.shop.book import Book
from host_tools.shop.desk import fits
from host_tools.shop.signed import MACHINE, SHOP, Opener, sealed
from passo.web import session

sys.path.insert(0, str(Path(__file__).parents[1] / "sims"))
import shop_load  # noqa: E402

KEY = "ABCDEFGHJKLMNPQR"


@pytest.fixture
def book(tmp_path):
    opened = Book(tmp_path / "shop.sqlite")
    yield opened
    opened.close()


# --- the book


def test_a_job_is_given_once_whatever_is_asked_for_again(book, tmp_path):
    one, two = book.add(b"G0X1", "a.gcode", {"kind": "k"}, 2)
    job = book.give("m1", "nonce", lambda job: True)
    assert job.id == one and book.open_of("m1").nonce == "nonce"
    assert book.give("m1", "other", lambda job: True) is None, "a machine has one job"
    assert book.give("m2", "nonce", lambda job: True).id == two
    assert book.give("m3", "nonce", lambda job: True) is None
    book.follow(job, "begun", 3, "")
    with pytest.raises(sqlite3.IntegrityError):
        book._write("update jobs set machine = 'm2' where id = ?", one)
    again = Book(tmp_path / "shop.sqlite")
    assert again.open_of("m1").line == 3 and again.open_of("m1").begun
    again.end(again.open_of("m1"), "done", 9, "")
    assert again.open_of("m1") is None and again.counts() == {"done": 1, "given": 1}
    assert not again.withdraw(two) and again.data(job.sha) == b"G0X1"
    assert [row[1] for row in again.used()] == [1]
    again.close()


def test_jobs_are_given_in_their_order_to_machines_that_fit(book):
    book.add(b"1", "big", {"kind": "k", "area": [300, 100]})
    book.add(b"2", "red", {"kind": "k", "tool": "red"})
    book.add(b"3", "any", {"kind": "k", "tool": ""})
    blue = {"kind": "k", "tool": "blue", "area": [200, 200]}
    assert book.give("blue", "n", lambda job: fits(job, blue)).name == "any"
    assert book.give("red", "n", lambda job: fits(job, {**blue, "tool": "red"})).name == "red"
    assert not fits(book.jobs()[0], {**blue, "kind": "another"})
    assert book.give("big", "n", lambda job: fits(job, {"kind": "k", "area": [300, 100]})).name == "big"


# --- what is signed


def test_an_order_is_good_once_for_its_end_its_nonce_and_as_it_was():
    text = sealed(KEY, SHOP, "nonce", 1, {"id": "1"})
    opener = Opener(KEY, SHOP, "nonce")
    assert opener.open(text.replace('"1"', '"2"')) is None
    assert opener.open(text) == {"id": "1"}
    assert opener.open(text) is None, "heard before"
    for other in (Opener(KEY, MACHINE, "nonce"), Opener(KEY, SHOP, "other"), Opener("B" * 16, SHOP, "nonce")):
        assert other.open(text) is None
    for noise in ("", "..", "1", "1.2.3", "9" * 40 + ".a.b", sealed(KEY, SHOP, "nonce", 2, [1]), "2.é.{}"):
        assert opener.open(noise) is None


# --- what is dropped


@pytest.mark.slow
def test_a_file_is_checked_before_it_is_queued():
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30"><path d="M5 5H25V20"/></svg>'
    name, data, facts = drop.job_of("a.svg", svg, "corexy_plotter")
    assert name == "a.svg.gcode" and b"M3" in data and facts["seconds"] > 1 and facts["area"][0] > 19
    for name, data, what in (
        ("a.gcode", b"G0 X10\nG99999\n", "line 2"), ("a.gcode", b"G0 X2000\n", "larger"), ("a.gcode", b"", "no line"), ("../a", b"G0X1", "name"),
        ("a.svg", b"<svg", None), ("a.gcode", b"\0\1", None),
    ):  # fmt: skip
        with pytest.raises(Failure, match=what):
            drop.job_of(name, data, "corexy_plotter")
    with pytest.raises(Failure, match="journal"):
        drop.job_of("a.gcode", b"G0X1", "plotter_2014")
    assert "corexy_plotter" in drop.kinds()


# --- one machine, a real broker


class Bench(Shop):
    """Mosquitto, a virtual plotter, its agent and a desk, each of which can be killed."""

    def __init__(self, folder):
        from host_tools.shop.desk import Desk
        from host_tools.shop.link import Broker

        super().__init__(folder)
        self.folder = folder
        self.key = session.make_key(os.urandom)
        self.key_file = folder / "shop.key"
        self.key_file.write_text(self.key)
        self.key_file.chmod(0o600)
        self.board_file = shop_load.board_file(folder)
        (folder / "m").mkdir()
        self.board = None
        self.start_board()
        self.book = Book(folder / "shop.sqlite")
        self.desk = Desk(Broker("127.0.0.1", self.port), self.key, self.book)
        self.page = ""
        self.agent_process = None

    def start_board(self):
        self.board = subprocess.Popen([sys.executable, shop_load.__file__, "--board", str(self.folder / "m")], stdout=subprocess.PIPE, text=True)
        assert self.board.stdout.readline() == "ready\n"
        self.programs.append(self.board)

    def cut_power(self):
        self.board.send_signal(signal.SIGUSR1)
        self.board.wait(60)
        self.start_board()

    def start_agent(self):
        self.agent_process = self.agent(
            "--port", f"m={self.folder}/m/port", "--protocol", "grbl", "--board", str(self.board_file), "--shop-key", str(self.key_file), "--at-machine", "0"
        )
        for line in self.agent_process.stdout:
            if line.startswith("page: "):
                self.page = line[6:].strip().rstrip("/")
                return
        raise AssertionError("no page")

    def kill_agent(self):
        self.agent_process.kill()
        self.agent_process.wait()

    def machine(self):
        return requests.get(self.page + "/machines", timeout=10).json()[0]

    def do(self, what, **headers):
        return requests.post(self.page + "/do", json={"name": "m", "do": what}, headers={"Origin": self.page, **headers}, timeout=10)

    def how(self):
        return self.desk.machines.get("m", {}).get("how")

    def release(self):
        self.until(lambda: self.machine().get("state") in ("idle", "alarm") and self.do("release").json()["text"] == "" or self.how() not in ("rest", None))

    def drawn(self):
        self.board.terminate()
        self.board.wait(60)
        return shop_load.read_numbers(shop_load.strokes(sorted((self.folder / "m").glob("trace-*.csv"))))

    def close(self):
        self.desk.close()
        self.book.close()
        super().close()


@pytest.fixture
def bench(tmp_path):
    opened = Bench(tmp_path)
    yield opened
    opened.close()


@pytest.mark.slow
@needs_broker
def test_nothing_moves_until_somebody_at_the_machine_says_so_and_then_one_job(bench):
    bench.start_agent()
    for number in (5, 600):
        bench.book.add(shop_load.program(number), f"{number}.gcode", {"kind": shop_load.KIND})
    bench.until(lambda: bench.how() == "rest" and bench.machine().get("state") == "alarm")
    time.sleep(1)
    assert bench.book.counts() == {"queued": 2} and bench.machine()["state"] == "alarm"
    # A page of another origin, another host, or no browser's page.
    for headers in ({"Origin": "http://evil.example"}, {"Host": "evil.example"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:1"}):
        assert bench.do("release", **headers).status_code == 403, headers
    assert requests.post(bench.page + "/do", json={"name": "m", "do": "release"}, timeout=10).status_code == 403
    assert requests.post(bench.page + "/do", data=b"{", headers={"Origin": bench.page}, timeout=10).status_code == 400
    assert bench.do("jump").json()["text"] and bench.do("go").json()["text"] and bench.do("give up").json()["text"]
    assert bench.how() == "rest"
    bench.release()
    bench.until(lambda: bench.book.counts().get("done") == 1)
    time.sleep(1)
    assert bench.book.counts() == {"done": 1, "queued": 1} and bench.how() == "rest", "one release, one job"
    bench.release()
    bench.until(lambda: bench.book.counts().get("done") == 2)
    assert bench.drawn() == ([5, 600], 0, [])


@pytest.mark.slow
@needs_broker
def test_what_was_heard_before_altered_or_told_by_strangers_does_nothing(bench):
    """At a broker at which anybody may speak: what a stranger says is not signed."""
    bench.start_agent()
    bench.until(lambda: bench.how() == "rest")
    bench.book.add(shop_load.program(1), "1.gcode", {"kind": shop_load.KIND})
    bench.book.add(shop_load.program(2), "2.gcode", {"kind": shop_load.KIND})
    # A machine that is none, and the machine's own words in another's mouth, or changed.
    own = bench.told["passo/m/work"]
    for name in ("thief", "m"):
        for text in (own, own.replace('"rest"', '"free"'), json.dumps({"how": "free", "nonce": "x", "job": "", "ended": None}), "1..{}"):
            bench.client.publish(f"passo/{name}/work", text, 1)
    time.sleep(1)
    assert bench.book.counts() == {"queued": 2} and "thief" not in {job.machine for job in bench.book.jobs()}
    bench.client.publish("passo/m/order", "1.0.{}", 1).wait_for_publish(30)
    bench.release()
    bench.until(lambda: bench.book.counts().get("done") == 1)
    order = [text for topic, text, _kept in bench.heard if topic == "passo/m/order" and len(text) > 20][-1]
    assert sum(1 for topic, _text, _kept in bench.heard if topic == "passo/m/order") > 1
    bench.until(lambda: bench.machine()["state"] == "idle" and bench.do("release").json()["text"] == "" or bench.how() != "rest")
    job = bench.book.jobs()[0]
    for text in (order, order.replace(bench.book.jobs()[-1].id, job.id), sealed("B" * 16, SHOP, "x", 1, {"id": job.id})):
        bench.client.publish("passo/m/order", text, 1, retain=True)
    bench.until(lambda: bench.book.counts().get("done") == 2)
    assert bench.drawn() == ([1, 2], 0, [])


@needs_broker
def test_agent_broker_and_power_fail_and_the_job_is_drawn_once(bench):
    """The power is cut amid the job, the agent is killed before it can tell, and the broker forgets all."""
    bench.start_agent()
    bench.book.add(shop_load.program(1023), "1023.gcode", {"kind": shop_load.KIND})
    bench.release()
    bench.until(lambda: bench.how() == "run")
    bench.cut_power()
    bench.kill_agent()
    bench.broker.kill()
    bench.broker.wait()
    bench.start()
    bench.start_agent()
    bench.until(lambda: bench.how() in ("waits", "rest"))
    limit = time.monotonic() + 120
    while bench.book.counts().get("done") != 1:
        assert time.monotonic() < limit, (bench.machine(), bench.book.jobs())
        if bench.machine()["how"] == "waits":
            bench.do("go")
        time.sleep(0.1)
    numbers, twice, faults = bench.drawn()
    assert numbers == [1023] and not faults and twice <= 50 * shop_load.STEPS_MM  # a second's way at most

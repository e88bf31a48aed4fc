"""The shop's queue: its book, its signed messages, which machine gets a job, and how a machine at rest, killed or asked again behaves."""

import hashlib
import json
import os
import re
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
import requests
from test_agent import Late, Shop, agent_of, needs_broker

from host_tools import interpreter, language
from host_tools.clients import page_key
from host_tools.failure import Failure
from host_tools.language import error_text
from host_tools.panel.panel import FOLDER
from host_tools.shop import uploads
from host_tools.shop.job_table import JobTable
from host_tools.shop.dispatcher import LASER_CLASSES, Dispatcher, job_fits
from host_tools.shop.machines import MOST_STRANGERS
from host_tools.shop.signed import MACHINE, SHOP, Opener, sign_message
from passo import errors
from passo.web import session

sys.path.insert(0, str(Path(__file__).parents[1] / "sims"))
import shop_load  # noqa: E402
from machine_page import MachinePage  # noqa: E402
from titles import WITHOUT  # noqa: E402

KEY = "ABCDEFGHJKLMNPQR"


@pytest.fixture
def book(tmp_path):
    opened = JobTable(tmp_path / "shop.sqlite")
    yield opened
    opened.close()


# --- the book


def test_a_job_is_given_once_whatever_is_asked_for_again(book, tmp_path):
    one, two = book.add_jobs(b"G0X1", "a.gcode", {"kind": "k"}, 2)
    job = book.give_job("m1", "nonce", lambda job: True)
    assert job.id == one and book.open_of("m1").nonce == "nonce"
    assert book.give_job("m1", "other", lambda job: True) is None, "a machine has one job"
    assert book.give_job("m2", "nonce", lambda job: True).id == two
    assert book.give_job("m3", "nonce", lambda job: True) is None
    book.note_progress(job, "begun", 3, "")
    with pytest.raises(sqlite3.IntegrityError):
        book._change_rows("update jobs set machine = 'm2' where id = ?", one)
    again = JobTable(tmp_path / "shop.sqlite")
    assert again.open_of("m1").line == 3 and again.open_of("m1").begun
    again.end(again.open_of("m1"), "done", 9, "")
    assert again.open_of("m1") is None and again.count_states() == {"done": 1, "given": 1}
    assert not again.withdraw_job(two) and again.file_data(job.sha) == b"G0X1"
    assert [row[1] for row in again.times_of_materials()] == [1]
    again.close()


def test_jobs_are_given_in_their_order_to_machines_that_fit(book):
    book.add_jobs(b"1", "big", {"kind": "k", "area": [300, 100]})
    book.add_jobs(b"2", "red", {"kind": "k", "tool": "red"})
    book.add_jobs(b"3", "any", {"kind": "k", "tool": ""})
    blue = {"kind": "k", "tool": "blue", "area": [200, 200]}
    assert book.give_job("blue", "n", lambda job: job_fits(job, blue)).name == "any"
    assert book.give_job("red", "n", lambda job: job_fits(job, {**blue, "tool": "red"})).name == "red"
    assert not job_fits(book.jobs()[0], {**blue, "kind": "another"})
    assert book.give_job("big", "n", lambda job: job_fits(job, {"kind": "k", "area": [300, 100]})).name == "big"


def test_a_laser_is_given_what_may_be_burnt_by_its_class_and_no_other(book):
    def takes(most, **machine):
        book.add_jobs(b"1", "cut", {"kind": "k", "laser": most})
        job = book.give_job("m", "n", lambda job: job_fits(job, {"kind": "k", **machine}))
        if job:
            book.end(job, "done", 1, "")
        else:
            book.withdraw_job(book.jobs(1)[0].id)
        return bool(job)

    assert [has for has in LASER_CLASSES if takes("1M", laser=has)] == ["1", "1C", "1M"]
    assert [has for has in LASER_CLASSES if takes("3B", laser=has)] == ["1", "1C", "1M", "2", "2M", "3R", "3B"]
    assert not takes("4", laser="") and not takes("4"), "nobody has said what it is"
    assert all(takes("", laser=has) for has in ("", *LASER_CLASSES))
    book.add_jobs(b"1", "of an older shop", {"kind": "k"})
    assert job_fits(book.jobs()[0], {"kind": "k", "laser": "4"})


def test_a_job_that_is_done_before_its_machine_could_say_more_began(book):
    one, two = book.add_jobs(b"G0X1", "a", {"kind": "k", "material": "A4"}, 2)
    book.end(book.give_job("m", "n", lambda job: True), "done", 9, "")
    book.end(book.give_job("m", "n", lambda job: True), "refused", 0, "")
    assert book.job_by_id(one).begun == book.job_by_id(one).ended and book.times_of_materials() == [("A4", 1, 0.0)]
    assert book.job_by_id(two).begun is None


# --- what is signed


def test_an_order_is_good_once_for_its_end_its_nonce_and_as_it_was():
    text = sign_message(KEY, SHOP, "nonce", 1, {"id": "1"})
    opener = Opener(KEY, SHOP, "nonce")
    assert opener.open(text.replace('"1"', '"2"')) is None
    assert opener.open(text) == {"id": "1"}
    assert opener.open(text) is None, "heard before"
    for other in (Opener(KEY, MACHINE, "nonce"), Opener(KEY, SHOP, "other"), Opener("B" * 16, SHOP, "nonce")):
        assert other.open(text) is None
    for noise in ("", "..", "1", "1.2.3", "9" * 40 + ".a.b", sign_message(KEY, SHOP, "nonce", 2, [1]), "2.é.{}"):
        assert opener.open(noise) is None


# --- what is dropped


def test_a_file_that_a_board_refuses_is_told_by_its_line():
    with pytest.raises(Failure, match="a.gcode: line 2 would be refused"):
        uploads.job_of("a.gcode", b"G0 X10\nG99999\n", "corexy_plotter")


@pytest.mark.slow
def test_a_file_is_checked_before_it_is_queued():
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30"><path d="M5 5H25V20"/></svg>'
    name, data, facts = uploads.job_of("a.svg", svg, "corexy_plotter")
    assert name == "a.svg.gcode" and b"M3" in data and facts["seconds"] > 1 and facts["area"][0] > 19
    for name, data, what in (
        ("a.gcode", b"G0 X10\nG99999\n", "line 2"), ("a.gcode", b"G0 X2000\n", "larger"), ("a.gcode", b"", "no line"), ("../a", b"G0X1", "name"),
        ("a.svg", b"<svg", None), ("a.gcode", b"\0\1", None),
    ):  # fmt: skip
        with pytest.raises(Failure, match=what):
            uploads.job_of(name, data, "corexy_plotter")
    with pytest.raises(Failure, match="journal"):
        uploads.job_of("a.gcode", b"G0X1", "plotter_2014")
    assert "corexy_plotter" in uploads.list_kinds()


# --- one machine, a real broker


class Bench(Shop):
    """Mosquitto, a virtual plotter, its agent and a desk, each of which can be killed."""

    def __init__(self, folder):
        from host_tools.shop.link import Broker

        super().__init__(folder)
        self.folder = folder
        self.key = page_key.make_key(os.urandom)
        self.key_file = folder / "shop.key"
        self.key_file.write_text(self.key)
        self.key_file.chmod(0o600)
        self.page_key = folder / "page.key"
        self.board_file = shop_load.board_file(folder)
        (folder / "m").mkdir()
        self.board = None
        self.start_board()
        self.book = JobTable(folder / "shop.sqlite")
        self.dispatcher = Dispatcher(Broker("127.0.0.1", self.port), self.key, self.book)
        self.page = ""
        self.agent_process = None

    def start_board(self):
        self.board = subprocess.Popen([*interpreter.python(), shop_load.__file__, "--board", str(self.folder / "m"), "fast"], stdout=subprocess.PIPE, text=True)
        assert self.board.stdout.readline() == "ready\n"
        self.programs.append(self.board)

    def cut_power(self):
        self.board.send_signal(signal.SIGUSR1)
        self.board.wait(60)
        self.start_board()

    def start_agent(self):
        self.agent_process = self.agent(
            "--port", f"m={self.folder}/m/port", "--protocol", "grbl", "--board", str(self.board_file), "--shop-key", str(self.key_file), "--at-machine", "0",
            "--page-key", str(self.page_key),
        )  # fmt: skip
        for line in self.agent_process.stdout:
            if line.startswith("page: "):
                self.page = line[6:].strip().rstrip("/")
                self.person = MachinePage(self.page, self.page_key.read_text().strip())
                return
        raise AssertionError("no page")

    def kill_agent(self):
        self.agent_process.kill()
        self.agent_process.wait()

    def machine(self):
        return self.person.machines()[0]

    def do(self, what, **headers):
        return self.person.do("m", what, **headers)

    def how(self):
        return self.dispatcher.machines.get("m", {}).get("how")

    def release(self):
        self.until(lambda: self.machine().get("state") in ("idle", "alarm") and self.do("release").json()["text"] == "" or self.how() not in ("rest", None))

    def drawn(self):
        self.board.terminate()
        self.board.wait(60)
        return shop_load.read_numbers(shop_load.strokes(sorted((self.folder / "m").glob("trace-*.csv"))))

    def close(self):
        self.dispatcher.close()
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
        bench.book.add_jobs(shop_load.program(number), f"{number}.gcode", {"kind": shop_load.KIND})
    bench.until(lambda: bench.how() == "rest" and bench.machine().get("state") == "alarm")
    time.sleep(1)
    assert bench.book.count_states() == {"queued": 2} and bench.machine()["state"] == "alarm"
    # A page of another origin, another host, or no browser's page.
    for headers in ({"Origin": "http://evil.example"}, {"Host": "evil.example"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:1"}):
        assert bench.do("release", **headers).status_code == 403, headers
    assert requests.post(bench.page + "/do", json={"name": "m", "do": "release"}, timeout=10).status_code == 403
    assert requests.post(bench.page + "/do", data=b"{", headers={"Origin": bench.page}, timeout=10).status_code == 400
    assert bench.do("jump").json()["text"] and bench.do("go").json()["text"] and bench.do("give up").json()["text"]
    assert bench.how() == "rest"
    bench.release()
    bench.until(lambda: bench.book.count_states().get("done") == 1)
    time.sleep(1)
    assert bench.book.count_states() == {"done": 1, "queued": 1} and bench.how() == "rest", "one release, one job"
    bench.release()
    bench.until(lambda: bench.book.count_states().get("done") == 2)
    assert bench.drawn() == ([5, 600], 0, [])


@pytest.mark.slow
@needs_broker
def test_what_was_heard_before_altered_or_told_by_strangers_does_nothing(bench):
    """The broker lets anybody publish: a stranger's messages are not signed."""
    bench.start_agent()
    bench.until(lambda: bench.how() == "rest")
    bench.book.add_jobs(shop_load.program(1), "1.gcode", {"kind": shop_load.KIND})
    bench.book.add_jobs(shop_load.program(2), "2.gcode", {"kind": shop_load.KIND})
    # A machine that is none, and the machine's own words in another's mouth, or changed.
    own = bench.told["passo/m/work"]
    for name in ("thief", "m"):
        for text in (own, own.replace('"rest"', '"free"'), json.dumps({"how": "free", "nonce": "x", "job": "", "ended": None}), "1..{}"):
            bench.client.publish(f"passo/{name}/work", text, 1)
    time.sleep(1)
    assert bench.book.count_states() == {"queued": 2} and "thief" not in {job.machine for job in bench.book.jobs()}
    bench.client.publish("passo/m/order", "1.0.{}", 1).wait_for_publish(30)
    bench.release()
    bench.until(lambda: bench.book.count_states().get("done") == 1)
    order = [text for topic, text, _kept in bench.heard if topic == "passo/m/order" and len(text) > 20][-1]
    assert sum(1 for topic, _text, _kept in bench.heard if topic == "passo/m/order") > 1
    bench.until(lambda: bench.machine()["state"] == "idle" and bench.do("release").json()["text"] == "" or bench.how() != "rest")
    job = bench.book.jobs()[0]
    for text in (order, order.replace(bench.book.jobs()[-1].id, job.id), sign_message("B" * 16, SHOP, "x", 1, {"id": job.id})):
        bench.client.publish("passo/m/order", text, 1, retain=True)
    bench.until(lambda: bench.book.count_states().get("done") == 2)
    assert bench.drawn() == ([1, 2], 0, [])


@needs_broker
def test_the_button_at_the_machine_releases_it_for_one_job(bench):
    """The input `resume` of a virtual board: closed from the start it does nothing; then it is opened and closed."""
    bench.board.send_signal(signal.SIGUSR2)
    bench.start_agent()
    for number in (7, 8):
        bench.book.add_jobs(shop_load.program(number), f"{number}.gcode", {"kind": shop_load.KIND})
    bench.until(lambda: bench.how() == "rest" and bench.machine().get("state") == "alarm")
    time.sleep(1)
    assert bench.book.count_states() == {"queued": 2} and bench.machine()["how"] == "rest"
    bench.board.send_signal(signal.SIGUSR2)
    time.sleep(1)
    bench.board.send_signal(signal.SIGUSR2)
    bench.until(lambda: bench.book.count_states().get("done") == 1)
    time.sleep(1)
    assert bench.book.count_states() == {"done": 1, "queued": 1} and bench.how() == "rest", "it is still held"
    assert bench.drawn() == ([7], 0, [])


@needs_broker
def test_a_file_that_another_has_put_on_the_broker_is_not_drawn(bench):
    """Its digest is not the one that the shop has signed: nothing moves, and the machine says why; the right file is drawn then."""
    bench.start_agent()
    right = shop_load.program(9)
    bench.book.add_jobs(right, "9.gcode", {"kind": shop_load.KIND})
    put = bench.dispatcher._publish_file
    topic = "passo/file/" + hashlib.sha256(right).hexdigest() + "/0"
    bench.dispatcher._publish_file = lambda sha: bench.client.publish(topic, shop_load.program(10), 1, True).wait_for_publish(30)
    bench.release()
    bench.until(lambda: bench.machine()["text"])
    time.sleep(1)
    told = bench.machine()
    assert told["how"] == "fetch" and "is not the one" in told["text"]["en"] and "não é o" in told["text"]["pt"]
    assert bench.book.count_states() == {"given": 1} and bench.dispatcher.machines["m"]["text"] == told["text"]["en"]
    bench.dispatcher._publish_file = put
    put(hashlib.sha256(right).hexdigest())
    bench.until(lambda: bench.book.count_states().get("done") == 1)
    assert bench.drawn() == ([9], 0, [])


@needs_broker
def test_agent_broker_and_power_fail_and_the_job_is_drawn_once(bench):
    """The power is cut amid the job, the agent is killed before it can tell, and the broker forgets all."""
    bench.start_agent()
    bench.book.add_jobs(shop_load.program(1023), "1023.gcode", {"kind": shop_load.KIND})
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
    while bench.book.count_states().get("done") != 1:
        assert time.monotonic() < limit, (bench.machine(), bench.book.jobs())
        if bench.machine()["how"] == "waits":
            bench.do("go")
        time.sleep(0.1)
    numbers, twice, faults = bench.drawn()
    assert numbers == [1023] and not faults and twice <= 50 * shop_load.STEPS_MM  # a second's way at most


# --- the desk


class Nothing:
    """A broker's client that keeps what is published."""

    def __init__(self):
        self.published, self.subscribed = [], []

    def make_client(self, name):
        return self

    def is_connected(self):
        return True

    def disconnect(self):
        pass

    loop_stop = disconnect

    def subscribe(self, topics):
        self.subscribed.append(topics)

    def connect_client(self, client):
        pass

    def publish(self, topic, text, *_more):
        self.published.append((topic, text))


def test_a_machine_that_is_released_before_it_is_back_gets_its_job(book):
    """The desk reads its release while the broker still says "gone", and gives it the job once the broker says that it is back."""
    broker = Nothing()
    dispatcher = Dispatcher(broker, KEY, book)

    def hear(topic, text):
        dispatcher._take_message(None, None, SimpleNamespace(topic=f"passo/m/{topic}", payload=text.encode()))

    body = {"how": "free", "job": "", "nonce": "n", "line": 0, "text": "", "ended": None, "area": [9, 9], "kind": "k"}
    book.add_jobs(b"G0X1", "a", {"kind": "k"}, 2)
    for state in ("gone", "lost"):
        hear("state", state)
        hear("work", sign_message(KEY, MACHINE, f"{dispatcher._nonce} m", 1 + len(broker.published), body))
        assert not book.open_of("m")
        hear("state", "idle")
        job = book.open_of("m")
        assert job and [topic for topic, _text in broker.published if topic.endswith("order")][-1:] == ["passo/m/order"]
        hear("state", "run")
        book.end(job, "done", 1, "")
    assert book.count_states() == {"done": 2}


@pytest.fixture
def heard(book):
    """Return (desk, its broker, hear(machine, topic, text), told(machine, count, …)), which brings a machine's signed message."""
    broker = Nothing()
    dispatcher = Dispatcher(broker, KEY, book)

    def hear(name, topic, text):
        dispatcher._take_message(None, None, SimpleNamespace(topic=f"passo/{name}/{topic}", payload=text.encode()))

    def told(name, count, **fields):
        body = {"how": "rest", "job": "", "nonce": "n", "line": 0, "text": "", "ended": None, "area": [9, 9], "kind": "k", **fields}
        hear(name, "work", sign_message(KEY, MACHINE, f"{dispatcher._nonce} {name}", count, body))

    yield dispatcher, broker, hear, told
    dispatcher.close()


def test_strangers_names_are_bounded_and_take_no_room_of_machines(heard):
    dispatcher, broker, hear, told = heard
    told("before", 1)
    for number in range(5000):
        hear(f"s{number}", "state", "idle")
        hear(f"s{number}", "work", "1.0.{}")
    for name in ("", "x" * 41, "é", "a b", "-"):
        hear(name, "state", "idle")
        told(name, 1)
    assert len(dispatcher.machines) == 1 + MOST_STRANGERS
    asked = len(broker.subscribed)
    hear("after", "state", "idle")
    told("after", 1)
    assert dispatcher.machines["after"]["how"] == "rest" and len(broker.subscribed) == asked + 1, "the broker tells its state again"
    hear("after", "state", "idle")
    hear("before", "alarm", "x" * 3000)
    assert dispatcher.machines["after"]["state"] == "idle" and "alarm" not in dispatcher.machines["before"]
    for number in range(1000):
        told(f"own{number}", 1)
    assert len(dispatcher.machines) == 1002 + MOST_STRANGERS


def test_a_clock_that_is_set_back_silences_no_machine(heard, book, monkeypatch):
    dispatcher, broker, hear, told = heard
    monkeypatch.setattr("host_tools.shop.dispatcher._RENEW_S", 0.01)
    book.add_jobs(b"G0X1", "a", {"kind": "k"})
    for name in ("m", "other"):
        told(name, 10**9)
    told("m", 10**9)  # repeated, as a broker may
    assert dispatcher._renewing is None
    before = dispatcher._nonce
    for name in ("m", "other"):
        told(name, 5, how="free", nonce=name)
    limit = time.monotonic() + 20
    while dispatcher._nonce == before:
        assert time.monotonic() < limit
        time.sleep(0.01)
    assert ("passo/shop", dispatcher._nonce) in broker.published and not book.open_of("m")
    told("other", 6)
    told("m", 6, how="free", nonce="m")
    assert book.open_of("m") and dispatcher.machines["other"]["how"] == "rest"


@pytest.mark.parametrize("now_s", [0.0, 1.0, 1.8e9, 4.2e9, 2.5e11])
def test_a_count_has_twelve_digits_whatever_the_clock_says(now_s, monkeypatch):
    board, _port, _run = agent_of(Late)
    monkeypatch.setattr(time, "time", lambda: now_s)
    assert Opener("KEY", MACHINE, "n m").open(board.work.message_for("n"))["how"] == "rest"


def test_a_job_of_a_machine_that_has_another_name_now_is_ended_on_the_page(heard, book, monkeypatch):
    from host_tools.shop.shop_server import Shop

    dispatcher, broker, hear, told = heard
    shop = Shop(dispatcher, book, KEY, "127.0.0.1")
    (job,) = book.add_jobs(b"G0X1", "a", {"kind": "k"})
    told("old", 1, how="free")
    told("old", 2, how="run", job=job, line=3)

    def end(job):
        return shop.answer_order({"do": "end", "job": job}, True)["error"]

    monkeypatch.setattr("host_tools.shop.shop_server._HEARD_S", -1.0)
    assert end(job) == errors.BUSY and shop.page_state()["adrift"] == [], "its machine has it"
    hear("old", "state", "gone")
    told("new", 1, how="free")
    assert shop.page_state()["adrift"] == [job] and book.open_of("old").id == job
    assert shop.answer_order({"do": "end", "job": job}, False)["error"] == errors.NO_SESSION
    assert end(job) == 0 and end(job) == end("0" * 8) == errors.NO_SUCH_JOB
    assert shop.page_state()["adrift"] == [] and book.count_states() == {"left": 1}
    assert shop.page_state()["jobs"][0]["text"]["pt"] != shop.page_state()["jobs"][0]["text"]["en"]
    # It was only out of reach, and has drawn on: its word counts.
    hear("old", "state", "run")
    told("old", 3, how="run", job=job, line=9)
    assert book.open_of("old").line == 9
    told("old", 4, ended=[job, "done", 12, ""])
    assert book.count_states() == {"done": 1}
    (again,) = book.add_jobs(b"G0X1", "a", {"kind": "k"})
    told("old", 5, how="free")
    hear("old", "state", "gone")
    assert end(again) == 0
    told("old", 6, ended=[again, "done", 12, ""])
    assert book.count_states() == {"done": 2}


# --- the pages


PAGE = Path(__file__).parents[2] / "host_tools" / "shop" / "page"


def test_every_word_of_the_pages_is_in_the_catalogue():
    """Texts of the two pages of HTML, and those of their scripts: in pt.json, and no others."""
    words = json.loads((PAGE / "pt.json").read_text(encoding="utf-8"))
    html = "".join((PAGE / name).read_text(encoding="utf-8") for name in ("shop.html", "machine.html"))
    scripts = "".join(path.read_text(encoding="utf-8") for path in PAGE.glob("*.js"))
    body = re.sub(r"<head>.*?</head>|<[^>]*lang=\"(?:en|pt)\">[^<]*</option>", "", html, flags=re.DOTALL)
    wanted = {text.strip() for text in re.findall(r">([^<]+)<", body) if re.search(r"[a-z]{2}", text, re.IGNORECASE)}
    wanted |= set(re.findall(r'_\("([^"]+)"', scripts)) | set(re.findall(r'button\("([^"]+)"', scripts))
    for table in re.findall(r"(?:HOW|ENDED|states) = \{(.*?)\};", scripts, re.DOTALL):
        wanted |= set(re.findall(r': "([^"]+)"', table))
    wanted |= {"The tool may go down", "Go on", "Withdraw", "Again", "The last job is done: take it out.", "The last job was not done."}
    assert wanted == set(words), (wanted - set(words), set(words) - wanted)
    assert all(words.values())


class Served:
    """A Shop without a broker, as pages ask it."""

    is_up = False
    machines = {"m": {"how": "rest", "state": "idle", "job": "", "nonce": "secret"}}
    stops = looks = 0

    def stop_all(self):
        self.stops += 1

    def look(self):
        self.looks += 1


@pytest.fixture
def served(book):
    from host_tools.shop.shop_server import Shop

    dispatcher = Served()
    return dispatcher, Shop(dispatcher, book, KEY, "127.0.0.1")


def test_who_has_no_key_looks_and_stops_and_does_nothing_else(served, book):
    dispatcher, shop = served
    ids = book.add_jobs(b"G0X1", "a", {"kind": "k"})
    for order in ({"do": "withdraw", "job": ids[0]}, {"do": "again", "job": ids[0]}, {"do": "drop"}, {"do": "jump"}, [], {"do": []}):
        assert shop.answer_order(order, False)["error"] == errors.NO_SESSION
    assert book.count_states() == {"queued": 1}
    assert shop.answer_order({"do": "stop"}, False)["error"] == 0 and dispatcher.stops == 1
    assert "secret" not in json.dumps(shop.page_state()), "a nonce is for the shop alone"


def test_orders_of_the_page_are_proven_and_good_once(served, book):
    _desk, shop = served
    ids = book.add_jobs(b"G0X1", "a", {"kind": "k"}, 3)
    pages = shop.server.pages
    page = pages.add_page(None, pages.first_fields({}), 0)
    signs = session.Session(KEY, page.hello["nonce"])

    def said(count, order, sign=signs):
        body = json.dumps(order)
        return f"{count}.{sign.proof(str(count), body)}.{body}"

    first = said(1, {"do": "withdraw", "job": ids[0], "id": 1})
    assert pages.answer_message(page, first, 0) == {"t": "answer", "do": "withdraw", "error": 0, "id": 1}
    assert pages.answer_message(page, first, 0)["error"] == errors.NO_SESSION
    altered = said(2, {"do": "withdraw", "job": ids[1]}).replace(ids[1], ids[2])
    assert pages.answer_message(page, altered, 0)["error"] == errors.NO_SESSION
    assert pages.answer_message(page, said(3, {"do": "withdraw", "job": ids[1]}, session.Session("B" * 16, page.hello["nonce"])), 0)["error"] == errors.NO_SESSION
    assert pages.answer_message(page, json.dumps({"do": "withdraw", "job": ids[1]}), 0)["error"] == errors.NO_SESSION
    assert book.count_states() == {"queued": 2}
    more = {"do": "drop", "name": "a", "text": "x", "kind": "corexy_plotter", "copies": 1, "tool": "", "last": True}
    wrongs = [
        {"do": "withdraw"}, {"do": "withdraw", "job": 5}, {"do": "drop", "name": 1}, {**more, "at": 7}, {"do": "again", "job": "0" * 8}, {"do": []},
        {**more, "kind": "nobody's"}, {**more, "copies": 0}, {**more, "copies": 10**9}, {**more, "copies": True}, {**more, "tool": "é"}, {**more, "laser": "5"}, {**more, "laser": []}, {**more, "text": "x" * 40_000},
    ]  # fmt: skip
    for count, wrong in enumerate(wrongs, 10):
        assert pages.answer_message(page, said(count, wrong), 0)["error"], wrong
    assert book.count_states() == {"queued": 2}


def test_an_upload_keeps_to_its_order_and_its_size(served, book, monkeypatch):
    _desk, shop = served
    monkeypatch.setattr(uploads, "MOST_BYTES", 100_000)

    def said(page, text, **more):
        return shop.answer_order({"do": "drop", "name": "a", "text": text, "kind": "corexy_plotter", "copies": 1, "tool": "", **more}, True, page)["error"]

    piece = "x" * 30_000
    assert said(1, piece, at=30_000) == errors.JOB_PIECE, "its first piece is missing"
    assert [said(1, piece, at=at) for at in (0, 30_000, 60_000)] == [0, 0, 0]
    assert said(1, piece, at=60_000) == errors.JOB_PIECE, "a piece sent twice must be refused"
    assert said(1, piece, at=90_000, last=True) == errors.JOB_SIZE and said(1, "x", at=90_000) == errors.JOB_PIECE, "nothing of it is kept"
    assert said(1, piece, at=0) == 0 and said(1, piece, at=30_000, name="b") == errors.JOB_PIECE
    for at in (0, 30_000):  # two files of one page, piece by piece
        assert [said(1, piece, at=at, name=name) for name in "ab"] == [0, 0]
    for page in range(100):  # pages that begin and go
        assert said(page, piece, at=0) == 0
    assert len(shop._coming) <= 30 and book.count_states() == {}


def script(text):
    """Run JavaScript that imports the page's modules, under node with a heap of 300 MB. Return its output as JSON, and its seconds of processor time."""
    if not shutil.which("node"):
        pytest.skip("there is no node: the page's scripts were NOT run")
    begun = resource.getrusage(resource.RUSAGE_CHILDREN)
    folders = "".join(f'const {name} = await import("{path}");\n' for name, path in (("shop", PAGE / "thumbnail.js"), ("paths", FOLDER / "gcode_path.js"), ("files", PAGE / "pieces.js")))
    told = subprocess.run(
        ["node", "--no-warnings", "--experimental-default-type=module", "--max-old-space-size=300", "--input-type=module", "-"], input=folders + text, capture_output=True, text=True, check=True
    )
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return json.loads(told.stdout), ended.ru_utime - begun.ru_utime


def test_a_job_of_150_000_points_has_a_picture():
    """Every move is in it that a pixel can show, and it is bounded in time and memory."""
    found, seconds = script("""
        const lines = ["G21G90G0X10Y0", "G1F6000"];
        for (let n = 1; n <= 150000; n++) lines.push(`G1X${(10 * Math.cos(n / 100)).toFixed(3)}Y${(10 * Math.sin(n / 100) * (1 - n / 300000)).toFixed(3)}`);
        const made = shop.thumbnail(paths.read(lines.join("\\n")));
        let xs = [], count = 0;
        for (const { points } of made.strokes) { count += points.length / 2; for (let n = 0; n < points.length; n += 2) xs.push(points[n], points[n + 1]); }
        xs = xs.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [1e9, -1e9]);
        console.log(JSON.stringify({ last: made.last, count, low: xs[0], high: xs[1], none: shop.thumbnail(paths.read("G0X5")), line: made.strokes[0].line }));
    """)
    assert found["last"] == 150_002 and found["line"] == 3 and found["none"] is None
    assert 0 < found["low"] < 10 and found["high"] > 170 and found["count"] < 400_000
    assert seconds < 5


def test_pieces_of_a_file_fit_into_messages_whatever_its_letters():
    texts = ["", "x" * 100_000, "é" * 60_000, "😀" * 50_000, '"' * 70_000, "\1" * 40_000, "a" * 30_000 + "漢" * 30_001]
    found, _seconds = script(f"console.log(JSON.stringify({json.dumps(texts, ensure_ascii=False)}.map(files.pieces)))")
    for text, pieces in zip(texts, found):
        assert "".join(piece["text"] for piece in pieces) == text
        assert [piece["at"] for piece in pieces] == [sum(len(each["text"]) for each in pieces[:number]) for number in range(len(pieces))]
        assert [piece["last"] for piece in pieces] == [False] * (len(pieces) - 1) + [True]
        assert all(len(json.dumps(piece, ensure_ascii=False).encode()) < 45_000 and len(piece["text"]) <= 32_768 for piece in pieces)


@pytest.fixture
def browser(tmp_path):
    """Chromium, in Portuguese, as wide as a small phone."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="there is no selenium: the shop's page was NOT tried in a browser")
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not (chromium and driver):
        pytest.skip("there is no chromium with its driver: the shop's page was NOT tried in a browser")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    options.add_experimental_option("prefs", {"intl.accept_languages": "pt-BR"})
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=500,900", f"--user-data-dir={tmp_path}/browser"):
        options.add_argument(argument)
    opened = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    opened.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 320, "height": 700, "deviceScaleFactor": 1, "mobile": True})
    yield opened
    opened.quit()


SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30"><path d="M5 5H25V20"/></svg>'


@pytest.mark.slow
@needs_broker
def test_a_file_is_dropped_on_the_page_and_drawn(bench, tmp_path, browser):
    """Queue an SVG twice for a tool, say "paper is in" on the machine's own page, see it done once; all in Portuguese, and 320 px wide."""
    bench.dispatcher.close()  # the program below takes its place
    shop = bench.run("shop", "--broker", f"127.0.0.1:{bench.port}", "--book", str(tmp_path / "page.sqlite"), "--shop-key", str(bench.key_file), "--http", "0")
    address = shop.stdout.readline().strip()[6:]
    agent = bench.agent(
        "--virtual", "plotter=corexy_plotter", "--shop-key", str(bench.key_file), "--at-machine", "0", "--tool", "plotter=red", "--page", "plotter=http://127.0.0.1:1/",
        "--laser-class", "plotter=1M", "--page-key", str(bench.page_key),
    )
    local = next(line[6:].strip() for line in agent.stdout if line.startswith("page: ")) + "#key=" + bench.page_key.read_text().strip()
    (tmp_path / "a.svg").write_text(SVG)

    def text(selector):
        return browser.execute_script("const found = document.querySelector(arguments[0]); return found ? found.innerText : ''", selector)

    def press(selector):
        browser.execute_script("document.querySelector(arguments[0]).click()", selector)

    browser.get(address)
    bench.until(lambda: "alarme" in text(".tile"))
    assert text(".tile .why") == language.in_languages(error_text(errors.LOCKED))["pt"] != error_text(errors.LOCKED), "the agent speaks English"
    for value, shown in (("=free", False), ("grbl", True), ("=waits", False), ("corexy_plotter · red", True), ("", True)):
        browser.execute_script("const filter = document.getElementById('filter'); filter.value = arguments[0]; filter.dispatchEvent(new Event('change'))", value)
        assert browser.find_element("id", "filter").get_property("value") == value
        assert browser.find_element("css selector", ".tile").is_displayed() == shown, value
    assert "key=" not in browser.current_url
    assert browser.find_element("css selector", ".tile a").get_attribute("href") == "http://127.0.0.1:1/"
    browser.find_element("id", "file").send_keys(str(tmp_path / "a.svg"))
    for name, value in (("copies", "\ue009a\ue0002"), ("tool", "red"), ("material", "A4")):
        browser.find_element("id", name).send_keys(value)
    browser.execute_script("document.getElementById('laser').value = '2'")
    assert "laser de classe 1M" in text(".tile .state")
    browser.find_element("css selector", "#add button").click()
    bench.until(lambda: len(browser.find_elements("css selector", "#queue li")) == 2)
    assert "laser de classe 2" in text("#queue li")
    bench.until(lambda: not browser.execute_script(WITHOUT))
    assert browser.execute_script("return document.documentElement.scrollWidth") == 320
    first = browser.current_window_handle
    browser.switch_to.new_window("tab")
    browser.get(local)
    bench.until(lambda: text(".tile button") == "O papel está posto")
    assert "key=" not in browser.current_url
    bench.until(lambda: not browser.execute_script(WITHOUT))
    press(".tile button")
    bench.until(lambda: "desenhando" in text(".tile"))
    browser.switch_to.window(first)
    bench.until(lambda: browser.execute_script("return document.querySelector('.tile canvas').clientHeight") > 50)
    bench.until(lambda: len(browser.find_elements("css selector", "#history li")) == 1)
    bench.until(lambda: "não liberada" in text(".tile") and "a.svg.gcode · pronto" in text(".tile"))
    assert browser.execute_script("return document.querySelector('.tile canvas').clientHeight") > 50, "the drawing must stay on the wall"
    bench.until(lambda: text("#used").split()[:2] == ["A4", "1"])
    assert "1 trabalhos na fila, 1 prontos" in text("#counts")
    press("#queue button")
    # Two drops close together, each of several pieces: both arrive, and the page names both, and the refused one, too.
    browser.execute_script("""
        document.getElementById("copies").value = 1;
        for (const [name, line] of [["one.gcode", "G1X1"], ["bad.gcode", "G99999"], ["two.gcode", "G1X2"]]) {
            const carried = new DataTransfer();
            carried.items.add(new File(["G21G90F600\\n" + `${line}\\n(${"x".repeat(70)})\\n`.repeat(500)], name));
            document.dispatchEvent(new DragEvent("drop", { dataTransfer: carried, bubbles: true, cancelable: true }));
        }""")
    bench.until(lambda: "2 trabalhos na fila" in text("#counts"))
    bench.until(lambda: all(f"{name}.gcode: 1 na fila" in text("#said") for name in ("one", "two")) and "linha 2" in text("#said"))
    for left in (1, 0):
        press("#queue button")
        bench.until(lambda left=left: f"{left} trabalhos na fila" in text("#counts"))
    bench.until(lambda: "0 trabalhos na fila" in text("#counts"))
    browser.find_element("id", "stop").click()
    bench.until(lambda: text("#said").startswith("PARAR foi enviado"))
    bench.until(lambda: json.loads(bench.told["passo/plotter/counters"])["stops"] == 1)
    browser.get(address.partition("#")[0] + "?again")
    bench.until(lambda: "prontos" in text("#counts"))
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []

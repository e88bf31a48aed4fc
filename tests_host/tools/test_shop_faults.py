"""The shop and its agents go on, and STOP with them: with a full disk, a book that another program holds, and whatever a message says."""

import json
import sqlite3
import threading
import time
from types import SimpleNamespace

import pytest
import requests
from hypothesis import given, settings
from hypothesis import strategies as st
from test_agent import Late, Shop, agent_of, free_port, needs_broker

from host_tools.page import pages as page_module
from host_tools.shop import dispatcher as dispatcher_module
from host_tools.shop import uploads, shop_server
from host_tools.shop.job_table import JobTable, JobTableError
from host_tools.shop.dispatcher import Dispatcher
from host_tools.shop.link import Broker, Link
from host_tools.shop.signed import MACHINE, SHOP, Opener, sign_message
from host_tools.shop.work import FETCH, FREE, REST
from passo import errors
from passo.web.session import Session

KEY = "ABCDEFGHJKLMNPQR"
WORD = {"how": "free", "job": "", "nonce": "n", "line": 0, "text": "", "ended": None, "area": [9, 9], "kind": "k"}
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters(), max_size=20) | st.sampled_from(["free", "stop", "drop", "m"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=4), max_leaves=8,
)  # fmt: skip


class Client:
    """paho's, without a broker. `acknowledges`: whether it confirms each message published."""

    def __init__(self, up=True, acknowledges=True):
        self.up, self.acknowledges, self.published = up, acknowledges, []

    def make_client(self, name):
        return self

    def connect_client(self, client):
        pass

    def is_connected(self):
        return self.up

    def publish(self, topic, text, *_more):
        self.published.append((topic, text))
        return SimpleNamespace(wait_for_publish=lambda seconds: None, is_published=lambda: self.acknowledges)

    def subscribe(self, *_more):
        pass

    unsubscribe = will_set = disconnect = loop_stop = subscribe


@pytest.fixture
def book(tmp_path):
    opened = JobTable(tmp_path / "shop.sqlite")
    yield opened
    opened.close()


@pytest.fixture
def dispatcher(book, monkeypatch):
    monkeypatch.setattr(dispatcher_module, "_AGAIN_S", 0.05)
    made = Dispatcher(Client(), KEY, book)
    yield made
    made.close()


def escaped(end, nonce, count, body):
    """Return a message signed with the key, with any texts in it: half a character, too."""
    text = json.dumps(body)
    return f"{count}.{Session(KEY, f'{end} {nonce}').proof(str(count), text)}.{text}"


def hear(dispatcher, topic, payload):
    dispatcher._take_message(None, None, SimpleNamespace(topic=topic, payload=payload))


def word(dispatcher, count, name="m", **more):
    hear(dispatcher, f"passo/{name}/work", sign_message(KEY, MACHINE, f"{dispatcher._nonce} {name}", count, {**WORD, **more}).encode())


def until(condition):
    limit = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < limit
        time.sleep(0.02)


# --- the book


@pytest.mark.parametrize("fault", ["held", "full"])
def test_what_a_machine_says_while_the_book_cannot_be_written_is_done_later(book, dispatcher, tmp_path, fault):
    """Another program holds the book, or the disk is full: no message raises, none waits, STOP goes on, and then all is as if nothing had been."""
    first, _second = book.add_jobs(b"G0X1\n" * 2000, "a", {"kind": "k"}, 2)
    other = sqlite3.connect(tmp_path / "shop.sqlite", isolation_level=None)
    if fault == "held":
        other.execute("begin immediate")
    else:
        pages = book._base.execute("pragma max_page_count").fetchone()[0]
        book._base.execute("create table filler (data blob)")
        book._base.execute(f"pragma max_page_count={book._base.execute('pragma page_count').fetchone()[0]}")
        with pytest.raises(sqlite3.OperationalError):
            while True:
                book._base.execute("insert into filler values (zeroblob(500))")
    hear(dispatcher, "passo/m/state", b"idle")
    if fault == "held":
        word(dispatcher, 1)
        begun = time.monotonic()
        for count in range(2, 100):
            word(dispatcher, count)
        assert time.monotonic() - begun < 5, "only the first one has tried"
        assert dispatcher.stop_all() == 0 and "stop" in dispatcher._client.published[-1][0]
        assert book.open_of("m") is None and "locked" in book.trouble
        other.execute("rollback")
        until(lambda: book.open_of("m"))
    else:
        with pytest.raises(JobTableError, match="full"):
            book.add_jobs(b"G0X2\n" * 200_000, "b", {"kind": "k"})
        assert "full" in book.trouble and book.count_states() == {"queued": 2}
        book._base.execute(f"pragma max_page_count={pages}")
        book.add_jobs(b"G0X2\n" * 200_000, "b", {"kind": "k"})
        word(dispatcher, 1)
    assert book.open_of("m").id == first
    until(lambda: [text for topic, text in dispatcher._client.published if topic == "passo/m/order"])
    orders = [text for topic, text in dispatcher._client.published if topic == "passo/m/order"]
    assert len(orders) == 1 and not book.trouble
    other.close()


def test_the_end_of_a_job_is_written_once_the_book_can_be(book, dispatcher, tmp_path):
    book.add_jobs(b"G0X1", "a", {"kind": "k"})
    hear(dispatcher, "passo/m/state", b"idle")
    word(dispatcher, 1)
    job = book.open_of("m")
    other = sqlite3.connect(tmp_path / "shop.sqlite", isolation_level=None)
    other.execute("begin exclusive")
    word(dispatcher, 2, how="run", job=job.id, nonce="o", line=7)
    word(dispatcher, 3, how="rest", ended=[job.id, "done", 9, ""], nonce="p")
    other.execute("rollback")
    other.close()
    until(lambda: book.count_states() == {"done": 1})
    until(lambda: dispatcher._trying is None)
    assert book.job_by_id(job.id).line == 9


def test_an_order_and_a_dropped_file_that_meet_a_disk_error_are_answered(book, dispatcher, monkeypatch):
    """A number, or a text to all pages: never silence, and the file is tried again meanwhile."""
    monkeypatch.setattr(shop_server, "_AGAIN_S", 0.01)
    shop = shop_server.Shop(dispatcher, book, KEY, "127.0.0.1")
    job = book.add_jobs(b"G0X1", "a", {"kind": "k"})[0]
    page = shop.server.pages.add_page(None, {}, 0)

    def full(*_more, **_named):
        raise JobTableError(5, "database or disk is full")

    monkeypatch.setattr(book, "_change_rows", full)
    for order in ({"do": "withdraw", "job": job}, {"do": "again", "job": job}):
        assert shop.answer_order(order, True)["error"] == errors.NOT_WRITTEN

    def dropped():
        import asyncio

        page.told.clear()
        asyncio.run(shop._queue_file("a.gcode", "G21 G90\nG1 X5 F600\n", {"kind": "corexy_plotter"}, 1))
        return page.told[-1]

    assert "disk is full" in dropped()["text"]["en"] and book.count_states() == {"queued": 1}
    monkeypatch.undo()
    monkeypatch.setattr(uploads.tempfile, "TemporaryDirectory", full)
    assert "could not be queued" in dropped()["text"]["en"]
    monkeypatch.undo()
    assert dropped() == {"t": "dropped", "name": "a.gcode", "text": "", "copies": 1}
    assert shop.page_state()["trouble"] == "" and book.count_states() == {"queued": 2}


def test_the_page_says_why_and_goes_on_while_the_book_is_held(book, dispatcher, tmp_path):
    shop = shop_server.Shop(dispatcher, book, KEY, "127.0.0.1")
    shop.page_state()
    other = sqlite3.connect(tmp_path / "shop.sqlite", isolation_level=None)
    other.execute("begin immediate")
    book.changed += 1
    assert shop.answer_order({"do": "withdraw", "job": "0" * 8}, True)["error"] == errors.NOT_WRITTEN
    told = shop.page_state()["trouble"]
    assert "locked" in told["en"] and "each second" in told["en"] and "cada segundo" in told["pt"]
    begun = time.monotonic()
    assert shop.answer_order({"do": "stop"}, False)["error"] == 0 and time.monotonic() - begun < 2
    other.rollback()
    other.close()


def test_a_panel_s_order_that_meets_a_disk_error_is_answered():
    class Full(page_module.ServedPages):
        def answer_order(self, page, order, proven):
            raise OSError(28, "No space left on device")

    pages = Full(KEY, 1)
    page = pages.add_page(None, {}, 0)
    body = '{"do":"job_remove","id":7}'
    message = f"1.{Session(KEY, page.session.nonce).proof('1', body)}.{body}"
    assert pages.answer_message(page, message, 0) == {"t": "answer", "do": "job_remove", "error": errors.NOT_WRITTEN, "id": 7}


# --- STOP


def test_stop_says_whether_it_has_left(book, monkeypatch):
    for up, acknowledges, error in ((True, True, 0), (True, False, errors.NOT_SENT), (False, False, errors.NOT_SENT)):
        client = Client(up, acknowledges)
        dispatcher = Dispatcher(client, KEY, book)
        shop = shop_server.Shop(dispatcher, book, KEY, "127.0.0.1")
        assert shop.answer_order({"do": "stop"}, False)["error"] == error
        assert len(client.published) == up, "one that is kept would stop machines much later"
        dispatcher.close()


@needs_broker
def test_stop_of_the_page_and_a_broker_that_goes_away(tmp_path):
    """Over HTTP, with a real broker: 0 while it is there; killed, the answer says so, at once and when its end is not known yet."""
    import asyncio

    bench = Shop(tmp_path)
    book = JobTable(tmp_path / "shop.sqlite")
    dispatcher = Dispatcher(Broker("127.0.0.1", bench.port), KEY, book)
    shop = shop_server.Shop(dispatcher, book, KEY, "127.0.0.1")
    port = free_port()
    loop = asyncio.new_event_loop()
    serving = loop.create_task(shop.server.serve("127.0.0.1", port))
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    try:
        bench.until(lambda: dispatcher.is_up)

        def stop():
            return requests.post(f"http://127.0.0.1:{port}/stop", timeout=10).json()["error"]

        until(lambda: _listens(port))
        assert stop() == 0
        bench.until(lambda: "passo/stop" in bench.told)
        bench.broker.kill()
        bench.broker.wait()
        assert stop() == errors.NOT_SENT
    finally:
        loop.call_soon_threadsafe(serving.cancel)
        loop.call_soon_threadsafe(loop.stop)
        thread.join(10)
        dispatcher.close()
        book.close()
        bench.close()


def _listens(port):
    try:
        return requests.get(f"http://127.0.0.1:{port}/", timeout=5).ok
    except requests.RequestException:
        return False


def test_a_stop_takes_a_release_back():
    """A job for which the machine was released before a STOP does not begin after it."""
    board, port, run = agent_of(Late)
    board.note_port(True)
    run(lambda: board.work._job.record is not None and board._machine.settings)
    assert board.act("release") == ""
    run(lambda: board.work.how == FREE)
    nonce = board.work._nonce
    order = {"id": "0000000a", "name": "a", "sha": "0" * 64, "parts": 1, "again": False}
    board.stop()
    assert board.work.how == REST
    board.work.take_order(sign_message("KEY", SHOP, nonce, 1, order))
    assert board.work.how == REST, "it was for the release"
    assert b"\x18" in b"".join(port.lines)


# --- messages


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=60) | st.text(max_size=40).map(str.encode) | JSON.map(lambda value: json.dumps(value).encode()), st.sampled_from(["m/work", "m/state", "n/alarm", "m/job", "x/language", "", "a/b/c"]))
def test_no_message_ends_the_desk(tmp_path_factory, payload, topic):
    dispatcher, shop = _fuzzed(tmp_path_factory)
    hear(dispatcher, f"passo/{topic}", payload)
    json.dumps(shop.page_state())
    assert dispatcher.stop_all() == 0


@settings(max_examples=300, deadline=None)
@given(st.dictionaries(st.sampled_from([*WORD, "tool", "state", "laser", "more"]), JSON, max_size=4), st.sampled_from([{}, WORD]))
def test_no_machine_s_word_ends_the_desk(tmp_path_factory, changed, base):
    """Signed with the key, with any fields."""
    dispatcher, shop = _fuzzed(tmp_path_factory)
    dispatcher.counts = getattr(dispatcher, "counts", 0) + 1
    hear(dispatcher, "passo/m/work", escaped(MACHINE, f"{dispatcher._nonce} m", dispatcher.counts, {**base, **changed}).encode())
    json.dumps(shop.page_state())
    dispatcher.look()
    word(dispatcher, dispatcher.counts + 1, name="good")
    dispatcher.counts += 1
    assert dispatcher.machines["good"]["how"] == "free", "the next message must be read"


_MADE = []


def _fuzzed(tmp_path_factory):
    """Return one desk and shop for all examples: the traces of one must not harm the next."""
    if not _MADE:
        book = JobTable(tmp_path_factory.mktemp("fuzz") / "shop.sqlite")
        dispatcher = Dispatcher(Client(), KEY, book)
        _MADE.extend((dispatcher, shop_server.Shop(dispatcher, book, KEY, "127.0.0.1")))
    return _MADE


@settings(max_examples=300, deadline=None)
@given(JSON | st.dictionaries(st.sampled_from(["do", "id", "name", "at", "text", "last", "kind", "copies", "tool", "laser", "material", "job"]), JSON | st.sampled_from(["drop", "again", "withdraw", "stop", 0]), max_size=8))
def test_no_order_of_a_page_ends_the_shop(tmp_path_factory, order):
    _desk, shop = _fuzzed(tmp_path_factory)
    pages = shop.server.pages
    page = pages.add_page(None, {}, 0)
    body = json.dumps(order)
    try:
        answer = pages.answer_message(page, f"1.{Session(KEY, page.session.nonce).proof('1', body)}.{body}", 0)
    finally:
        pages.remove_page(page)
    assert answer["t"] == "answer" and "error" in answer


@settings(max_examples=200, deadline=None)
@given(st.dictionaries(st.sampled_from(["id", "name", "sha", "parts", "again"]), JSON | st.sampled_from(["0000000a", "0" * 64, 1, 10**12, False]), max_size=5))
def test_no_order_of_the_shop_ends_the_agent(order):
    board, _port, _run = agent_of(Late)
    work = board.work
    work._parcel = SimpleNamespace(ask=lambda sha, parts: [None] * parts, drop=lambda: None, data=lambda: None, wrong=False)
    work._opener = Opener(KEY, SHOP, work._nonce)
    work.take_order(escaped(SHOP, work._nonce, 1, order))
    board.poll(1.0)
    assert work.how in (REST, FETCH)
    board.stop()


class Unconnected(Client):
    def __getattr__(self, name):
        return lambda *_more: None


@settings(max_examples=200, deadline=None)
@given(st.text(max_size=12) | st.sampled_from(["m/stop", "stop", "file/" + "0" * 64 + "/²", "file/" + "0" * 64 + "/0", "file/" + "0" * 64 + "/99999999999", "shop", "m/order"]), st.binary(max_size=40))
def test_no_message_ends_an_agent_s_connection(topic, payload):
    stops = []
    link = Link(Unconnected(), "m", works=True)
    link.stopped = lambda: stops.append(True) or 1 / 0
    link.parcel.ask_file("0" * 64, 3)
    link._take_message(None, None, SimpleNamespace(topic=f"passo/{topic}", payload=payload))
    link._take_message(None, None, SimpleNamespace(topic="passo/stop", payload=b""))
    assert stops


def test_a_slow_check_holds_no_other_job(tmp_path, monkeypatch):
    """While one dropped file is looked at, another job is queued again and goes to a machine, STOP stops, and more files may come; they wait
    their turn."""
    import asyncio

    looks, stops, begun, may_end = [], [], threading.Event(), threading.Event()

    def slow(name, data, kind):
        if name == "slow.nc":
            begun.set()
            assert may_end.wait(120)
        return name, data, {}

    monkeypatch.setattr(uploads, "job_of", slow)
    dispatcher = SimpleNamespace(machines={}, is_up=True, stop_all=lambda: stops.append(1) or 0, look=lambda: looks.append([job.name for job in book.jobs(9) if job.state == "queued"]), complain=print)
    book = JobTable(tmp_path / "shop.sqlite")
    shop = shop_server.Shop(dispatcher, book, KEY, "127.0.0.1")
    other = book.add_jobs(b"G21\nM2\n", "other.nc", {"kind": "router_3axis"})[0]

    def dropped(name):
        return shop.answer_order({"do": "drop", "name": name, "text": "G21\nM2\n", "at": 0, "last": True, "kind": "router_3axis", "copies": 1, "tool": "T1"}, True)["error"]

    async def day():
        assert dropped("slow.nc") == 0
        await asyncio.to_thread(begun.wait, 120)
        assert dropped("next.nc") == 0
        assert shop.answer_order({"do": "again", "job": other}, True)["error"] == 0 and looks[-1].count("other.nc") == 2
        assert shop.answer_order({"do": "stop"}, False)["error"] == 0 and stops
        assert [job["name"] for job in shop.page_state()["jobs"]].count("other.nc") == 2
        may_end.set()
        while shop._tasks:
            await asyncio.sleep(0.01)

    asyncio.run(day())
    names = [job.name for job in book.jobs(9)]
    assert sorted(names) == ["next.nc", "other.nc", "other.nc", "slow.nc"], names
    book.close()

"""A board that tells an MQTT broker itself (firmware/passo/web/broker.py): with micropython-lib's umqtt, and a real broker."""

import importlib
import json
import signal
import subprocess
import sys
import time

import pytest
from test_agent import GONE, Shop, needs_broker

from host_tools import boards, interpreter
from host_tools.build.budget import heap_kb
from host_tools.clients.grbl import GrblClient
from host_tools.resources import HOST_TOOLS
from passo import error_texts
from passo.config.board_error import BoardError
from passo.config.boardfile import check
from passo.web import broker

from umqtt_here import UMQTT, needs_umqtt  # isort: skip

TOPICS = {"language", "state", "job", "progress", "place", "alarm"}


def board_with(**network):
    board = boards.load("router_pico_w")
    return {**board, "network": {**board["network"], "host": "mill-3", **network}}


# --- the board file


@pytest.mark.parametrize("address", ["broker.local", "1.2.3", "1.2.3.4.5", "1.2.3.256", "1.2.3.4:x", "1.2.3.4:70000", "1.2.3.-4", "1.2.3.4:"])
def test_an_address_is_numbers(address):
    if address == "1.2.3.4:":
        assert check(board_with(broker=address))["network"]["broker"]
        return
    with pytest.raises(BoardError, match="network.broker: an address such as"):
        check(board_with(broker=address))


def test_without_a_page_there_is_nothing_to_tell():
    board = board_with(broker="1.2.3.4")
    with pytest.raises(BoardError, match="a link on page is wanted"):
        check({**board, "links": [link for link in board["links"] if link["port"] != "page"]})


def test_the_build_counts_it():
    assert heap_kb(check(board_with(broker="1.2.3.4"))) - heap_kb(check(board_with())) >= 8


# --- with a broker


class Told(Shop):
    """Mosquitto, and a board that tells it."""

    def board(self, folder, **network):
        path = folder / "mine.py"
        path.write_text(f"BOARD = {board_with(broker=f'127.0.0.1:{self.port}', **network)!r}\n")
        words = ["board", "--board", str(path), "--time", "real", "--http", "0", "--link", str(folder / "pc")]
        program = subprocess.Popen([*interpreter.python(UMQTT), HOST_TOOLS / "cli" / "__main__.py", *words], stdout=subprocess.PIPE, text=True)
        self.programs.append(program)
        assert program.stdout.readline().startswith("port: ")
        return program

    def of(self, topic):
        return self.told.get("passo/mill-3/" + topic)


@pytest.fixture
def told(tmp_path):
    opened = Told(tmp_path)
    yield opened
    opened.close()


@needs_broker
@needs_umqtt
def test_state_stop_and_gone(told, tmp_path):
    program = told.board(tmp_path)
    told.until(lambda: told.of("state") == "alarm" and told.of("alarm"))
    assert {topic.rpartition("/")[2] for topic in told.told} == TOPICS and told.of("language") == "grbl"
    assert "home it" in told.of("alarm")
    told.client.publish("passo/stop", "kept", 1, True)
    with GrblClient(str(tmp_path / "pc")) as client:
        client.command("$X")
        told.until(lambda: told.of("state") == "idle" and told.of("alarm") == "")
        client.command("G21G91G1X60F600")
        told.until(lambda: told.of("state") == "run")
        # The broker begins anew, and has kept a STOP: it gets all topics again, and the machine goes on.
        told.broker.kill()
        told.broker.wait()
        told.told.clear()
        told.start()
        told.client.publish("passo/stop", "kept", 1, True)
        told.until(lambda: told.of("state") == "run")
        told.until(lambda: json.loads(told.of("place"))[0] > 1)
        assert client.alarm is None
        for topic, text in (("passo/stop", ""), ("passo/mill-3/stop", "x" * 100_000)):
            begun = time.monotonic()
            told.client.publish(topic, text, 1)
            while client.alarm is None:
                client.read_lines()
                assert time.monotonic() - begun < 20, topic
            told.until(lambda: told.of("state") == "alarm")
            client.alarm = None
            client.command("$X")
            client.command("G21G91G1X60F600")
            told.until(lambda: told.of("state") == "run")
    program.send_signal(signal.SIGKILL)
    told.until(lambda: told.of("state") == GONE)


@needs_broker
@needs_umqtt
def test_a_stop_that_the_broker_has_kept_stops_no_board_that_comes(told, tmp_path):
    told.client.publish("passo/stop", "kept", 1, True)
    told.client.publish("passo/mill-3/stop", "kept", 1, True)
    told.until(lambda: "passo/mill-3/stop" in told.told)
    told.board(tmp_path)
    with GrblClient(str(tmp_path / "pc")) as client:
        client.command("$X")
        client.command("G21G91G1X20F600")
        told.until(lambda: told.of("state") == "run")
        told.until(lambda: json.loads(told.of("place"))[0] > 5)
        assert client.alarm is None


# --- what the network does not take


class Socket:
    """A network on which a connection opens late, and takes and gives as many bytes as the test sets."""

    def __init__(self, *_):
        self.taken, self.room, self.comes, self.open = b"", 10_000, b"", True

    def setblocking(self, blocks):
        assert not blocks, "nothing waits"

    def connect(self, address):
        raise OSError(115, "in progress")

    def send(self, data):
        if not self.room:
            raise OSError(11, "no room")
        count = min(len(data), self.room)
        self.room -= count
        self.taken += bytes(data[:count])
        return count

    def recv(self, count):
        if not self.comes:
            raise OSError(11, "nothing")
        found, self.comes = self.comes[:count], self.comes[count:]
        return found

    def close(self):
        self.open = False


class Module:
    """The board's module `socket`."""

    def __init__(self):
        self.made = []

    def socket(self):
        self.made.append(Socket())
        return self.made[-1]

    def getaddrinfo(self, host, port):
        return [(0, 0, 0, "", (host, port))]


@pytest.fixture
def alone(monkeypatch):
    """Return (a Broker without one, the sockets that it has made, the list of its stops)."""
    if UMQTT is None:
        pytest.skip("there is no umqtt")
    monkeypatch.syspath_prepend(str(UMQTT))
    umqtt = importlib.import_module("umqtt.simple")
    module, stops = Module(), []
    monkeypatch.setattr(broker, "socket", module)
    yield broker.Broker(check(board_with(broker="1.2.3.4"))["network"], "grbl", lambda *_: stops.append(1), umqtt, error_texts.text), module.made, stops
    del sys.modules["umqtt.simple"]


def state(**more):
    return json.dumps({"state": "Idle", "alarm": 0, "stored": "", "w": [0.0, 0.0], **more}).encode()


def packets(data):
    """Return [(kind, body)] of the packets in `data`."""
    found = []
    while data:
        length, at = 0, 1
        while True:
            length |= (data[at] & 0x7F) << 7 * (at - 1)
            at += 1
            if data[at - 1] < 0x80:
                break
        found.append((data[0], data[at : at + length]))
        data = data[at + length :]
    return found


def test_a_network_that_takes_a_byte_at_a_time_gets_whole_packets(alone):
    told, sockets, _stops = alone
    told.poll(0)
    for now_ms in range(1, 2000):
        sockets[0].room = 1
        told.poll(now_ms)
        told.publish_state(state(w=[now_ms / 100, 0.0]))
    sockets[0].room = 10_000
    told.poll(2000)
    kinds = [kind for kind, _body in packets(sockets[0].taken)]
    assert kinds[:3] == [0x10, 0x82, 0x82] and set(kinds[3:]) <= {0x31, 0xC0} and len(kinds) > 20
    last = [body for kind, body in packets(sockets[0].taken) if kind == 0x31 and b"/place" in body][-1]
    assert len(sockets) == 1 and last.startswith(b"\0\x12passo/mill-3/place[")


def test_one_that_takes_nothing_is_given_up_and_begun_anew(alone):
    told, sockets, _stops = alone
    sent = 0
    for now_ms in range(0, 60_000, 50):
        told.poll(now_ms)
        if sockets:
            sockets[-1].room = 0
        told.publish_state(state(w=[now_ms / 100, 0.0]))
        sent += 1
    assert len(sockets) == 4 and not any(each.open for each in sockets[:-1])


@pytest.mark.parametrize("pieces", [1, 3, 1000])
def test_a_message_is_a_stop_and_no_other_packet(alone, pieces):
    told, sockets, stops = alone
    told.poll(0)
    now_ms = 0
    for data, count in (
        (b"\x20\x02\0\0\x90\x03\0\1\0\xd0\0", 0), (b"\x31\x0e\0\x0apasso/stopxx", 0), (b"\x30\x0e\0\x0apasso/stopxx\xd0\0", 1), (b"\x30\x8e\x01" + b"\x30" * 142, 1), (b"\x32\x00\x30\x00", 2),
    ):  # fmt: skip
        stops.clear()
        for at in range(0, len(data), pieces):
            sockets[0].comes += data[at : at + pieces]
            for _cycle in range(4):
                now_ms += 1
                told.poll(now_ms)
        assert len(stops) == count, data


def test_a_broker_that_refuses_is_asked_again_later(alone):
    told, sockets, _stops = alone
    told.poll(0)
    sockets[0].comes = b"\x20\x02\0\x05"
    for now_ms in range(0, 4900, 50):
        told.poll(now_ms)
    assert not sockets[0].open and len(sockets) == 1
    told.poll(5000)
    assert len(sockets) == 2


def test_a_stored_job(alone):
    told, sockets, _stops = alone
    told.poll(0)
    told.publish_state(state(state="Run", stored="40,PART.NC?"))
    told.poll(1)
    said = [body for kind, body in packets(sockets[0].taken) if kind == 0x31]
    assert b"\0\x10passo/mill-3/jobPART.NC" in said and b"\0\x15passo/mill-3/progress40" in said and b"\0\x12passo/mill-3/staterun" in said
    told.publish_state(state())
    told.poll(2)
    said = [body for kind, body in packets(sockets[0].taken) if kind == 0x31]
    assert said[-3:] == [b"\0\x12passo/mill-3/stateidle", b"\0\x10passo/mill-3/job", b"\0\x15passo/mill-3/progress"]


def test_umqtt_is_wanted(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(f"BOARD = {board_with(broker='1.2.3.4')!r}\n")
    done = subprocess.run([*interpreter.passo(), "board", "--board", str(path), "--http", "0"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and "mpremote mip install umqtt.simple" in done.stderr

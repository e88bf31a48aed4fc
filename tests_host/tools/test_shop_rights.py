"""Mosquitto as docs/use/mosquitto sets it up: TLS, users, who may what. Nobody without a right moves, stops or pretends anything."""

import json
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from test_agent import LIMIT_S, MOSQUITTO, Shop, free_port

from host_tools import interpreter
from host_tools.shop.job_table import JobTable
from host_tools.shop.dispatcher import Dispatcher
from host_tools.shop.link import Broker
from host_tools.clients import page_key

sys.path.insert(0, str(Path(__file__).parents[1] / "sims"))
import shop_load  # noqa: E402
from machine_page import MachinePage  # noqa: E402

MAKE = Path(__file__).parents[2] / "docs" / "use" / "mosquitto" / "make-broker.sh"
PATH = os.environ.get("PATH", "") + ":/usr/sbin"
pytestmark = pytest.mark.skipif(
    not MOSQUITTO or not shutil.which("openssl"), reason="there is no Mosquitto, or no openssl: apt-get install mosquitto openssl"
)


class Guarded(Shop):
    """The broker of make-broker.sh; `told` is what the user wall sees."""

    def configure(self, folder):
        made = subprocess.run(["sh", MAKE, "127.0.0.1", folder / "broker"], capture_output=True, text=True, env={**os.environ, "PATH": PATH}, check=True)
        self.passwords = dict(line.split() for line in made.stdout.splitlines())
        self.folder = folder / "broker"
        self.file = self.folder / "passo.conf"
        text = self.file.read_text().replace("listener 8883", f"listener {self.port} 127.0.0.1")
        self.file.write_text(text + ("user root\n" if os.geteuid() == 0 else ""))

    def make_client(self):
        return self.as_user("wall")

    def as_user(self, user, password=None, ca=None):
        broker = Broker("127.0.0.1", self.port, user, password or self.passwords.get(user, ""), str(ca or self.folder / "ca.crt"))
        return broker.make_client("")

    def agent_as(self, user, *words):
        secret = self.folder / f"{user}.password"
        secret.touch(0o600)
        secret.write_text(self.passwords[user])
        return self.agent(*words, "--user", user, "--password-file", str(secret), "--ca", str(self.folder / "ca.crt"))


@pytest.fixture
def guarded(tmp_path):
    opened = Guarded(tmp_path)
    yield opened
    opened.close()


def outcome(client, port):
    """Return the broker's answer to a client that connects: its reason, or the error that ends the connection."""
    said, done = [], threading.Event()
    client.on_connect = lambda client, userdata, flags, code, properties: (said.append(str(code)), done.set())
    try:
        client.connect("127.0.0.1", port)
    except OSError as error:
        return type(error).__name__
    client.on_disconnect = lambda *_: (said.append("closed"), done.set())
    client.loop_start()
    assert done.wait(LIMIT_S)
    client.loop_stop()
    return said[0]


def published(client, port, *messages):
    """Publish [(topic, text)] retained, as `client`; returns the broker's reasons."""
    answers, up = [], threading.Event()
    client.on_connect = lambda *_: up.set()
    client.on_publish = lambda client, userdata, number, code, properties: answers.append(str(code))
    client.connect("127.0.0.1", port)
    client.loop_start()
    assert up.wait(LIMIT_S)
    for topic, text in messages:
        client.publish(topic, text, 1, topic.endswith("state")).wait_for_publish(LIMIT_S)
    client.disconnect()
    client.loop_stop()
    return answers


def test_a_stranger_a_reader_and_who_may_stop(guarded):
    import paho.mqtt.client as mqtt

    port = guarded.port
    # Strangers: without a password, with a wrong one, without TLS, and a broker that another authority has signed.
    assert outcome(guarded.as_user(""), port) == "Not authorized"
    assert outcome(guarded.as_user("wall", "guessed"), port) == "Not authorized"
    assert outcome(mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5), port) == "closed"
    other = guarded.folder / "other.crt"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", "/CN=other",
         "-keyout", guarded.folder / "other.key", "-out", other],
        check=True, capture_output=True,
    )  # fmt: skip
    assert outcome(guarded.as_user("wall", ca=other), port) == "SSLCertVerificationError"
    # The agent may publish for its own machine, not for another one.
    agent = guarded.agent_as("pc-1", "--virtual", "mill=plotter_2014", "--virtual", "press=plotter_2014")
    guarded.until(lambda: guarded.told.get("passo/mill/state") == "idle")
    # A reader: stops nothing, pretends nothing.
    tried = [("passo/stop", "x"), ("passo/mill/stop", "x"), ("passo/mill/state", "gone"), ("passo/new/state", "idle")]
    tried += [("passo/mill/work", "x"), ("passo/mill/order", "x"), ("passo/shop", "x"), ("passo/file/0/0", "x")]
    assert published(guarded.as_user("wall"), port, *tried) == ["Not authorized"] * 8
    # An agent: not for others, and it cannot stop all.
    assert published(guarded.as_user("pc-1"), port, ("passo/press/state", "idle"), ("passo/stop", "x")) == ["Not authorized"] * 2
    # A user that may stop: stops, and pretends nothing.
    assert published(guarded.as_user("stop"), port, ("passo/mill/state", "gone"), ("passo/stop", "x")) == ["Not authorized", "Success"]
    # The shop: gives jobs, and speaks for no machine.
    assert published(guarded.as_user("shop"), port, ("passo/mill/work", "x"), ("passo/mill/state", "gone"), ("passo/file/0/0", "")) == ["Not authorized", "Not authorized", "Success"]
    guarded.until(lambda: json.loads(guarded.told["passo/mill/counters"])["stops"] > 0)
    assert json.loads(guarded.told["passo/mill/counters"])["stops"] == 1, "the others' had come before it"
    assert guarded.told["passo/mill/state"] == "idle"
    guarded.until(lambda: {topic.split("/")[1] for topic, _text, _kept in guarded.heard} >= {"mill", "stop", "file"})
    assert {topic.split("/")[1] for topic, _text, _kept in guarded.heard} == {"mill", "stop", "file"}
    agent.terminate()
    assert agent.wait(LIMIT_S) == 0


def test_an_agent_says_why_it_is_not_let_in(guarded, tmp_path):
    secret = tmp_path / "password"
    secret.touch(0o600)
    secret.write_text("guessed")
    for words, why in (
        (("--user", "pc-1", "--password-file", str(secret), "--ca", str(guarded.folder / "ca.crt")), "Not authorized"),
        ((), "the connection to the broker is lost"),  # it speaks no TLS
    ):
        agent = guarded.agent("--virtual", "mill=plotter_2014", *words, stderr=subprocess.PIPE)
        line = agent.stderr.readline()
        assert why in line and line.startswith("mill: "), line
        agent.terminate()
        assert agent.wait(LIMIT_S) == 0
        agent.stderr.close()


def test_made_again_it_keeps_authority_and_users(guarded):
    before = {name: (guarded.folder / name).read_bytes() for name in ("ca.crt", "acl", "broker.crt", "passwords")}
    acl = guarded.folder / "acl"
    acl.write_text(acl.read_text() + "\nuser pc-2\ntopic write passo/laser/#\n")
    guarded.configure(guarded.folder.parent)
    after = {name: (guarded.folder / name).read_bytes() for name in before}
    assert after["ca.crt"] == before["ca.crt"] and after["acl"].startswith(before["acl"])
    assert after["broker.crt"] != before["broker.crt"] and after["passwords"] != before["passwords"]
    assert list(guarded.passwords) == ["pc-1", "wall", "stop", "shop", "pc-2"]
    for name in ("ca.key", "broker.key", "passwords", "acl"):
        assert (guarded.folder / name).stat().st_mode & 0o077 == 0, name


@pytest.mark.slow
def test_with_these_rights_a_job_is_drawn(guarded, tmp_path):
    """The users shop and pc-1 of the ACL, over TLS: the file, the order and what the machine tells pass."""
    key = page_key.make_key(os.urandom)
    key_file = tmp_path / "shop.key"
    key_file.touch(0o600)
    key_file.write_text(key)
    board_file = shop_load.board_file(tmp_path)
    (tmp_path / "mill").mkdir()
    board = subprocess.Popen([*interpreter.python(), shop_load.__file__, "--board", str(tmp_path / "mill"), "fast"], stdout=subprocess.PIPE, text=True)
    guarded.programs.append(board)
    assert board.stdout.readline() == "ready\n"
    book = JobTable(tmp_path / "shop.sqlite")
    book.add_jobs(shop_load.program(77), "77.gcode", {"kind": shop_load.KIND})
    dispatcher = Dispatcher(Broker("127.0.0.1", guarded.port, "shop", guarded.passwords["shop"], str(guarded.folder / "ca.crt")), key, book)
    try:
        agent = guarded.agent_as(
            "pc-1", "--port", f"mill={tmp_path}/mill/port", "--protocol", "grbl", "--board", str(board_file), "--shop-key", str(key_file), "--at-machine", "0",
            "--page-key", str(tmp_path / "page.key"),
        )  # fmt: skip
        page = next(line[6:].strip().rstrip("/") for line in agent.stdout if line.startswith("page: "))
        person = MachinePage(page, (tmp_path / "page.key").read_text().strip())
        guarded.until(lambda: person.do("mill", "release").json()["text"] == "" or dispatcher.machines.get("mill", {}).get("how") not in ("rest", None))
        guarded.until(lambda: book.count_states().get("done") == 1)
        guarded.until(lambda: guarded.told.get("passo/mill/language") == "grbl")
    finally:
        dispatcher.close()
        book.close()
    board.terminate()
    board.wait(60)
    assert shop_load.read_numbers(shop_load.strokes(sorted((tmp_path / "mill").glob("trace-*.csv")))) == ([77], 0, [])

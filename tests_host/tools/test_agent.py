"""`passo agent`: what it tells of a machine, and to a real broker."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from host_tools.cli import agent as command
from host_tools.clients.grbl import GrblClient
from host_tools.failure import Failure
from host_tools.shop.telling import GONE, LOST, TOPICS, Telling

MOSQUITTO = shutil.which("mosquitto", path=os.environ.get("PATH", "") + ":/usr/sbin")
needs_broker = pytest.mark.skipif(not MOSQUITTO, reason="there is no Mosquitto: apt-get install mosquitto")
LIMIT_S = 60


def shown(**more):
    return {"link": True, "state": "Idle", "alarm": 0, "job": None, "w": [1.0, 2.0], "m": [1.0, 2.0], **more}


def job(how, done):
    return {"name": "part.nc", "how": how, "done": done, "lines": 200}


# --- what is told


def test_all_topics_of_a_machine_at_rest():
    told = Telling().look(shown(), 0)
    assert tuple(told) == TOPICS
    assert told["state"] == "idle" and told["place"] == "[1.0, 2.0]"
    assert told["job"] == told["progress"] == told["left"] == told["alarm"] == ""


def test_a_job_from_its_beginning_to_its_end():
    telling = Telling()
    telling.look(shown(), 0)
    told = telling.look(shown(state="Run", job=job("run", 1)), 10)
    assert (told["job"], told["progress"], told["left"]) == ("part.nc", "0", "")
    told = telling.look(shown(state="Run", job=job("run", 50), m=[1.0, 1002.0]), 40)
    assert (told["progress"], told["left"]) == ("25", "90")
    told = telling.look(shown(job=job("done", 200)), 130)
    assert told["job"] == told["progress"] == told["left"] == ""
    assert json.loads(told["counters"]) == {"jobs": 1, "failed": 0, "alarms": 0, "run_s": 40, "metres": 2.0}
    events = [event for event in telling.events(5) if event["what"] != "state"]
    assert events == [
        {"at": 5, "what": "begun", "job": "part.nc"},
        {"at": 5, "what": "done", "job": "part.nc", "seconds": 120},
    ]
    assert telling.events(6) == []


@pytest.mark.parametrize("end", [{"job": job("failed", 70)}, {"state": "Alarm", "alarm": 202}])
def test_a_job_that_fails(end):
    telling = Telling()
    telling.look(shown(state="Run", job=job("run", 50)), 0)
    counters = json.loads(telling.look(shown(**end), 1)["counters"])
    assert (counters["jobs"], counters["failed"]) == (0, 1)
    assert [event["what"] for event in telling.events(0)][-2:] in (["failed", "state"], ["begun", "failed"], ["alarm", "state"], ["failed", "alarm"])


def test_a_stored_job():
    told = Telling().look(shown(state="Run", stored="40,PART.NC"), 0)
    assert (told["job"], told["progress"]) == ("PART.NC", "40")


def test_an_alarm_in_words_once():
    telling = Telling()
    for _again in range(3):
        told = telling.look(shown(state="Alarm", alarm=202), 0)
    assert told["alarm"] and json.loads(told["counters"])["alarms"] == 1
    assert [event["number"] for event in telling.events(0) if event["what"] == "alarm"] == [202]
    assert telling.look(shown(state="Alarm"), 0)["alarm"], "an alarm from before has no number"


def test_a_board_that_does_not_answer():
    telling = Telling()
    telling.look(shown(state="Run", m=[0.0, 0.0]), 0)
    assert telling.look(shown(state="Run", link=False), 1)["state"] == LOST
    assert telling.look(shown(m=[900.0, 0.0]), 9)["state"] == "idle"
    assert [event["state"] for event in telling.events(0)] == ["run", LOST, "idle"]


# --- the options


def test_names():
    named = command._named(["/dev/ttyACM0", "mill=/dev/ttyUSB0", "socket://host:5000"], ["laser=laser_xy", "plotter_2014"])
    assert named == {
        "ttyACM0": ("/dev/ttyACM0", False), "mill": ("/dev/ttyUSB0", False), "host-5000": ("socket://host:5000", False),
        "laser": ("laser_xy", True), "plotter_2014": ("plotter_2014", True),
    }  # fmt: skip
    for ports, virtual, what in (([], [], "which board"), (["a=x", "a=y"], [], "two machines"), (["a+b=x"], [], "no machine's name"), (["#=x"], [], "name")):
        with pytest.raises(Failure, match=what):
            command._named(ports, virtual)


def test_the_broker_and_its_password(tmp_path):
    secret = tmp_path / "password"
    secret.write_text("hush\n")
    secret.chmod(0o600)
    assert command._broker("shop.local:1884", "pc", secret, None) == ("shop.local", 1884, "pc", "hush", None)
    assert command._broker("fd00::1", "", None, None).host == "fd00::1"
    for text in ("", ":1883", "host:0", "host:99999", "host:x"):
        with pytest.raises(Failure, match="HOST"):
            command._broker(text, "", None, None)
    with pytest.raises(Failure, match="belong together"):
        command._broker("host", "pc", None, None)
    secret.chmod(0o644)
    with pytest.raises(Failure, match="others can read"):
        command._broker("host", "pc", secret, None)


# --- a real broker


class Shop:
    """Mosquitto, and what it has been told: `told`, the newest of each topic; `heard`, all of it."""

    def __init__(self, folder):
        import socket

        import paho.mqtt.client as mqtt

        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.file = folder / "mosquitto.conf"
        self.file.write_text(f"listener {self.port} 127.0.0.1\nallow_anonymous true\n")
        self.told, self.heard, self.programs = {}, [], []
        self.start()
        self.client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5)
        self.client.on_message = self._hear
        self.client.on_connect = lambda *_: self.client.subscribe("passo/#", 1)
        self.client.reconnect_delay_set(1, 1)
        self.client.connect("127.0.0.1", self.port)
        self.client.loop_start()

    def _hear(self, client, userdata, message):
        self.told[message.topic] = message.payload.decode()
        self.heard.append((message.topic, message.payload.decode(), message.retain))

    def start(self):
        self.broker = subprocess.Popen([MOSQUITTO, "-c", self.file], stderr=subprocess.DEVNULL)
        self.until(self.answers)

    def answers(self):
        import socket

        try:
            socket.create_connection(("127.0.0.1", self.port), 1).close()
            return True
        except OSError:
            return False

    def until(self, condition):
        limit = time.monotonic() + LIMIT_S
        while not condition():
            assert time.monotonic() < limit, self.heard
            time.sleep(0.02)

    def run(self, *words):
        """A program of Passo's; returns it behind its first line."""
        program = subprocess.Popen([sys.executable, "-m", "host_tools.cli", *words], stdout=subprocess.PIPE, text=True)
        self.programs.append(program)
        return program

    def agent(self, *words):
        return self.run("agent", *words, "--broker", f"127.0.0.1:{self.port}")

    def close(self):
        self.client.loop_stop()
        for program in self.programs:
            program.kill()
            program.wait()
            program.stdout.close()
        self.broker.kill()
        self.broker.wait()


@pytest.fixture
def shop(tmp_path):
    opened = Shop(tmp_path)
    yield opened
    opened.close()


@needs_broker
def test_two_boards_a_killed_agent_and_a_broker_that_begins_anew(shop):
    agent = shop.agent("--emulated", "a=router_3axis", "--emulated", "b=plotter_2014")
    shop.until(lambda: shop.told.get("passo/a/state") == "alarm" and shop.told.get("passo/b/state") == "idle")
    assert shop.told["passo/a/alarm"] and json.loads(shop.told["passo/b/place"]) == [0, 0]
    assert LOST not in [text for _topic, text, _kept in shop.heard]
    # The broker forgets all: it is told again.
    shop.broker.kill()
    shop.broker.wait()
    shop.told.clear()
    shop.start()
    shop.until(lambda: shop.told.get("passo/a/state") == "alarm" and shop.told.get("passo/b/state") == "idle")
    agent.send_signal(signal.SIGKILL)
    shop.until(lambda: shop.told["passo/a/state"] == shop.told["passo/b/state"] == GONE)
    # A second one takes its place.
    agent = shop.agent("--emulated", "b=plotter_2014")
    shop.until(lambda: shop.told["passo/b/state"] == "idle")
    agent.send_signal(signal.SIGTERM)
    assert agent.wait(10) == 0
    shop.until(lambda: shop.told["passo/b/state"] == GONE)


@needs_broker
def test_a_machine_at_work_for_somebody_else(shop, tmp_path):
    """The board has a second link, whose sender moves it; an agent on the first one tells, and is not in the way."""
    board = shop.run("board", "--board", "router_3axis", "--link", f"pc={tmp_path}/one", "--link", f"serial={tmp_path}/two")
    for _line in range(2):
        board.stdout.readline()
    shop.agent("--port", f"a={tmp_path}/one", "--protocol", "grbl")
    shop.until(lambda: shop.told.get("passo/a/state") == "alarm")
    with GrblClient(f"{tmp_path}/two") as client:
        client.command("$LINK=0")
        client.command("$X")
        client.command("G21G91G1X20F600")
        shop.until(lambda: shop.told["passo/a/state"] == "run")
        client.wait_idle()
    shop.until(lambda: shop.told["passo/a/state"] == "idle" and json.loads(shop.told["passo/a/place"])[0] == 20)
    counters = json.loads(shop.told["passo/a/counters"])
    assert counters["run_s"] > 1 and counters["metres"] == pytest.approx(0.02)

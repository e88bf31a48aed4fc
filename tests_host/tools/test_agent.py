"""`passo agent`: the topics it publishes about a machine, and its work with a real broker."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
import requests

from host_tools import boards, interpreter
from host_tools.cli import agent as command
from host_tools.clients.grbl import GrblClient
from host_tools.failure import Failure
from host_tools.shop.home_assistant import discovery_messages
from host_tools.shop.signed import SHOP, sign_message
from host_tools.shop.state_topics import GONE, LOST, TOPICS, StateTopics

MOSQUITTO = shutil.which("mosquitto", path=os.environ.get("PATH", "") + ":/usr/sbin")
needs_broker = pytest.mark.skipif(not MOSQUITTO, reason="there is no Mosquitto: apt-get install mosquitto")
LIMIT_S = 60


def shown(**more):
    return {"link": True, "state": "Idle", "alarm": 0, "job": None, "w": [1.0, 2.0], "m": [1.0, 2.0], **more}


def job(how, done):
    return {"name": "part.nc", "how": how, "done": done, "lines": 200}


# --- the machine


class Silent:
    """A board that says what grbl does, and nothing behind `$JR`, until its power goes; and the port that it is on."""

    def __init__(self, changed):
        self._changed = changed
        self.said, self.lines, self.dead, self.pins = b"", [], False, b""
        self.state, self.late, self.at = b"Idle", 0, 0

    def write(self, data):
        for line in data.replace(b"?", b"?\n").split():
            self.dead = self.dead or line == b"$JR"
            if self.dead:
                continue
            self.lines.append(line)
            if line == b"?":
                self.said += b"<%s|MPos:%d.000,0.000|FS:0,0|WCO:0.000,0.000%s>\r\n" % (self.state, self.at, self.pins)
            elif line == b"G99":
                self.said += b"error:20\r\n"
            else:
                logged = b"[LOG:5,109,]\r\n[LOGGED:2x9,%dx109,7x1109]\r\n" % self.late if self.late else b"[LOGGED:2x9]\r\n"
                self.said += {b"$LOG": logged, b"$I": b"[OPT:J,15,128]\r\n", b"$$": b"$100=80\r\n$101=80\r\n$130=100\r\n$131=100\r\n"}.get(line, b"") + b"ok\r\n"

    def read(self):
        said, self.said = self.said, b""
        return said

    def restart(self):
        """Cut the power and restore it: questions asked before stay unanswered."""
        self._changed(0, False)
        self.dead, self.said = False, b""
        self._changed(0, True)

    def look(self):
        pass


class NoBroker:
    parcel = None
    connections = 3

    def take_orders(self):
        return []

    def add_event(self, event):
        pass

    publish_topics = add_event


class Late(Silent):
    """A board that answers lines of somebody who spoke before, and then those of today, a line each time it is read."""

    stale = {}  # line: how many others are answered before it
    journal = b"[JOURNAL:00000007|12|3|0,0]\r\nok\r\n"

    def write(self, data):
        for line in data.replace(b"?", b"?\n").split():
            before = self.said
            if line == b"$JR":
                self.lines.append(line)
                self.said += self.journal
            else:
                Silent.write(self, line)
            self.said = before + b"ok\r\n" * self.stale.pop(line, 0) + self.said[len(before) :]

    def read(self):
        said, _end, self.said = self.said.partition(b"\n")
        return said + _end


class NoLog(Late):
    def write(self, data):
        Late.write(self, data.replace(b"$LOG\n", b"G99\n"))


def agent_of(kind):
    """Return (a board of an agent without a broker, its port, a function that runs the board until a condition holds)."""
    from host_tools import boards
    from host_tools.shop.agent import _Board

    ports = []

    def make_port(changed):
        ports.append(kind(changed))
        return ports[0]

    board = _Board("m", "grbl", boards.load("corexy_plotter"), make_port, NoBroker(), lambda board, fd, opened: board.note_port(opened), "KEY", {})

    def run(until):
        limit = time.monotonic() + 20
        while not until():
            assert time.monotonic() < limit, (board._machine.options, board._machine.settings, ports[0].lines[-20:])
            board.read()
            board.poll(time.monotonic())
            time.sleep(0.001)

    return board, ports[0], run


def test_a_question_that_a_power_cut_leaves_unanswered_is_asked_again():
    board, port, run = agent_of(Silent)
    run(lambda: port.dead)
    assert board.work._job.busy()
    asked = port.lines.count(b"?")
    port.restart()
    run(lambda: port.lines.count(b"?") > asked + 1 and port.dead)  # it was asked again, by a link without old lines
    assert board._machine.wire.count_lines(0) == 1


@pytest.mark.parametrize("line", [b"$I", b"$$", b"$JR"])
@pytest.mark.parametrize("stale", [0, 1, 2, 3, 40])
def test_answers_to_an_agent_that_was_killed_are_no_answers_to_the_next_one(line, stale):
    """The board's letters, settings and journal are known all the same."""
    board, port, run = agent_of(Late)
    port.stale = {line: stale}
    run(lambda: board.work._job.record and board._machine.options is not None)
    assert board._machine.options == "J" and board._machine.settings[130] == "100" and board.work._job.record.job == 7
    assert board.work._release_machine() == ""


def test_the_journal_is_asked_behind_a_homing_that_no_report_has_shown():
    board, port, run = agent_of(Late)
    run(lambda: board.work._job.record)
    board.work._make_ready(board._machine.home)
    assert board.work._job.record is None
    run(lambda: board.work._job.record)
    assert b"$JR" in port.lines[port.lines.index(b"$H") :]


def test_the_button_releases_once_and_only_if_it_was_seen_open():
    board, port, run = agent_of(Late)

    def report():
        asked = port.lines.count(b"?")
        run(lambda: port.lines.count(b"?") > asked + 1 and not port.said)

    port.pins = b"|Pn:S"  # stuck
    run(lambda: board.work._job.record)
    report()
    assert board.work.how == "rest"
    port.restart()  # the link begins anew
    run(lambda: board.work._job.record)
    report()
    assert board.work.how == "rest"
    port.pins = b""
    report()
    port.pins = b"|Pn:S"
    run(lambda: board.work.how == "free")
    assert board.work.act("withdraw") == ""
    report()
    assert board.work.how == "rest", "it is still held"
    port.pins = b"|Pn:XY"  # other inputs
    report()
    assert board.work.how == "rest"
    port.pins = b"|Pn:XS"
    run(lambda: board.work.how == "free")
    # A job waits, and the button sticks while the board has no power.
    board.work._order = {"id": "1", "name": "a"}
    board.work._change_state("waits")
    port.pins = b""
    report()
    port.restart()
    port.pins = b"|Pn:S"
    run(lambda: board._machine.state["pins"] == "S" and board._machine.state["link"])
    report()
    assert board.work.how == "waits"


def test_steps_and_late_words_and_what_was_refused_are_counted():
    board, port, run = agent_of(Late)
    port.late = 5
    counters = board.state_topics.counters
    run(lambda: b"$LOG" in port.lines and board.state_topics._late == 5)
    assert counters["late"] == 0, "those were before the agent"
    for state, at, late in ((b"Run", 10, 5), (b"Run", 40, 8), (b"Idle", 40, 8)):
        port.state, port.at, port.late = state, at, late
        run(lambda at=at, state=state: board._machine.state["m"] == [at, 0] and board.state_topics.told["state"] == state.decode().lower())
    run(lambda: counters["late"] == 3)
    assert counters["steps"] == 40 * 80 and counters["refused"] == 0
    asked = port.lines.count(b"$LOG")
    port.dead, port.late = True, 1
    run(lambda: board.state_topics.told["state"] == "lost")
    port.restart()
    run(lambda: port.lines.count(b"$LOG") > asked and counters["late"] == 4)
    board._machine.send_line(b"G99")
    run(lambda: counters["refused"] == 1)
    assert counters["connections"] == 2
    assert port.lines.count(b"$LOG") == 3, "once behind each motion, and each start"


def test_a_grbl_without_a_log_is_asked_once():
    board, port, run = agent_of(NoLog)
    run(lambda: b"G99" in port.lines)
    for state in (b"Run", b"Idle"):
        port.state = state
        run(lambda state=state: board.state_topics.told["state"] == state.decode().lower())
    told = len(port.lines)
    run(lambda: len(port.lines) > told + 5)
    assert port.lines.count(b"G99") == 1 and board.state_topics.counters["late"] == 0


def test_late_words_and_lost_packets_of_a_plotter():
    from host_tools import boards
    from host_tools.panel import languages
    from passo import commands, errors
    from passo.commands import Command

    machine = languages.create("plotter", boards.load("plotter_2014"), lambda data: None, lambda event: None).machine
    report = {"state": "idle", "position": [0, 0], "x": 0, "y": 0, "drawn": 0, "free": 9, "error": 0}
    machine.wire._take_status({**report, "error": errors.WORDS_LATE})
    machine.wire._take_status(dict(report))
    assert machine.late == 1
    machine.queue_command(Command(commands.POINT, (5, 5), tool=1))
    for _status in range(3):
        machine.wire._take_status(dict(report))
    assert machine.wire.retries == 1


def test_a_stop_waits_for_no_other_board_of_the_agent():
    """The agent is busy for a long time with the file of one board."""
    from host_tools.shop.agent import Agent

    agent, links, ports = Agent(), [], []

    def make_port(changed):
        ports.append(Silent(changed))
        return ports[-1]

    for name in "ab":
        links.append(NoBroker())
        agent.add_board(name, "grbl", boards.load("corexy_plotter"), make_port, links[-1])
    agent._watch_port = lambda board, fd, opened: board.note_port(opened)
    busy, over = threading.Event(), threading.Event()

    def long_work(now_s):
        busy.set()
        assert over.wait(LIMIT_S)

    agent._boards[0].poll = long_work
    thread = threading.Thread(target=agent.run, args=(over.is_set,))
    thread.start()
    try:
        assert busy.wait(LIMIT_S)
        links[1].stopped()
        assert b"\x18" in ports[1].lines and b"\x18" not in ports[0].lines
        assert agent._boards[1].state_topics.counters["stops"] == 1
    finally:
        over.set()
        thread.join()


class Counted(list):
    """Lines of a job, and how often one has been looked at."""

    looks = 0

    def __reversed__(self):
        for row in super().__reversed__():
            self.looks += 1
            yield row

    def __iter__(self):
        for row in super().__iter__():
            self.looks += 1
            yield row


def test_a_machine_that_waits_does_not_read_its_job_again_and_again():
    board, port, run = agent_of(Late)
    run(lambda: board.work._job.record)
    lines = Counted((number, b"G1X%d" % number) for number in range(1, 10_001))
    lines.append((10_001, b"M5"))
    record = board.work._job.record
    board.work._order = {"id": "7", "name": "a"}
    board.work._job.files.keep_program("a", lines, 7)
    board.work._job.record = record
    board.work._change_state("waits")
    for _poll in range(50):
        board.work.poll(time.monotonic())
    assert board.work._last_line() == 10_000 and 0 < lines.looks < 200


def test_a_report_with_a_wrong_byte_is_left_out():
    from host_tools.page.grbl_machine import GrblMachine

    machine = GrblMachine(lambda data: None, lambda event: None)
    good = b"<Run|MPos:1.000,2.000,0.000|FS:600,0|WCO:0.000,0.000,0.000|Ov:100,100,100>"
    for at in range(1, len(good) - 1):
        for byte in b"x<|:,.-":
            machine.feed(good[:at] + bytes((byte,)) + good[at + 1 :] + b"\r\n", 0)
    machine.feed(good[:40] + good + b"\r\nALARM:\r\nALARM:x\r\n" + good + b"\r\n", 0)
    assert machine.state["m"] == [1.0, 2.0, 0.0] and machine.state["state"] == "Run"


# --- the topics


def test_all_topics_of_a_machine_at_rest():
    told = StateTopics().look(shown(), 0)
    assert tuple(told) == TOPICS
    assert told["state"] == "idle" and told["place"] == "[1.0, 2.0]"
    assert told["job"] == told["progress"] == told["left"] == told["alarm"] == ""


def test_a_job_from_its_beginning_to_its_end():
    state_topics = StateTopics()
    state_topics.look(shown(), 0)
    told = state_topics.look(shown(state="Run", job=job("run", 1)), 10)
    assert (told["job"], told["progress"], told["left"]) == ("part.nc", "0", "")
    told = state_topics.look(shown(state="Run", job=job("run", 50), m=[1.0, 1002.0]), 40)
    assert (told["progress"], told["left"]) == ("25", "90")
    told = state_topics.look(shown(job=job("done", 200)), 130)
    assert told["job"] == told["progress"] == told["left"] == ""
    assert json.loads(told["counters"]) == {"jobs": 1, "failed": 0, "alarms": 0, "refused": 0, "stops": 0, "run_s": 40, "metres": 2.0, "steps": 0, "late": 0, "retries": 0, "connections": 0}
    events = [event for event in state_topics.events(5) if event["what"] != "state"]
    assert events == [
        {"at": 5, "what": "begun", "job": "part.nc"},
        {"at": 5, "what": "done", "job": "part.nc", "seconds": 120},
    ]
    assert state_topics.events(6) == []


@pytest.mark.parametrize("end", [{"job": job("failed", 70)}, {"state": "Alarm", "alarm": 202}])
def test_a_job_that_fails(end):
    state_topics = StateTopics()
    state_topics.look(shown(state="Run", job=job("run", 50)), 0)
    counters = json.loads(state_topics.look(shown(**end), 1)["counters"])
    assert (counters["jobs"], counters["failed"]) == (0, 1)
    assert [event["what"] for event in state_topics.events(0)][-2:] in (["failed", "state"], ["begun", "failed"], ["alarm", "state"], ["failed", "alarm"])


def test_a_stored_job():
    told = StateTopics().look(shown(state="Run", stored="40,PART.NC"), 0)
    assert (told["job"], told["progress"]) == ("PART.NC", "40")


def test_an_alarm_in_words_once():
    state_topics = StateTopics()
    for _again in range(3):
        told = state_topics.look(shown(state="Alarm", alarm=202), 0)
    assert told["alarm"] and json.loads(told["counters"])["alarms"] == 1
    assert [event["number"] for event in state_topics.events(0) if event["what"] == "alarm"] == [202]
    assert state_topics.look(shown(state="Alarm"), 0)["alarm"], "an alarm from before has no number"


def test_what_changes_with_each_report_is_told_once_a_second_in_motion_and_at_once_at_rest():
    for state in ("Run", "Jog", "Home"):
        state_topics = StateTopics()
        places = [state_topics.look(shown(state=state, w=[at / 10]), at / 5)["place"] for at in range(20)]
        assert len(set(places)) == 4, state
    assert [json.loads(state_topics.look(shown(w=[at]), 10 + at / 5)["place"]) for at in range(5)] == [[at] for at in range(5)]


def test_a_board_that_does_not_answer():
    state_topics = StateTopics()
    state_topics.look(shown(state="Run", m=[0.0, 0.0]), 0)
    assert state_topics.look(shown(state="Run", link=False), 1)["state"] == LOST
    assert state_topics.look(shown(m=[900.0, 0.0]), 9)["state"] == "idle"
    assert [event["state"] for event in state_topics.events(0)] == ["run", LOST, "idle"]


# --- the options


def test_names():
    named = command._parse_boards(["/dev/ttyACM0", "mill=/dev/ttyUSB0", "socket://host:5000"], ["laser=laser_xy", "plotter_2014"])
    assert named == {
        "ttyACM0": ("/dev/ttyACM0", False), "mill": ("/dev/ttyUSB0", False), "host-5000": ("socket://host:5000", False),
        "laser": ("laser_xy", True), "plotter_2014": ("plotter_2014", True),
    }  # fmt: skip
    for ports, virtual, what in (([], [], "which board"), (["a=x", "a=y"], [], "two machines"), (["a+b=x"], [], "no machine's name"), (["#=x"], [], "name")):
        with pytest.raises(Failure, match=what):
            command._parse_boards(ports, virtual)


def test_the_old_name_of_virtual_boards_still_works_and_says_the_new_one(capsys):
    """Both lists name machines: here the same one."""
    with pytest.raises(Failure, match="two machines are called a"):
        command.agent("localhost", virtual=["a=plotter_2014"], emulated=["a=router_3axis"])
    assert "--emulated is now called --virtual" in capsys.readouterr().err
    with pytest.raises(Failure, match="two machines are called a"):
        command.agent("localhost", virtual=["a=plotter_2014", "a=router_3axis"])
    assert capsys.readouterr().err == ""


def test_what_is_said_of_machines():
    boards = {"a": ("x", False)}
    assert command._parse_machine_texts("--laser-class", ["a=3B"], boards) == {"a": "3B"}
    for option, text, what in (("--laser-class", "a=5", "one of 1, 1C"), ("--laser-class", "b=1", "of a machine"), ("--page", "a=x", "address"), ("--tool", "a=", "of a machine")):
        with pytest.raises(Failure, match=what):
            command._parse_machine_texts(option, [text], boards)


def test_the_broker_and_its_password(tmp_path):
    secret = tmp_path / "password"
    secret.write_text("hush\n")
    secret.chmod(0o600)
    assert command.make_broker("shop.local:1884", "pc", secret, None) == ("shop.local", 1884, "pc", "hush", None)
    assert command.make_broker("fd00::1", "", None, None).host == "fd00::1"
    for text in ("", ":1883", "host:0", "host:99999", "host:x"):
        with pytest.raises(Failure, match="HOST"):
            command.make_broker(text, "", None, None)
    with pytest.raises(Failure, match="belong together"):
        command.make_broker("host", "pc", None, None)
    secret.chmod(0o644)
    with pytest.raises(Failure, match="others can read"):
        command.make_broker("host", "pc", secret, None)


# --- a real broker


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Shop:
    """Mosquitto and the messages a client received from it: `told`, the newest of each topic; `heard`, all in their order."""

    def __init__(self, folder):
        self.port = free_port()
        self.configure(folder)
        self.told, self.heard, self.programs = {}, [], []
        self.start()
        self.client = self.make_client()
        self.client.on_message = self._hear
        self.client.on_connect = lambda *_: self.client.subscribe("passo/#", 1)
        self.client.reconnect_delay_set(1, 1)
        self.client.connect("127.0.0.1", self.port)
        self.client.loop_start()

    def configure(self, folder):
        self.file = folder / "mosquitto.conf"
        self.file.write_text(f"listener {self.port} 127.0.0.1\nallow_anonymous true\n")

    def make_client(self):
        import paho.mqtt.client as mqtt

        return mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5)

    def _hear(self, client, userdata, message):
        self.told[message.topic] = message.payload.decode()
        self.heard.append((message.topic, message.payload.decode(), message.retain))

    def start(self):
        self.broker = subprocess.Popen([MOSQUITTO, "-c", self.file], stderr=subprocess.DEVNULL)
        self.until(self.answers)

    def answers(self):
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

    def run(self, *words, stderr=None):
        """Start a program of Passo's."""
        program = subprocess.Popen([*interpreter.passo(), *words], stdout=subprocess.PIPE, stderr=stderr, text=True)
        self.programs.append(program)
        return program

    def agent(self, *words, stderr=None):
        return self.run("agent", *words, "--broker", f"127.0.0.1:{self.port}", stderr=stderr)

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
    agent = shop.agent("--virtual", "a=router_3axis", "--virtual", "b=plotter_2014")
    shop.until(lambda: shop.told.get("passo/a/state") == "alarm" and shop.told.get("passo/b/state") == "idle" and "passo/a/alarm" in shop.told and "passo/b/place" in shop.told)
    assert shop.told["passo/a/alarm"] and json.loads(shop.told["passo/b/place"]) == [0, 0]
    assert LOST not in [text for _topic, text, _kept in shop.heard]
    # The broker forgets all topics: the agent publishes them again.
    shop.broker.kill()
    shop.broker.wait()
    shop.told.clear()
    shop.start()
    shop.until(lambda: shop.told.get("passo/a/state") == "alarm" and shop.told.get("passo/b/state") == "idle")
    agent.send_signal(signal.SIGKILL)
    shop.until(lambda: shop.told["passo/a/state"] == shop.told["passo/b/state"] == GONE)
    # A second one takes its place.
    agent = shop.agent("--virtual", "b=plotter_2014")
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


@needs_broker
def test_a_stop_for_all_and_one_that_was_kept(shop, tmp_path):
    """A message that the broker kept from yesterday stops nothing; one that comes does, on a link that does not command, too."""
    shop.client.publish("passo/stop", "yesterday", 1, retain=True).wait_for_publish(LIMIT_S)
    board = shop.run("board", "--board", "router_3axis", "--link", f"pc={tmp_path}/one", "--link", f"serial={tmp_path}/two")
    for _line in range(2):
        board.stdout.readline()
    shop.agent("--port", f"a={tmp_path}/one", "--protocol", "grbl", "--virtual", "b=plotter_2014")
    shop.until(lambda: shop.told.get("passo/a/state") == "alarm" and shop.told.get("passo/b/state") == "idle")
    with GrblClient(f"{tmp_path}/two") as client:
        client.command("$LINK=0")
        client.command("$X")
        client.command("G21G91G1X200F300")
        shop.until(lambda: shop.told["passo/a/state"] == "run")
        shop.client.publish("passo/b/stop", "only b", 1)
        shop.until(lambda: [text for topic, text, _kept in shop.heard if topic == "passo/b/log" and '"stop"' in text])
        assert client.ask_status()["state"] == "Run"
        begun = time.monotonic()
        shop.client.publish("passo/stop", "all", 1)
        while client.alarm is None:
            client.read_lines()
            assert time.monotonic() - begun < LIMIT_S
        print(f"from the message to the alarm on another link: {1000 * (time.monotonic() - begun):.0f} ms")
        assert client.alarm == 3
    shop.until(lambda: shop.told["passo/a/state"] == "alarm")
    shop.until(lambda: json.loads(shop.told["passo/a/counters"])["stops"])  # the agent publishes counters apart from the state
    assert json.loads(shop.told["passo/a/counters"])["stops"] == 1


# --- figures


PROMETHEUS = shutil.which("prometheus")
DASHBOARD = json.loads((Path(__file__).parents[2] / "docs" / "use" / "grafana-passo.json").read_text())


def scraped():
    """Return Prometheus' text of a StateTopics with a history."""
    from prometheus_client import CollectorRegistry
    from prometheus_client.openmetrics.exposition import generate_latest

    from host_tools.shop.figures import Figures

    state_topics = StateTopics()
    state_topics.scale = [80, 80]
    for count in (7, 9):
        state_topics.note_late(count)
    state_topics.counters["retries"] = 4
    state_topics.look(shown(state="Run", job=job("run", 100), full=30), 0)
    state_topics.look(shown(state="Run", job=job("run", 150), full=30, m=[1.0, 1002.0]), 60)
    state_topics.count_refusal(2)
    figures = Figures()
    figures.watch_machine("a", state_topics)
    figures.watch_machine("not yet heard of", StateTopics())
    registry = CollectorRegistry()
    registry.register(figures)
    return generate_latest(registry).decode()


def test_figures_in_openmetrics():
    from prometheus_client.openmetrics.parser import text_string_to_metric_families

    found = {
        (sample.name, *sorted(sample.labels.values())): sample.value
        for family in text_string_to_metric_families(scraped())
        for sample in family.samples
    }
    assert found["passo_up", "a"] == found["passo_state", "a", "run"] == 1
    assert found["passo_job_progress_ratio", "a"] == 0.75 and found["passo_job_left_seconds", "a"] == 20
    assert found["passo_queue_ratio", "a"] == 0.3
    assert found["passo_motion_seconds_total", "a"] == 60 and found["passo_way_metres_total", "a"] == 1
    assert found["passo_late_words_total", "a"] == 2 and found["passo_steps_total", "a"] == 80_000
    assert found["passo_retries_total", "a", "board"] == 4 and found["passo_retries_total", "a", "broker"] == 0
    assert found["passo_refused_total", "a"] == 1 and found["passo_jobs_total", "a", "failed"] == 0
    assert not [key for key in found if "not yet heard of" in key]


def test_the_dashboard_asks_for_figures_that_there_are():
    names = set(re.findall(r"passo_\w+", scraped()))
    for each in DASHBOARD["panels"]:
        wanted = set(re.findall(r"passo_\w+", each["targets"][0]["expr"]))
        assert wanted and wanted <= names, each["title"]


@pytest.mark.skipif(not PROMETHEUS, reason="there is no Prometheus: apt-get install prometheus")
@needs_broker
def test_prometheus_scrapes_and_the_dashboard_s_queries_answer(shop, tmp_path):
    figures, served = free_port(), free_port()
    shop.agent("--virtual", "a=plotter_2014", "--figures", str(figures))
    shop.until(lambda: shop.told.get("passo/a/state") == "idle")
    (tmp_path / "prometheus.yml").write_text(
        f"scrape_configs: [{{job_name: passo, scrape_interval: 200ms, scrape_timeout: 200ms, static_configs: [{{targets: ['127.0.0.1:{figures}']}}]}}]\n"
    )
    program = subprocess.Popen(
        [PROMETHEUS, f"--config.file={tmp_path}/prometheus.yml", f"--storage.tsdb.path={tmp_path}/data", f"--web.listen-address=127.0.0.1:{served}"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    shop.programs.append(program)

    def answer(query):
        try:
            found = requests.get(f"http://127.0.0.1:{served}/api/v1/query", {"query": query}, timeout=10).json()
        except (requests.ConnectionError, ValueError):
            return []
        assert found["status"] == "success", (query, found)
        return found["data"]["result"]

    shop.until(lambda: [each for each in answer("passo_up") if each["value"][1] == "1"])
    for each in DASHBOARD["panels"]:
        shop.until(lambda each=each: answer(each["targets"][0]["expr"]))


# --- Home Assistant


# The keys of a sensor and of a button that Home Assistant 2026.11 takes (components/mqtt/schemas.py, sensor.py, button.py), of those that matter here.
_COMMON = {"availability_topic", "availability_template", "device", "origin", "icon", "default_entity_id", "unique_id", "name", "qos", "device_class"}
TAKEN = {"sensor": _COMMON | {"state_topic", "value_template", "state_class", "unit_of_measurement"}, "button": _COMMON | {"command_topic", "payload_press", "retain"}}


def test_discovery():
    found = {topic: json.loads(text) for topic, text in discovery_messages("homeassistant", "passo/", "mill.2").items()}
    assert len({config["unique_id"] for config in found.values()}) == len(found) == 6
    for topic, config in found.items():
        # <discovery_prefix>/<component>/<node_id>/<object_id>/config: letters, digits, '_' and '-'.
        assert re.fullmatch(r"homeassistant/(sensor|button)/[\w-]+/[\w-]+/config", topic)
        kind = topic.split("/")[1]
        assert set(config) <= TAKEN[kind] and config["default_entity_id"] == f"{kind}.{config['unique_id']}"
        # "" is no number: Home Assistant keeps the last one then, and "None" is none.
        assert ("unit_of_measurement" in config) == ("'None'" in config.get("value_template", ""))
        assert config["device"]["identifiers"] and config["origin"]["name"] == "Passo"
        assert config["availability_topic"] == "passo/mill.2/state" and f"'{GONE}'" in config["availability_template"]
        assert ("state_topic" in config, "command_topic" in config) == ((True, False) if kind == "sensor" else (False, True))
        if kind == "sensor":
            assert config["state_topic"].rpartition("/")[2] in TOPICS
    stop = found["homeassistant/button/passo_mill_2/stop/config"]
    assert stop["command_topic"] == "passo/mill.2/stop" and stop["retain"] is False


@needs_broker
def test_home_assistant_is_told_again_behind_each_start_of_the_broker(shop):
    shop.client.subscribe("homeassistant/#", 1)
    shop.client.on_connect = lambda *_: shop.client.subscribe([("passo/#", 1), ("homeassistant/#", 1)])
    shop.agent("--virtual", "a=plotter_2014", "--home-assistant", "homeassistant")
    shop.until(lambda: sum(topic.startswith("homeassistant/") for topic in shop.told) == 6)
    shop.broker.kill()
    shop.broker.wait()
    shop.told.clear()
    shop.start()
    shop.until(lambda: sum(topic.startswith("homeassistant/") for topic in shop.told) == 6)


@needs_broker
def test_of_two_agents_with_one_name_the_second_says_so_and_tells_nothing(shop):
    first = shop.agent("--virtual", "a=corexy_plotter")
    shop.until(lambda: shop.told.get("passo/a/state") == "alarm")
    second = shop.agent("--virtual", "a=plotter_2014", stderr=subprocess.PIPE)
    for line in second.stderr:
        if "another agent speaks for a" in line:
            break
    else:
        raise AssertionError(second.returncode)
    time.sleep(1)
    assert shop.told["passo/a/language"] == "grbl" and shop.told["passo/a/state"] == "alarm" and first.poll() is None
    second.terminate()
    assert second.wait(30) == 0
    time.sleep(0.5)
    assert shop.told["passo/a/state"] == "alarm", "the second has no last will"


@needs_broker
def test_an_agent_that_is_taken_over_says_so_takes_no_orders_and_hears_stop(shop):
    """It did not answer in time when the other one asked, as one that stood still for a moment."""
    from host_tools.shop.link import Broker, Link

    def link(name):
        made, said = Link(Broker("127.0.0.1", shop.port), "a", said_of[name].append, works=True), doubled[name]
        made.doubled, made.stopped = said.append, lambda: stops.append(name)
        return made

    said_of, doubled, stops, links = {"one": [], "two": []}, {"one": [], "two": []}, [], {}
    try:
        links["one"] = link("one")
        shop.until(lambda: links["one"].is_up)
        links["one"].publish_topics({"state": "run"})
        links["one"]._answer_agent = lambda asks: None
        links["two"] = link("two")
        shop.until(lambda: links["two"].is_up and doubled["one"])
        assert "another agent speaks for a" in said_of["one"][-1] and not doubled["two"]
        shop.until(lambda: links["one"]._client.is_connected())
        links["two"].publish_topics({"state": "idle"})
        links["one"].publish_topics({"state": "hold"})
        shop.client.publish("passo/a/order", "x", 1).wait_for_publish(LIMIT_S)
        heard = []
        shop.until(lambda: heard.extend(links["two"].take_orders()) or ("order", "x") in heard)
        time.sleep(1.5)
        assert not links["one"].take_orders() and not links["one"].is_up and links["two"].is_up and not doubled["two"], "no fight for the connection"
        assert shop.told["passo/a/state"] == "idle"
        shop.client.publish("passo/stop", "x", 1)
        shop.until(lambda: sorted(stops) == ["one", "two"])
    finally:
        for each in links.values():
            each.close()


@needs_broker
def test_a_board_that_speaks_for_itself_keeps_its_name(shop):
    """It answers no agent, but tells its state whenever it has its connection again."""
    from paho.mqtt.enums import CallbackAPIVersion

    from host_tools.shop.link import Broker, Link, mqtt

    board = mqtt.Client(CallbackAPIVersion.VERSION2, "passo-a", protocol=mqtt.MQTTv5)
    board.on_connect = lambda *_: board.publish("passo/a/state", "idle", 1, True)
    board.connect("127.0.0.1", shop.port)
    board.loop_start()
    said, link = [], None
    try:
        shop.until(lambda: shop.told.get("passo/a/state") == "idle")
        link = Link(Broker("127.0.0.1", shop.port), "a")
        link.doubled = said.append
        shop.until(lambda: said)
        stops = []
        link.stopped = lambda: stops.append(link.is_up)
        shop.until(lambda: board.is_connected() and not link.is_up and shop.told.get("passo/a/state") == "idle")
        connections = link.connections
        shop.until(lambda: link._client.is_connected())
        shop.until(lambda: stops or shop.client.publish("passo/stop", "x", 1).wait_for_publish(LIMIT_S))  # it hears STOP all the same
        shop.until(lambda: stops)
        assert board.is_connected() and not any(stops) and link.connections == connections
    finally:
        board.disconnect()
        board.loop_stop()
        if link:
            link.close()


@needs_broker
def test_an_agent_that_lost_its_connection_knows_its_own_state(shop):
    """The broker still has it, or is handed it late: it is no other agent's."""
    import socket

    from host_tools.shop.link import Broker, Link

    doubled, link = [], Link(Broker("127.0.0.1", shop.port), "a")
    link.doubled = doubled.append
    try:
        for count in (1, 2):
            shop.until(lambda: link.is_up and link.connections >= count)
            link.publish_topics({"state": f"run {count}"})
            shop.until(lambda: shop.told.get("passo/a/state") == f"run {count}")
            link._client.socket().shutdown(socket.SHUT_RDWR)
        shop.until(lambda: link.connections >= 3)
        assert doubled == []
    finally:
        link.close()


def test_what_has_not_begun_does_not_begin_at_a_machine_for_which_another_agent_speaks():
    board, port, run = agent_of(Late)
    run(lambda: board.work._job.record)
    work = board.work
    assert work.act("release") == ""
    board._yield_machine("another one")
    assert work.how == "rest" and work.act("release") == "another one" and work.page_row()["text"] == "another one"
    work.take_order(sign_message("KEY", SHOP, work._nonce, 1, {"id": "1", "name": "a", "sha": "0" * 64, "parts": 1, "again": False}))
    assert work.how == "rest"
    for how, order, then in (("free", None, "rest"), ("fetch", {"id": "1", "name": "a"}, "rest"), ("goes", {"id": "1", "name": "a"}, "waits"), ("run", {"id": "1", "name": "a"}, "run")):
        work._order, work._parcel = order, SimpleNamespace(drop=lambda: None)
        work._change_state(how)
        board._yield_machine("another one")
        assert work.how == then, how
    work._change_state("waits")
    assert work.act("go") == "another one" and work.act("give up") == ""

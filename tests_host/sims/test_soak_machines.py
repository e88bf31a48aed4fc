"""The machines of `make soak` for some seconds; rules broken on purpose, which the soak finds; and what it has found."""

from pathlib import Path

import pytest

import soak
from host_tools import boards
from host_tools.cli import pulses
from host_tools.failure import Failure
from host_tools.programs import stored_job
from host_tools.sim.machine import VirtualMachine
from passo.options.jobs import config as job_store
from passo.control.inputs import Inputs
from passo.control.state import MachineState
from passo.protocols.frames.line import FramedLine
from passo.protocols.grbl.protocol import Grbl
from passo.protocols.plotter.host import COMMANDS, PACKET, packet
from passo.protocols.plotter.protocol import Plotter as PlotterLanguage
from soak_plotter import Plotter
from virtual_wire import plugged


@pytest.mark.parametrize("name, life, rounds", [("router", 5, 6), ("feeds", 6, 6), ("plotter", 1, 5), ("mill", 1, 1), ("pulses", 1, 8)])
def test_some_seconds(name, life, rounds, show):
    machine = soak.live(name, life, rounds)
    assert machine.steps > 5000 and sum(machine.faults.values()) > 10
    show(f"soak of the {name}", f"{machine.steps} steps, {dict(machine.faults)}")


def test_lives_are_one_table_in_their_order(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(soak, "ROUNDS", {"plotter": 2, "pulses": 2})
    monkeypatch.setattr(soak.workers, "run_items", lambda work, items, count, cluster: ((item, work(item)) for item in reversed(items)))
    table = tmp_path / "lives.csv"
    assert soak.main(["--lives", "3", "--seed", "2", "--machine", "plotter", "--machine", "pulses", "--table", str(table)]) == 0
    rows = [line.split(",") for line in table.read_text().splitlines()]
    assert rows[0] == list(soak.COLUMNS)
    assert [row[:3] for row in rows[1:]] == [["plotter", "20000", "2"], ["pulses", "20001", "2"], ["plotter", "20002", "2"]]
    assert all(int(row[3]) > 0 and row[-1] == "" for row in rows[1:])
    assert int(rows[1][3]) == soak.live("plotter", 20000).steps
    monkeypatch.setattr(soak.workers, "run_items", lambda work, items, count, cluster: ((item, soak.workers.DIED if item[1] == 20001 else work(item)) for item in items))
    monkeypatch.setattr(Plotter, "round", lambda self: 1 / 0)
    assert soak.main(["--lives", "2", "--seed", "2", "--machine", "plotter", "--machine", "pulses", "--table", str(table)]) == 1
    assert "VIOLATION: plotter, life 20000" in table.read_text() and "died 3 times" in table.read_text()
    assert "2 violations" in capsys.readouterr().out


def doubles(monkeypatch):
    """A frame that is sent twice counts twice."""
    monkeypatch.setattr(FramedLine, "_take_data", lambda self, number, data: (setattr(self, "_next", (number + len(data)) % 4096), data)[1])


def ignores_the_door(monkeypatch):
    """A door that opens stops nothing."""
    monkeypatch.setattr(Inputs, "door_open", lambda self: False)


def drops_nothing(monkeypatch):
    """A stop drops none of the blocks under way."""
    monkeypatch.setattr(MachineState, "abort", lambda self: None)


def needs_no_homing(monkeypatch):
    """A board that has just been switched on moves."""
    monkeypatch.setattr(MachineState, "guard", lambda self: None)


def tells_no_reset(monkeypatch):
    """A reset is not told."""
    monkeypatch.setattr(MachineState, "announce_restart", lambda self, command=None: None)


def remembers_a_line(monkeypatch):
    """A job begins with the rest of the one before."""
    monkeypatch.setattr(Grbl, "begin_file", lambda self: self.gcode.reset())


def believes_any_sum(monkeypatch):
    """A packet is drawn whatever its sum."""
    hear = PlotterLanguage._keep_bytes

    def believing(self, data, now_ms):
        data = bytes(data)
        if len(data) == PACKET:
            data = data[:-1] + bytes([sum(data[:-1]) & 255])
        hear(self, data, now_ms)

    monkeypatch.setattr(PlotterLanguage, "_keep_bytes", believing)


def filters_nothing(monkeypatch):
    """The interlock takes each edge for a change that lasts."""
    from passo.options.interlock.port_virtual import VirtualInterlock

    begin = VirtualInterlock.__init__

    def hasty(self, *arguments):
        begin(self, *arguments)
        self._ticks = [0] * len(self._ticks)

    monkeypatch.setattr(VirtualInterlock, "__init__", hasty)


BROKEN = {
    doubles: ("router", "an answer to nothing"),
    ignores_the_door: ("router", "the door has been open"),
    drops_nothing: ("router", "homed, it stands at"),
    needs_no_homing: ("router", "cannot know where it is, and is Idle"),
    tells_no_reset: ("router", "no banner"),
    remembers_a_line: ("router", "Wrong: job: ["),
    believes_any_sum: ("plotter", "Wrong: no answer to LINE"),
    filters_nothing: ("mill", "AssertionError: (220, "),
}


def found(rule, monkeypatch, lives, rounds):
    """Return the soak's message about a machine that breaks `rule`."""
    name, wanted = BROKEN[rule]
    rule(monkeypatch)
    with pytest.raises(soak.Violation) as violation:
        for life in range(lives):
            soak.live(name, life, rounds)
    text = str(violation.value)
    assert wanted in text, text
    assert "events:" in text and f'make soak ARGS="--machine {name} --life ' in text
    return text


def test_a_broken_rule_is_found(monkeypatch):
    found(needs_no_homing, monkeypatch, 1, 1)


@pytest.mark.slow
@pytest.mark.unmeasured
@pytest.mark.parametrize("rule", BROKEN)
def test_broken_rules_are_found(rule, monkeypatch, show):
    show(rule.__doc__, found(rule, monkeypatch, 16, 20).splitlines()[0])


# --- what it has found


@pytest.mark.slow
@pytest.mark.unmeasured
@pytest.mark.parametrize("name, life", [("router", 230_003), ("router", 250_000), ("pulses", 10), ("pulses", 220_012), ("pulses", 770_175)])
def test_lives_that_found_something(name, life):
    """A relative program that had not begun; answers that waited for room; a stopped file, played as typed; a stream without an end; the error of a byte before."""
    soak.live(name, life)


def machine_with_job(lost):
    """A router that keeps the job A, of many short lines."""
    board = boards.load("router_3axis")
    board["jobs"] = {"language": "grbl"}
    board["links"][0].update(lost=lost, lost_ms=400)
    machine = VirtualMachine(board, start=(3000, 2500, -1800))
    data = b"G21G91\n" + b"G1X1.2345Y0.0001F3000\nG1X-1.2345Y-0.0001F3000\n" * 40
    packed = stored_job.pack_job(data)
    line = job_store.first_line("grbl", len(data), stored_job.crc_of(data), len(packed))
    (Path(machine.port.folder) / "A.job").write_bytes(line + packed)
    machine.send(b"$X\n")
    machine.run_ms(50)
    return machine


def test_a_job_that_was_stopped_amid_a_line_spoils_no_other():
    machine = machine_with_job("go_on")
    for after_ms in range(20, 620, 41):
        machine.send(b"$F=A\n")
        machine.run_ms(after_ms)
        machine.send(b"\x18")
        machine.run_ms(100)
        machine.send(b"$X\n")
        machine.run_ms(20)
    assert b"error 157" in machine.replies_so_far() and b"error 116" not in machine.replies_so_far()


@pytest.mark.parametrize("lost", ["pause", "stop"])
def test_a_stored_job_needs_no_host(lost):
    machine = machine_with_job(lost)
    machine.send(b"$F=A\n")
    machine.run_ms(50)
    begun = machine.now_ms()
    machine.settle()
    assert b"[MSG:Job A done]" in machine.replies_so_far() and machine.now_ms() - begun > 1000


@pytest.mark.parametrize("way", ["load", "stream"])
def test_what_comes_of_a_stopped_file_moves_nothing(way):
    """On a line that is noisy, so that nothing has come for a while; the other link has stopped the machine."""
    machine = pulses_machine()
    machine.send(b"{%s}[AAAA" % way.encode())
    machine.run_ms(3000)
    machine.send(b"{stop}", "panel")
    machine.run_ms(3000)
    before = list(machine.plant.position)
    machine.send(b"[" + b"C" * 400)
    machine.run_ms(3000)
    assert machine.plant.position == before
    machine.send(b"{end}{stream}[CC]{end}")
    machine.settle()
    assert machine.plant.position == [before[0], before[1] + 2, before[2]]


def pulses_machine():
    """With another link."""
    made = boards.load("lpt_router")
    made["links"].append({"name": "panel", "port": "uart1", "tx": 20, "rx": 21, "baud": 57_600, "protocol": "pulses"})
    return VirtualMachine(made, start=(9000, 9000, 2000))


def test_no_wait_behind_steps_is_called_late():
    """Words lie ahead for a cycle and two segments, wherever in its cycle the main loop is when the steps end."""
    machine = pulses_machine()
    for steps in range(40, 60):
        machine.send(b"{stream}[+2400 " + b"A" * steps + b"*160 B)]{end}")
        machine.run_until(lambda: b"end\n" in machine.replies_so_far())
        machine.take()
    assert not machine.app.controller.machine.log.counts.get(109)


@pytest.mark.parametrize("what, codes, why", [("stop", 12_000, "stopped by another program"), ("cut", 12_000, "no answer"), ("cut", 1500, "no answer")])
def test_a_stream_that_cannot_go_on_ends(what, codes, why, tmp_path):
    """`passo pulses play --stream`: another program stops the machine, or the cable is cut, amid the file or when all of it is sent."""
    machine = pulses_machine()
    path = tmp_path / "long.txt"
    path.write_text("[" + "ACBD" * (codes // 4) + "]")
    with plugged(machine) as wire, pytest.raises(Failure, match=why):
        cycle = wire._cycle

        def failing():
            cycle()
            if machine.now_ms() > 1000 and what == "cut":
                wire.cable.plugged = False
            elif 1000 < machine.now_ms() < 1010:
                machine.send(b"{stop}", "panel")

        wire._cycle = failing
        pulses.play(path, 1, None, True, None, False, "virtual", 115_200, True, None)


def test_a_packet_that_ends_in_zero_can_be_sent_again():
    """On a link with frames a zero could begin a question for them; it is not kept until the packet is sent again."""
    board = boards.load("plotter_2014")
    board["links"][0]["frames"] = True
    machine = VirtualMachine(board, start=(300, 200))
    data = packet(COMMANDS["MOVE"], 425, 233)
    assert data[-1] == 0
    machine.run_ms(50)
    machine.send(data[:2] + data[1:])
    answers = []
    while len(answers) < 9 and b"n" not in answers:
        machine.run_until(lambda: machine.replies_so_far(), 3000)
        answers.append(machine.take())
        if answers[-1] == b"r":
            machine.send(data)
    assert answers == [b"r", b"n"]


@pytest.mark.parametrize("name", ["STOP", "STATUS"])
def test_what_never_waits_overtakes_what_does(name):
    """In frames too: while a point waits for room the board takes STOP, and hears a host that only asks."""
    board = boards.load("plotter_2014")
    board["store_points"] = 10
    board["links"][0].update(frames=True, lost="stop", lost_ms=3000)
    plotter = Plotter(0, board, framed=True)
    plotter.ask("ORIGIN", wanted="ORIGIN_OK")
    for number in range(130):  # more than the buffer and the planner take
        plotter.put(packet(COMMANDS["LINE"], 3000 * (number % 2), 10 * number))
        plotter.hear_ms(20)
    assert plotter.machine.app.links[0].waiting
    for _ in range(20):
        plotter.put(packet(COMMANDS["STATUS"]))
        assert any(isinstance(answer, dict) for answer in plotter.hear_ms(250))
    assert plotter.moving()
    if name == "STOP":
        plotter.put(packet(COMMANDS["STOP"]))
        plotter.hear_ms(150)
        assert not plotter.moving()

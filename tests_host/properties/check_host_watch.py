"""The watchdog of the links: the reaction of a machine to a silent host."""

from boards.router_3axis import BOARD
from passo import errors
from passo.protocols import HELLO_WIRE
from passo.protocols.frames import codec
from passo.records import TICKS_PER_MS
from router import Machine

NOT_QUICK = ("check_a_host_that_does_not_ask",)
LOST_MS = 500


def machine_with(lost, frames=False):
    """A router that stands unlocked, feed 600 mm/min; its first link is watched."""
    links = [dict(link, lost=lost, lost_ms=LOST_MS, frames=frames) for link in BOARD["links"]]
    machine = Machine(links=links)
    for line in ("$X", "G21G91F600"):
        assert machine.ask(line)[-1] == "ok"
    return machine


def run_ms(machine, milliseconds, every=None):
    """Let time pass; the host says `every[1]` each `every[0]` ms."""
    end = machine.port.machine_ms() + milliseconds
    told = machine.port.machine_ms()
    while machine.port.machine_ms() < end:
        if every and machine.port.machine_ms() - told >= every[0]:
            told = machine.port.machine_ms()
            machine.put(every[1])
        machine.app.cycle()


def begin(machine, lines, sign="?"):
    """Begin a job, as a host that asks for the status."""
    machine.put(lines)
    run_ms(machine, 550, (100, sign))


def check_pause():
    """It comes to its stand on the path, says why in the log, goes on at a word, and is held again if no other follows."""
    machine = machine_with("pause")
    begin(machine, "G1X20\n")
    run_ms(machine, LOST_MS - 150)
    assert machine.controller.state == "run"
    run_ms(machine, 600)
    assert machine.controller.state == "hold" and 0 < machine.world.place[0] - 3000 < 6400
    assert machine.controller.machine.log.entries[-1][1:] == (errors.HOST_LOST, "pc")
    held = list(machine.world.place)
    run_ms(machine, 3000)
    assert machine.world.place == held and len(machine.controller.machine.log.entries) == 1
    machine.put("~")
    run_ms(machine, 300)
    assert machine.controller.state == "run"
    run_ms(machine, 700)
    assert machine.controller.state == "hold"
    machine.put("~")
    run_ms(machine, 3000, (100, "?"))
    assert machine.controller.state == "idle" and machine.world.place[0] == 3000 + 6400


def check_stop():
    """It comes to its stand, knows where it is, tool off, the rest dropped."""
    machine = machine_with("stop")
    begin(machine, "M3S1000\nG1X20\nG1Y20\n")
    run_ms(machine, 2000)
    assert machine.controller.machine.alarm == errors.ALARM_HOST_LOST and machine.world.tool == 0
    place = machine.world.place
    assert 0 < place[0] - 3000 < 6400 and place[1] == 2500
    assert list(machine.controller.position()) == [place[0] - 3000, 0, 0]
    assert "ALARM:50" in machine.said()
    assert machine.ask("$X")[-1] == "ok" and "ok" in machine.ask("G1X1")
    assert machine.controller.machine.spindle == 5


def check_spindle_at_rest():
    """A spindle that turns while nothing moves is under way too."""
    machine = machine_with("stop")
    begin(machine, "M3S1000\n")
    run_ms(machine, 2 * LOST_MS)
    assert machine.controller.machine.alarm == errors.ALARM_HOST_LOST and machine.world.tool == 0


def check_a_word_in_time_is_enough():
    for lost in ("pause", "stop"):
        machine = machine_with(lost)
        machine.put("G1X20\n")
        run_ms(machine, 3000, (LOST_MS - 100, "?"))
        assert machine.world.place[0] == 3000 + 6400 and machine.controller.state == "idle"


def check_a_host_that_does_not_ask():
    """A host that is silent while a long line lasts is not lost; nor one that asks now and then, as a person does."""
    for every in (None, (LOST_MS + 100, "?")):
        machine = machine_with("stop")
        machine.put("M3S1000\nG1X90F60\n")
        run_ms(machine, 6000, every)
        run_ms(machine, 90_000)
        assert machine.world.place[0] == 3000 + 90 * 320 and not machine.controller.machine.alarm


def check_a_host_that_dies_at_once():
    """One question in the job's first moments, or just before it, tells a host that asks from one that does not."""
    for before in (True, False):
        machine = machine_with("stop")
        machine.put("?" if before else "M3S1000\nG1X90F60\n?")
        run_ms(machine, 50)
        machine.put("M3S1000\nG1X90F60\n" if before else "")
        run_ms(machine, LOST_MS + 600)
        assert machine.controller.machine.alarm == errors.ALARM_HOST_LOST and machine.world.tool == 0


def check_a_host_that_stopped_asking():
    """It asked in the job's first second only, or long before it, and sends lines: it is not lost while one of them lasts."""
    for asks in (True, False):
        machine = machine_with("stop")
        machine.put("?")
        run_ms(machine, 2 * LOST_MS)
        for at in range(10):
            machine.put("G1X1F300\n" + ("?" if asks and at < 3 else ""))
            run_ms(machine, 200)
        machine.put("G1X20F300\n")
        run_ms(machine, 8000)
        assert machine.world.place[0] == 3000 + 30 * 320 and not machine.controller.machine.alarm


def check_who_looks_in_is_no_host():
    """A program that asks forty times at once, twice, at a machine whose host never asks: nobody is lost as it goes. One that has asked
    for three times lost_ms is a host."""
    machine = machine_with("stop")
    machine.put("M3S1000\nG1X90F300\n")
    run_ms(machine, 2 * LOST_MS)
    for _ in range(2):
        run_ms(machine, 200, (5, "?"))
        run_ms(machine, LOST_MS - 100)
    run_ms(machine, 2 * LOST_MS)
    assert machine.controller.state == "run" and machine.world.tool and not machine.controller.machine.log.entries
    run_ms(machine, 3 * LOST_MS + 200, (100, "?"))
    run_ms(machine, LOST_MS + 600)
    assert machine.controller.machine.alarm == errors.ALARM_HOST_LOST and machine.world.tool == 0


def check_a_host_that_asks_seldom():
    """grbl's stream.py asks once a second, and no more once its last line is answered: all lines sent are done. A host that asks more often counts as lost
    when it stops.
    """
    for every, lost in ((1000, False), (700, True)):
        links = [dict(link, lost="stop", lost_ms=3000) for link in BOARD["links"]]
        machine = Machine(links=links)
        machine.do("$X", "G21G91F600")
        machine.put("?G1X60\n")
        run_ms(machine, 2500, (every, "?"))
        run_ms(machine, 6000)
        assert bool(machine.controller.machine.alarm) == lost and (machine.world.place[0] == 3000 + 60 * 320) != lost


def check_a_job_asks_anew():
    """A host whose questions came late in one job is a host again in the next."""
    machine = machine_with("stop")
    machine.put("G1X10F300\n")
    run_ms(machine, 4000, (LOST_MS + 100, "?"))
    assert machine.controller.state == "idle"
    begin(machine, "G1X20F300\n")
    run_ms(machine, LOST_MS + 600)
    assert machine.controller.machine.alarm == errors.ALARM_HOST_LOST


def check_retract():
    """It comes to its stand, Z goes up, and then the spindle goes off; not before it is homed, and no laser."""
    for homed in (True, False):
        machine = machine_with("retract")
        if homed:
            assert machine.ask("$H")[-1] == "ok"
            machine.ask("G91F600")
        machine.do("G1X5Z-10" if homed else "G1X5", "M3S1000")
        machine.settle()
        machine.world.path = []
        run_ms(machine, 4 * LOST_MS, (100, "?"))  # the spindle has turned for a while without a question
        begin(machine, "G1X20\nG1Y20\n")
        run_ms(machine, 6000)
        assert machine.controller.machine.alarm == errors.ALARM_HOST_LOST and machine.world.tool == 0
        place = machine.controller.position()
        assert machine.world.path and all([row[4] for row in machine.world.path]), "the spindle turned until it was up"
        assert place[2] == 0 and (not homed or machine.world.path[-1][3] > machine.world.path[0][3])
        assert not machine.controller.machine.retracts
        assert machine.ask("$X")[-1] == "ok" and "ok" in machine.ask("G1X1")


def check_a_reset_amid_the_retreat():
    machine = machine_with("retract")
    assert machine.ask("$H")[-1] == "ok"
    machine.do("G91F600", "G1X5Z-40", "M3S1000")
    machine.settle()
    run_ms(machine, 4 * LOST_MS, (100, "?"))
    begin(machine, "G1X20\n")
    run_ms(machine, LOST_MS + 600)
    assert machine.controller.machine.retracts and machine.world.tool == 1
    assert machine.status()["state"] == "Hold:1", "it moves: no alarm yet that one may reach into"
    machine.put("\x18")
    run_ms(machine, 100)
    assert not machine.controller.machine.retracts and machine.world.tool == 0


def check_go_on():
    machine = machine_with("go_on")
    machine.put("G1X20\n")
    run_ms(machine, 3000)
    assert machine.world.place[0] == 3000 + 6400
    assert "host_watch" not in machine.controller.features


def check_a_standing_machine_misses_nobody():
    machine = machine_with("stop")
    run_ms(machine, 10 * LOST_MS)
    assert not machine.controller.machine.alarm


def check_noise_is_no_host():
    """On a framed link only a sound frame is a sign of life."""
    for sign, state in ((b"?~!G1X1\n\0\1\2\0", "hold"), (codec.delimit_frames(codec.frame(codec.ACK, 0, 0, 15)), "idle")):
        machine = machine_with("pause", True)
        begin(machine, "G1X20\n")
        machine.put(HELLO_WIRE)
        run_ms(machine, 3000, (100, sign))
        assert machine.controller.state == state, sign


def check_the_link_that_commands():
    """Only its host counts."""
    machine = machine_with("pause")
    begin(machine, "G1X20\n")
    other = machine.port.lines["serial"]
    for _ in range(10):
        other.incoming += b"?"
        run_ms(machine, 100)
    assert machine.controller.state == "hold"


def check_a_board_that_stood_still_misses_nobody():
    """Bytes that came while the board stood still are read before its host counts as lost; when no more come, it does."""
    machine = machine_with("stop")
    begin(machine, "G1X40F200\n")
    port = machine.port
    tripped = port.halting_input

    def stall():
        port.halting_input = tripped
        port.advance((LOST_MS + 200) * TICKS_PER_MS)
        machine.put("?")
        return tripped()

    for _ in range(3):
        port.halting_input = stall  # called behind the links and before the watch
        run_ms(machine, 50)
        assert port.halting_input is not stall and machine.controller.state == "run"
        run_ms(machine, 3 * LOST_MS + 200, (100, "?"))
    run_ms(machine, LOST_MS + 100)
    assert machine.controller.machine.alarm == errors.ALARM_HOST_LOST

"""Two links of different languages: one commands, the other may ask and make safe, and either can be handed the command."""

from boards.plotter_2014 import BOARD as PLOTTER
from boards.router_3axis import BOARD
from passo import errors
from passo.config.boardfile import BoardError, check
from passo.protocols.plotter.host import COMMANDS, packet, status_from
from passo.protocols.torch import protocol as torch
from router import Machine, answers

GRBL, DRAWER = {"name": "pc", "port": "uart0", "protocol": "grbl"}, {"name": "draw", "port": "usb", "protocol": "plotter"}
CASES = {
    "check_the_other_link_moves_nothing": (("lines", "list", 12, ("line", 0, 13)),),
    "check_the_other_link_draws_nothing": (("packets", "list", 12, ("packet", 0, 10)),),
}
RUNS = {"check_the_other_link_moves_nothing": 12, "check_the_other_link_draws_nothing": 12}
LINES = (
    "G0 X9", "G1 Y5 F500", "$J=G91 X1 F100", "$H", "$X", "$C", "$SLP", "M3 S900", "G10 L2 P1 X1", "G92 X0", "$100=80",
    "$N0=G20", "$I=me", "$RST=*",
)  # fmt: skip
PACKETS = ("LINE", "MOVE", "END", "ORIGIN", "SPEED", "UP", "LEFT", "DOWN", "RIGHT", "LINE", "MOVE")


class Two:
    """The router with grbl on one link and the plotter's language on the other."""

    def __init__(self, *links, **changes):
        self.machine = Machine(links=list(links or (GRBL, DRAWER)), jog={"steps": 10, "up": "y+"}, **changes)
        self.controller = self.machine.controller
        self.draw = self.machine.port.lines.get("draw")
        self.machine.cycles()

    def packet(self, name, x=0, y=0, turns=100_000):
        """Send a packet on the plotter's link; return the board's answer, b"" if none comes within `turns` cycles."""
        self.draw.outgoing = b""
        self.draw.incoming += packet(COMMANDS[name], x, y)
        while turns and not self.draw.outgoing:
            self.machine.app.cycle()
            turns -= 1
        return self.draw.outgoing

    def line(self, text):
        """The answer to a line on grbl's link."""
        return answers(self.machine.ask(text))[0]

    def rest(self, turns=100_000):
        """Run until the machine stands, and the coils of motors that have turned are without current."""
        self.machine.settle()
        while self.controller.state == "run":
            self.machine.app.cycle()
            turns -= 1
            assert turns, "still busy"

    def logged(self):
        return [(number, who) for _, number, who in self.controller.machine.log.entries]


def check_the_first_link_commands():
    two = Two()
    assert two.line("$LINK") == "ok" and two.controller.machine.commander == 0
    assert two.line("$X") == "ok" and two.line("G0 X3") == "ok"
    two.machine.settle()
    assert two.packet("LINE", 100, 100, turns=50) == b""
    assert two.logged() == [(errors.COMMANDED_ELSEWHERE, "draw")]
    status = status_from(two.packet("STATUS"))
    assert status["error"] == errors.COMMANDED_ELSEWHERE and status["x"] == 3 * 320 and status["state"] == "idle"
    assert two.packet("REQUEST") == b"k"


def check_the_board_file_names_another():
    two = Two(commands="draw")
    two.controller.machine.alarm = 0
    assert two.packet("SPEED", 900) == b"s"
    assert two.line("G0 X1") == "error:%d" % errors.COMMANDED_ELSEWHERE
    assert two.logged() == [(errors.COMMANDED_ELSEWHERE, "pc")]
    for line in ("$$", "$G", "$#", "$I", "$N", "", "$LINK", "$LOG"):
        assert two.line(line) == "ok", line
    assert two.machine.ask("$LINK")[0] == "[LINK:2,draw]"
    log = two.machine.ask("$LOG")
    assert log[0].split(",")[1:] == ["112", "pc]"] and log[1:] == ["[LOGGED:1x112]", "ok"]
    assert two.machine.status()["state"] == "Idle"


def check_the_other_link_moves_nothing(lines):
    """A line of the link that may not command changes no pin, setting, offset or mode."""
    two = Two(commands="draw")
    two.controller.machine.alarm = 0
    before = two.controller.machine.settings._dump_lines(), two.machine.ask("$#"), two.machine.ask("$G")
    for line in lines:
        assert two.line(LINES[line]) == "error:%d" % errors.COMMANDED_ELSEWHERE
        assert two.logged()[-1] == (errors.COMMANDED_ELSEWHERE, "pc")
    assert (two.controller.machine.settings._dump_lines(), two.machine.ask("$#"), two.machine.ask("$G")) == before
    assert two.machine.world.steps == 0 and two.controller.state == "idle"
    for byte in (b"~", b"\x91", b"\x9e", b"\xa0"):
        entries = len(two.controller.machine.log.entries)
        two.machine.put(byte)
        assert two.machine.cycles(3) == []
        assert len(two.controller.machine.log.entries) == min(32, entries + 1)


def check_the_other_link_draws_nothing(packets):
    two = Two()
    two.line("$X")
    entries = 0
    for index in packets:
        assert two.packet(PACKETS[index], 500, 300, turns=30) == b""
        entries += 1
        assert two.logged() == entries * [(errors.COMMANDED_ELSEWHERE, "draw")]
    assert two.machine.world.steps == 0 and two.controller.features["drawing"].points.count == 0


def check_anybody_makes_it_safe():
    """STOP, feed hold and reset work from the link that may not command."""
    two = Two()
    two.machine.do("$X", "G1 X20 F600")
    while two.controller.position()[0] < 100:
        two.machine.app.cycle()
    assert two.packet("STOP") == b"d" and two.controller.state == "idle"
    assert 0 < two.controller.position()[0] < 20 * 320
    place = two.controller.position()
    assert two.packet("RIGHT", turns=30) == b"" and two.controller.position() == place
    two = Two(commands="draw")
    two.controller.machine.alarm = 0
    for x, y in ((2000, 0), (2000, 2000)):
        assert two.packet("LINE", x, y) == b"n"
    two.draw.incoming += packet(COMMANDS["END"])
    while two.controller.position()[0] < 100:
        two.machine.app.cycle()
    two.machine.put(b"!")
    two.machine.cycles(300)
    assert two.machine.status()["state"] == "Hold:0"
    two.machine.put(b"~")
    two.machine.cycles(100)
    assert two.machine.status()["state"] == "Hold:0" and two.logged()[-1] == (errors.COMMANDED_ELSEWHERE, "pc")
    two.machine.put(b"\x18")
    two.machine.cycles(3)
    assert two.controller.state == "idle" and two.controller.machine.commander == 1


def check_a_lock_at_the_start_is_for_grbl_alone():
    """A machine with homing is locked for the senders of G-code until it is homed or unlocked; a plotter beside them moves
    as it does alone. A lock for another reason is everybody's."""
    two = Two(commands="draw")
    assert two.controller.state == "idle" and two.machine.status()["state"] == "Idle"
    for name, x, y, answer in (("MOVE", 50, 40, b"n"), ("LINE", 90, 40, b"n"), ("END", 0, 0, b"d"), ("UP", 0, 0, b"n")):
        assert two.packet(name, x, y) == answer
    two.machine.settle()
    two.machine.said()
    two.machine.do("$LINK=1")
    assert two.controller.state == "alarm" and two.line("G0 X1") == "error:%d" % errors.LOCKED
    assert two.packet("LINK") == b"t" and two.packet("MOVE", 5, 5) == b"n"
    two.machine.said()
    two.machine.put("$LINK=1\n")
    assert "[MSG:'$H'|'$X' to unlock]" in two.machine.cycles(5)
    two.machine.do("$X", "G0 X1")
    two.machine.settle()
    two.machine.do("$LINK=2", "$LINK=1", "G0 X0")  # unlocked once is unlocked
    two.machine.settle()
    two.controller.machine.raise_alarm(errors.ALARM_TWO_MOTORS, "test")
    two.machine.do("$LINK=2")
    assert two.packet("MOVE", 5, 5, turns=30) == b"" and status_from(two.packet("STATUS"))["state"] == "alarm"


def check_handing_over():
    two = Two()
    two.machine.do("$X", "G0 X2")
    assert two.packet("LINK", turns=20) == b"" and two.logged()[-1] == (errors.BUSY, "draw")  # while it moves
    two.machine.settle()
    two.machine.said()
    assert two.packet("LINK") == b"t" and two.controller.machine.commander == 1
    assert two.machine.said() == ["[MSG:Command handed over]"]
    assert two.line("G0 X1") == "error:%d" % errors.COMMANDED_ELSEWHERE
    for x, y in ((100, 50), (0, 50)):
        assert two.packet("LINE", x, y) == b"n"
    assert two.packet("END") == b"d" and two.controller.position()[:2] == [0, 50]
    assert two.packet("LINK", 1) == b"t" and two.controller.machine.commander == 0  # given back
    assert two.packet("UP", turns=30) == b""
    two.machine.do("G91", "G0 X1")
    two.machine.settle()
    assert two.controller.position()[:2] == [320, 50]  # it knows where the other link has left the machine
    two.machine.do("$LINK=2")
    assert two.packet("UP") == b"n"
    two.machine.settle()
    two.machine.do("$LINK=0", "G0 X1")


TORCH = {"name": "torch", "port": "usb", "protocol": "torch"}
KEYS = {"name": "kit", "port": "uart1", "tx": 20, "rx": 21, "protocol": "keys"}
PULSES = {"name": "lpt", "port": "uart1", "tx": 20, "rx": 21, "protocol": "pulses"}


def check_torch_beside_grbl():
    """The manipulator's frames are refused in silence while grbl commands, the answer to a question is not; the command is
    handed over both ways, each language then moves, and each knows where the other has left the machine."""
    two = Two(GRBL, TORCH)
    line = two.machine.port.lines["torch"]

    def say(data, turns=60):
        line.outgoing = b""
        line.incoming += data
        two.machine.cycles(turns)
        two.machine.settle()
        return line.outgoing

    two.machine.do("$X")
    assert say(torch.move(100, 480, 50, -480)) == b""
    assert two.logged()[-1] == (errors.COMMANDED_ELSEWHERE, "torch") and two.machine.world.steps == 0
    assert say(torch.frame("JOG_X+")) == b"" and two.machine.world.steps == 0
    assert say(torch.frame("INFO")) == torch.answer("INFO", 0, 0)
    assert say(torch.passo(torch.LINK_OF, 0)) == b""
    assert two.controller.machine.commander == 1
    say(torch.frame("CONNECT"))
    say(torch.move(100, 480, 50, -480))
    assert two.controller.position()[:2] == [100, -50]
    assert two.line("G0 X1") == "error:%d" % errors.COMMANDED_ELSEWHERE
    assert two.logged()[-1] == (errors.COMMANDED_ELSEWHERE, "pc")
    two.machine.do("$LINK=1", "G91", "G0 X1")
    two.machine.settle()
    assert two.controller.position()[:2] == [420, -50]
    two.machine.do("G0 X5")
    assert say(torch.frame("STOP"), 3)[:1] == torch.frame("STOP")[:1]  # from every link
    assert two.controller.position()[0] < 420 + 5 * 320


def check_pulses_beside_torch():
    """Codes and controls are refused by number on one link while the other commands; stopping and asking are not."""
    two = Two(dict(TORCH, name="pc"), PULSES, step_program={})
    pulses, torch_line = two.machine.port.lines["lpt"], two.machine.line

    def say(data, turns=80):
        pulses.outgoing = b""
        pulses.incoming += data
        two.machine.cycles(turns)
        return pulses.outgoing

    refused = b"error:%d" % errors.COMMANDED_ELSEWHERE
    for data in (b"{jog x 10}", b"{run}", b"{drives on}", b"{load 3}ABC"):
        assert refused in say(data), data
        assert two.logged()[-1] == (errors.COMMANDED_ELSEWHERE, "lpt")
    assert say(b"{?}")[:1] == b"<" and two.machine.world.steps == 0
    torch_line.incoming += torch.move(20_000, 4000, 0, 1)
    two.machine.cycles(60)
    assert b"ok" in say(b"{stop}") and 0 < two.controller.position()[0] < 20_000
    assert b"ok" in say(b"{link}") and two.controller.machine.commander == 1
    assert b"ok" in say(b"{jog y 10}", 200) and two.controller.position()[1] == 10
    torch_line.incoming += torch.move(100, 480, 0, 1)
    two.machine.cycles(60)
    assert two.logged()[-1] == (errors.COMMANDED_ELSEWHERE, "pc") and two.controller.position()[1] == 10


def check_keys_beside_grbl():
    """A language without any such word is given the command, and may always switch off."""
    two = Two(GRBL, KEYS)
    line = two.machine.port.lines["kit"]
    two.machine.do("$X")
    line.incoming += b"I"
    two.machine.cycles(50)
    assert two.machine.world.steps == 0 and two.logged()[-1] == (errors.COMMANDED_ELSEWHERE, "kit")
    two.machine.do("$LINK=2")
    line.incoming += b"A\x02I"
    two.machine.cycles(100)
    assert two.machine.world.steps > 20 and two.machine.status()["state"] == "Run"
    assert two.line("$LINK=1") == "error:%d" % errors.BUSY
    two.machine.do("$LINK")
    line.incoming += b"J"
    two.rest()
    steps = two.machine.world.steps
    two.machine.do("$LINK=1", "G0 X0")
    two.machine.settle()
    assert two.controller.position()[0] == 0 and two.machine.world.steps > steps
    line.incoming += b"C"
    two.machine.cycles(50)
    assert two.controller.position()[0] == 0 and line.outgoing == b""


def check_the_emergency_stop_is_nobodys():
    """It ends the motion of either link, in an alarm that both report."""
    two = Two()
    two.machine.do("$X", "G1 X20 F600")
    while two.controller.position()[0] < 100:
        two.machine.app.cycle()
    two.machine.world.switches["stop"] = 1
    said = two.machine.cycles(5)
    assert "ALARM:1" in said and two.logged()[-1] == (errors.ALARM_HARD_LIMIT, "stop")
    steps = two.machine.world.steps
    two.machine.cycles(200)
    assert two.machine.world.steps == steps
    assert status_from(two.packet("STATUS"))["state"] == "alarm"


def check_a_link_that_is_not_there():
    two = Two()
    assert two.line("$LINK=3") == "error:%d" % errors.NO_SUCH_LINK
    assert two.packet("LINK", 9, turns=20) == b"" and two.logged()[-1] == (errors.NO_SUCH_LINK, "draw")
    for text in ("$LINK=", "$LINK=draw", "$LINKS"):
        assert two.line(text) == "error:%d" % errors.STATEMENT
    assert two.controller.machine.commander == 0


def check_the_tool_is_off_after_a_hand_over():
    """Taken by another link at rest, or given away; and no line brings it back before the next M3."""
    for take in (lambda two: two.packet("LINK"), lambda two: two.line("$LINK=2")):
        two = Two()
        two.machine.do("$X", "M3 S1000", "M8", "G1 X1 F600")
        two.machine.settle()
        assert two.machine.world.tool
        take(two)
        two.machine.cycles(20)
        assert not two.machine.world.tool and two.controller.machine.commander == 1
        two.machine.do("$LINK=0", "G1 X2")
        two.machine.settle()
        assert not two.machine.world.tool
        assert "M5 M9" in two.machine.ask("$G")[0]
        two.machine.do("M3", "G1 X3")
        two.machine.settle()
        assert two.machine.world.tool


def check_what_waited_is_refused_after_the_hand_over():
    """A command that was let in and waits its turn still needs the command when its turn comes."""
    two = Two(commands="draw")
    two.controller.machine.alarm = 0
    two.packet("LINE", 30_000, 0)
    two.draw.incoming += packet(COMMANDS["END"]) + packet(COMMANDS["SPEED"], 900)
    two.machine.cycles(60)
    assert two.machine.app.links[1].waiting
    two.controller.machine.commander = 0
    two.draw.outgoing = b""
    two.machine.settle()
    two.machine.cycles(20)
    assert two.draw.outgoing == b"d" and two.logged()[-1] == (errors.COMMANDED_ELSEWHERE, "draw")


def check_one_link_is_as_before():
    for board in (BOARD, PLOTTER):
        board = check(dict(board))
        assert board["commands"] == ""


def check_wrong_board_files():
    for changes, words in (
        ({"commands": "usb2"}, ("commands", "'usb2'", "pc, draw")),
        ({"links": [GRBL, dict(DRAWER, name="pc")]}, ("links", "once", "pc, pc")),
    ):
        board = dict(BOARD, links=[GRBL, DRAWER])
        board.update(changes)
        try:
            check(board)
        except BoardError as error:
            for word in words:
                assert word in str(error), str(error)
            continue
        raise AssertionError("accepted")

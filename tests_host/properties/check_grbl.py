"""The grbl link on the whole firmware: its lines, every `$`, every real-time byte, both flow controls."""

from boards.router_3axis import BOARD
from passo import commands, errors
from passo.config.journal import MemorySlots
from passo.protocols.grbl.lines import plain_text
from passo.protocols.grbl.protocol import real_time
from passo.protocols.grbl.report import decimal_text
from draws import Random
from router import BANNER, UNHOMED, Machine, answers

CASES = {
    "check_decimals": (("value", -(1 << 40), 1 << 40), ("places", 0, 4)),
    "check_every_line_end_is_answered_in_order": (("seed", "seed"),),
    "check_comments_and_blanks_do_not_count": (("first", 0, 3000), ("second", 0, 3000), ("third", 0, 3000), ("size", 1, 5000)),
}
RUNS = {"check_every_line_end_is_answered_in_order": 6, "check_comments_and_blanks_do_not_count": 20}
EXAMPLES = {"check_comments_and_blanks_do_not_count": ((0, 0, 300, 5000), (300, 0, 0, 64), (0, 1000, 0, 7))}


def check_greeting_and_lock():
    machine = Machine()
    assert machine.line.outgoing == b"\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n"
    machine.said()
    assert machine.status()["state"] == "Alarm"
    assert machine.ask("G0 X1") == ["error:9"]
    assert machine.ask("$J=X1F100") == ["error:8"]
    assert machine.ask("") == ["ok"] and machine.ask("(comment)") == ["ok"] and machine.ask("%") == ["ok"]
    assert machine.ask("$X") == ["[MSG:Caution: Unlocked]", "[MSG:Caution: not homed, soft limits do not hold]", "ok"]
    assert machine.ask("$X") == ["ok"]
    assert machine.status()["state"] == "Idle"
    assert machine.world.steps == 0


def check_both_ends_of_lines():
    machine = Machine().ready()
    machine.put(b"G4P0\nG4P0\rG4P0\r\n\r\n\n")
    assert machine.cycles(5) == ["ok"] * 5
    machine.put(b"G4P0\r")
    machine.cycles(3)
    machine.put(b"\nG4P0\n")
    assert machine.cycles(3) == ["ok"]
    for data in (b"G4P0\r", b"\n", b"\n", b"\r", b"\n\n"):
        machine.put(data)
        machine.cycles(1)
    machine.put(b"\n")
    machine.cycles(3)
    machine.said()
    machine.put(b"\r")
    said = machine.cycles(2)
    for _ in range(2):
        machine.put(b"\n")
        said += machine.cycles(2)
    assert said == ["ok"] * 2


def check_a_few_lines_a_turn():
    """If lines take time, a burst of them is spread over cycles, and a question in between is answered first."""
    machine = Machine().ready()
    machine.app.links[0].batch.most = 3
    machine.app.links[0].protocol._most = 1
    machine.put("G91 G0\n" + "".join(["X%d\n" % (i + 1) for i in range(10)]))
    assert machine.cycles() == ["ok"]  # it goes the long way
    assert machine.cycles() == ["ok"] * 3
    machine.put("?")
    said = machine.cycles()
    assert len(said) == 1 and said[0].startswith("<")
    assert machine.cycles(3) == ["ok"] * 7
    machine.put("G91 G0 X1\n" * 2)
    assert machine.cycles() == ["ok"]
    assert machine.cycles() == ["ok"]
    machine.settle()
    assert machine.controller.queue.target[0] == 57 * 320


def check_real_time_bytes_come_between_lines_that_take_time():
    """On a chip, where an interrupt makes words: the line that is being understood is the last before the answer."""
    for byte, then in ((b"?", "<"), (b"\x18", BANNER)):
        machine = Machine().ready()
        machine.app.interrupt = True
        machine.port.set_out = lambda live: None
        for line in machine.port.lines.values():
            line.any = lambda line=line: line.incoming != b""
        write = machine.line.write

        def answered(data):
            write(data)
            if data == b"ok\r\n" and byte not in machine.line.incoming and then.encode() not in machine.line.outgoing:
                machine.put(byte)

        machine.line.write = answered
        machine.put("G54\nG55\n" * 4)
        said = machine.cycles(4)
        assert said[0] == "ok" and said[1].startswith(then), said
        assert said.count("ok") == (8 if byte == b"?" else 1), said


def check_a_question_ends_the_reading_of_lines():
    """It waits for no further bytes, however many come."""
    machine = Machine().ready()
    protocol = machine.app.links[0].protocol
    batch = protocol.batch
    assert [command.kind for command in protocol.take_batch(b"G0X1\nG0X2?\n", 0)] == [commands.STATUS] and not batch.begun
    assert protocol.take_batch(b"", 0) == b"ok\r\n" * 2 and batch.begun
    assert protocol.take_batch(b"", 0) == b""
    assert [command.kind for command in protocol.take_batch(b"?G0X3\n", 0)] == [commands.STATUS] and batch.begun
    batch.close(batch)
    assert protocol.take_batch(b"", 0) == b"ok\r\n"
    batch.close(batch)


def check_plain_text():
    assert plain_text(b" $n0 = g1 x1 \xff\x01") == "$N0=G1X1"


def check_decimals(value, places):
    text = decimal_text(value, places)
    assert int(text.replace(".", "")) == value and (len(text.split(".")[1]) == places if places else "." not in text)


def check_settings_lines():
    machine = Machine().ready()
    for line, said in (
        ("$100=160", ["ok"]), ("$ 1 0 1 = 160.5", ["ok"]), ("$110=-1", ["error:4"]), ("$110=", ["error:2"]),
        ("$110=x", ["error:2"]), ("$110=1x", ["error:2"]), ("$110=1X2", ["error:2"]), ("$7=1", ["error:3"]),
        ("$=1", ["error:3"]), ("$K", ["error:3"]), ("$110", ["error:3"]), ("$0=2", ["error:6"]), ("$22=0", ["ok"]),
        ("$20=1", ["error:10"]), ("$H", ["error:5"]), ("$22=1", ["ok"]), ("$110=900000", ["error:12"]),
        ("$32=1", ["error:17"]), ("$N2=G0", ["error:3"]), ("$N0", ["error:3"]), ("$N0=G7", ["error:20"]),
        ("$RST=x", ["error:3"]), ("$J", ["error:3"]), ("$J=X1", ["error:22"]), ("$J=G1X1F1", ["error:16"]),
        ("$10=3", ["ok"]), ("$13=1", ["ok"]), ("$110=1.5.5", ["error:2"]),
        ("$I=" + "x" * 78, ["error:11"]),
    ):
        got = machine.ask(line)
        assert got == said, (line, got)
    shown = machine.ask("$$")
    assert "$100=160.000" in shown and "$101=160.500" in shown and "$10=3" in shown and shown[-1] == "ok"
    again = Machine(slots=machine.slots)
    assert "$101=160.500" in again.ready().ask("$$")
    assert again.controller.machine.settings.value(13) == 1


def check_texts_and_start_lines():
    machine = Machine().ready()
    assert machine.ask("$I=shop 2") == ["ok"]
    assert machine.ask("$I")[0] == "[VER:1.1h.20190830:SHOP2]"
    assert machine.ask("$I")[1].startswith("[OPT:V")
    assert machine.ask("$N0=G54 G20") == ["ok"]
    assert machine.ask("$N") == ["$N0=G54G20", "$N1=", "ok"]
    assert machine.ask("$G")[0] == "[GC:G0 G54 G17 G20 G90 G94 M5 M9 T0 F0 S0]"
    machine.put(b"\x18")
    assert machine.cycles(4) == [BANNER, ">G54G20:ok"]
    again = Machine(slots=machine.slots)
    assert again.cycles(3) == [BANNER, UNHOMED]
    again.put(b"$H\n")
    again.settle()
    assert again.cycles(4) == ["ok", ">G54G20:ok"]
    assert again.ask("$N0=") == ["ok"]
    again.put(b"\x18")
    assert again.cycles(4) == [BANNER]


def check_a_start_line_that_is_refused_is_not_kept():
    """Refused by the parser, by the machine, or beyond the travel, at its first motion or its last: the line stored before stays."""
    machine = Machine().ready()
    assert machine.ask("$N0=G21") == ["ok"] and machine.ask("F600") == ["ok"]
    for line, answer in (
        ("G7", "error:20"), ("G1X1F0.001", "error:33"), ("G1X9000F600", "error:15"), ("G0X9999999", "error:15"), ("M64P9", "error:102"), ("G2X1Y0F600", "error:35"),
    ):  # fmt: skip
        said = machine.ask("$N0=" + line)
        assert said[-1].startswith(answer), (line, said)
        assert machine.ask("$N")[0] == "$N0=G21", line
    said = machine.ask("$N0=G38.2Z-1F100")
    assert said[0] == "ALARM:5" and said[-1] == "error:9" and machine.ask("$N")[0] == "$N0=G21", said
    assert machine.ask("$X")[-1] == "ok" and answers(machine.ask("G0Z0")) == ["ok"]
    machine.settle()
    assert machine.ask("$N0=G99G81X1Z-1R0F600") == ["ok"]
    machine.settle()
    assert machine.ask("$N")[0] == "$N0=G99G81X1Z-1R0F600"
    assert machine.ask("$N0=") == ["ok"] and machine.ask("$N")[0] == "$N0="
    homed = Machine().ready()
    homed.put(b"$H\n")
    homed.settle()
    homed.cycles(4)
    homed.do("$20=1", "$N1=G90")
    for line in ("G53G0X999", "G53G0X-1X999", "G99G81X1Z-999R0F100"):
        homed.ask("$N1=" + line)
        homed.put(b"\x18")
        homed.cycles(4)
        homed.do("$X")
        assert homed.ask("$N")[1] == "$N1=G90", line


def check_texts_too_long():
    """A line of 80 characters cannot hold one; other callers' texts are refused."""
    machine = Machine(links=BOARD["links"][:1]).ready()
    system = machine.app.links[0].protocol.system
    assert system.execute_line("$I=" + "A" * 81) == errors.START_LINE_TOO_LONG
    assert system.execute_line("$N0=" + "G4P0(" + "A" * 80 + ")") == errors.START_LINE_TOO_LONG
    assert machine.ask("$N0")[-1] == "error:3" and machine.ask("$N")[0] == "$N0="


def check_restore():
    machine = Machine().ready()
    machine.do("$110=1000", "G10L2P1X5", "$N0=G21", "$13=1")
    assert machine.ask("$RST=$")[:3] == ["[MSG:Restoring defaults]", "ok", BANNER]
    machine.cycles(5)
    assert "$110=5000.000" in machine.ask("$$")
    assert machine.ask("$#")[0] == "[G54:5.000,0.000,0.000]"
    machine.do("$110=1000")
    assert machine.ask("$RST=#")[1] == "ok"
    machine.cycles(5)
    assert machine.ask("$#")[0] == "[G54:0.000,0.000,0.000]" and machine.ask("$N")[0] == "$N0=G21"
    assert "$110=1000.000" in machine.ask("$$")
    assert machine.ask("$RST=*")[1] == "ok"
    machine.cycles(5)
    assert machine.ask("$N")[0] == "$N0="
    assert "$110=5000.000" in Machine(slots=machine.slots).ready().ask("$$")


def check_damaged_settings_are_told():
    slots = MemorySlots()
    slots.data = [b"passo 1 7 00000000\n110=500", b"\xff" * 40]
    machine = Machine(slots=slots)
    assert machine.cycles(1) == ["error:7", BANNER, UNHOMED]
    machine.ready().do("$110=600")
    machine.put(b"\x18")
    assert machine.cycles(3) == [BANNER]
    assert Machine(slots=slots).cycles(1) == [BANNER, UNHOMED]


def check_settings_that_cannot_be_kept():
    """A refused change has no effect. An offset counts, the log says that it is not kept, and flash is not written again and again."""
    machine = Machine().ready()
    tries = []

    def full(slot, data):
        tries.append(slot)
        raise OSError(28)

    machine.do("$N0=G21", "G10L2P1X5")
    machine.cycles(5)
    before = machine.ask("$$"), machine.ask("$N"), machine.ask("$#"), machine.ask("$I")
    machine.slots.write = full
    for line in ("$110=600", "$22=0", "$N0=G20", "$I=mill", "$RST=$", "$RST=#", "$RST=*"):
        assert machine.ask(line) == ["error:7"], line
        machine.cycles(5)
        assert (machine.ask("$$"), machine.ask("$N"), machine.ask("$#"), machine.ask("$I")) == before, line
    tries.clear()
    machine.do("G21", "G10L2P1X7")
    machine.cycles(20)
    assert len(tries) == 1 and machine.ask("$#")[0] == "[G54:7.000,0.000,0.000]"
    assert [entry[1] for entry in machine.controller.machine.log.entries][-1] == errors.MEMORY


def check_nothing_is_written_while_moving():
    machine = Machine().ready()
    writes = []
    kept = machine.slots.write

    def write(slot, data):
        writes.append(machine.controller.queue.still())
        kept(slot, data)

    machine.slots.write = write
    machine.do("G1 X5 F600", "G10 L2 P1 X1", "G28.1")
    assert writes == []
    machine.settle()
    machine.cycles(900)  # a sender that counts may send at any moment: the erasing of flash then would cost its bytes
    assert writes == []
    machine.cycles(200)
    assert writes == [True]
    machine.do("G10 L2 P1 X1.5")
    machine.cycles(2)
    assert writes == [True, True]
    assert Machine(slots=machine.slots).controller.machine.settings.get("G54") == "1500000,0,0"


def check_busy_refusals():
    machine = Machine().ready()
    machine.do("G1 X20 F600")
    for line in ("$H", "$SLP", "$#", "$I", "$N", "$110=100", "$RST=$", "$C", "$$"):
        assert machine.ask(line) == ["error:8"], line
    assert answers(machine.ask("$G")) == ["ok"]


def check_parameters_and_modes():
    machine = Machine().ready()
    assert machine.ask("$G") == ["[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]", "ok"]
    machine.do("G1 X1 F600.4", "G55 G91 G18 G93 M7", "M8", "T7 S1200 M4", "G43.1 Z2")
    machine.settle()
    assert machine.ask("$G")[0] == "[GC:G1 G55 G18 G21 G91 G93 M4 M7 M8 T7 F0 S1200]"
    machine.do("G94 F100", "G38.3 Z-1")
    machine.settle()
    assert machine.ask("$G")[0].startswith("[GC:G38.3 G55")
    machine.do("G90 G10 L2 P6 X1 Y-2.5 Z.0004", "G28.1", "G92 X0")
    said = machine.ask("$#")
    assert said[5] == "[G59:1.000,-2.500,0.000]" and said[6].startswith("[G28:1.000,0.000,") and len(said) == 13
    assert said[8] == "[G92:1.000,0.000,0.000]" and said[9] == "[TLO:2.000]" and said[10] == "[HOMED:0]" and said[11].startswith("[PRB:")
    machine.do("$13=1")
    assert machine.ask("$#")[5] == "[G59:0.0394,-0.0984,0.0000]"


def check_status_report():
    machine = Machine().ready()
    assert machine.status()["text"] == "<Idle|MPos:0.000,0.000,0.000|Bf:96,512|FS:0,0|WCO:0.000,0.000,0.000>"
    assert machine.status()["text"] == "<Idle|MPos:0.000,0.000,0.000|Bf:96,512|FS:0,0|Ov:100,100,100|Nh:XYZ>"
    shown = [machine.status() for _ in range(40)]
    for name, every in (("WCO", 10), ("Ov", 10)):
        at = [place for place in range(40) if name in shown[place]]
        assert len(at) in (3, 4, 5) and all([b - a in (every, every + 1) for a, b in zip(at, at[1:])]), (name, at)
    assert not [fields for fields in shown if "WCO" in fields and "Ov" in fields]
    machine.do("G10 L2 P1 X1.5", "G4 P0")
    fields = machine.status()
    assert fields["WCO"] == "1.500,0.000,0.000"
    machine.do("$10=2")
    fields = machine.status()
    assert fields["WPos"] == "-1.500,0.000,0.000" and fields["Bf"] == "96,512" and "MPos" not in fields
    machine.do("$13=1", "N7 G1 X30 F600 S500 M3")
    machine.cycles(20)
    fields = machine.status()
    assert fields["state"] == "Run" and fields["Ln"] == "7" and abs(float(fields["WPos"].split(",")[0])) < 0.06
    assert fields["FS"].endswith(",500") and 20 <= float(fields["FS"].split(",")[0]) <= 24
    machine.world.switches["probe"] = 0
    machine.world.switches["limit_y"] = 1
    assert machine.status()["Pn"] == "YP"


def check_bytes_are_counted():
    machine = Machine().ready()
    machine.put(b"G4P5\n")
    machine.cycles(3)
    machine.put(b"G0X1\nG0Y")
    machine.cycles(2)
    assert machine.status()["Bf"].split(",")[1] == str(512 - 8)


def check_every_real_time_byte():
    kinds = {}
    for byte in range(256):
        command = real_time(byte)
        if command is not None:
            kinds[byte] = command.kind
    wanted = [0x18, 0x21, 0x3F, 0x7E, 0x84, 0x85, 0x9E, 0xA0, 0xA1]
    wanted += list(range(0x90, 0x98)) + list(range(0x99, 0x9E))
    assert sorted(kinds) == sorted(wanted)


def check_overrides():
    machine = Machine().ready()
    machine.status()
    for data, shown in (
        (b"\x91", "110,100,100"), (b"\x93\x93", "112,100,100"), (b"\x92\x94", "101,100,100"), (b"\x90", "100,100,100"),
        (b"\x91" * 30, "200,100,100"), (b"\x92" * 30, "10,100,100"), (b"\x90\x96", "100,50,100"),
        (b"\x97", "100,25,100"), (b"\x95\x9a", "100,100,110"), (b"\x9c\x9b\x9d", "100,100,100"), (b"\x99", "100,100,100"),
    ):
        machine.put(data)
        machine.cycles(2)
        assert ",".join([str(part) for part in machine.controller.machine.overrides]) == shown
    machine.put(b"\x91\x96\x9a")
    machine.do("M30")
    assert machine.controller.machine.overrides == [100, 100, 100]


def check_real_time_bytes_inside_lines():
    """They are taken out wherever they stand."""
    machine = Machine().ready()
    machine.put(b"G1?X\x911F6?00\n")
    said = machine.cycles(3)
    assert answers(said) == ["ok"] and len([line for line in said if line.startswith("<")]) == 1
    assert "[MSG:Letters beyond ASCII acted: feed 110 %]" in said
    machine.settle()
    assert machine.controller.position() == [320, 0, 0] and machine.controller.machine.overrides[0] == 110


def check_letters_of_one_byte():
    """Cp1252 has letters where grbl has real-time bytes: the message about their effect comes with the line that has them, and with no other."""
    for byte, acted in ((b"\x96", "rapids 50 %"), (b"\x84", "door"), (b"\x85", "jog cancel"), (b"\xa0", "flood on"), (b"\x91", "feed 110 %"), (b"\x9a", "spindle 110 %")):
        for cut in (1, 2, 3, 4):
            machine = Machine().ready()
            line = b"G0X1" + byte + b"\n"
            machine.put(line[:cut])
            machine.cycles(2)
            machine.put(line[cut:] + b"G0Y1\n")
            said = machine.cycles(8)
            machine.put(b"~G0X2\n")
            said += machine.cycles(12)
            told = [at for at in said if at.startswith("[MSG:Letters")]
            assert told == ["[MSG:Letters beyond ASCII acted: %s]" % acted] and answers(said) == ["ok"] * 3, (byte, cut, said)


def check_real_time_bytes_as_utf_8():
    """CNCjs writes them so, C2 before each: the byte acts, and the line behind it is done. A no-break space, C2 A0, is a letter."""
    for data in (b"\xc2\x91", b"\xc2\x91\xc2\x93", b"?\xc2\x91?", b"G0Y1\n\xc2\x91"):
        for cut in range(len(data) + 1):
            machine = Machine().ready()
            machine.put(data[:cut])
            said = machine.cycles(3)
            machine.put(data[cut:])
            said += machine.cycles(3)
            assert machine.controller.machine.overrides[0] >= 110
            machine.put(b"G0X1\n")
            said = [line for line in said + machine.cycles(8) if line[:1] != "<"]
            assert said == ["ok"] * (1 + data.count(b"G")), (data, cut, said)
            machine.settle()
            assert machine.controller.position()[0] == 320
    machine = Machine().ready()
    machine.put(b"\xc2\xa0G0X1\n")
    assert answers(machine.cycles(8)) == ["error:1"]


# (line, the effects of real-time bytes in it, in the words of the message; None: no message)
LETTERS = (
    ("X\u22125", "feed 90 %"), ("X1\xb75", None), ("G1\xa0X3", "flood on"), ("\u2212", "feed 90 %"), ("%\u2212", "feed 90 %"),
    ("$X\u2212", "feed 90 %"), ("$J=G91X\u22121F100", "feed 90 %"), ("G1 X1 (\u0431" + 300 * "\u0431" + ") Y\u2212", "feed 90 %"),
    ("X1" + 300 * " " + "\u2212", "feed 90 %"), ("X\u0417\u041c\u0450", "feed 100 %, rapids 25 %, spindle 101 %"), ("S\u04a1\u041e", "spindle stop, mist on"),
)  # fmt: skip


def check_letters_beyond_ascii():
    """A byte that is no real-time byte is error 1 of its line, wherever the line is cut; a message names the effects of real-time bytes in it. The
    lines around it are done, and comments may have any letters."""
    for text, changed in LETTERS:
        line = text.encode()
        for cut in (0, 1, 2, 3, 4, len(line) - 1):
            machine = Machine().ready()
            machine.put(b"G0X1\n" + line[:cut])
            said = machine.cycles(2)
            machine.put(line[cut:] + b"\nG0Y1\n")
            said += machine.cycles(8)
            wanted = ["[MSG:Letters beyond ASCII acted: %s]" % changed] if changed else []
            assert [part for part in said if part] == ["ok"] + wanted + ["error:1", "ok"], (text, cut, said)
            machine.settle()
            assert machine.controller.position()[:2] == [320, 320], (text, cut)


def check_letters_in_comments():
    """They cost nothing; a real-time byte among them acts, with a message."""
    machine = Machine().ready()
    for text, wanted in (("X2 (\xe9)", []), ("(\xe9 \u0431) X3 ; \xff", []), ("; " + 300 * "\u0431", []), ("X4 (\u0417)", ["[MSG:Letters beyond ASCII acted: rapids 25 %]"])):
        machine.put(b"G0" + text.encode() + b"\n")
        assert [part for part in machine.cycles(8) if part] == wanted + ["ok"], text
    machine.settle()
    assert machine.controller.position()[0] == 4 * 320 and machine.controller.machine.overrides == [100, 25, 100]


SQUARE = ["G1 X%d.%d Y%d F4000" % (5 + i % 7, i % 10, i % 5) for i in range(150)] + ["G1 X1 Y2 Z-1"]


def check_ok_counting():
    machine = Machine().ready()
    for line in SQUARE:
        assert machine.ask(line) == ["ok"]
    machine.settle()
    assert machine.controller.position() == [320, 640, -400]


def check_character_counting():
    """128 bytes under way at most, newline included: one ok a line, nothing lost, the same end."""
    machine = Machine().ready()
    waiting = [line + "\n" for line in SQUARE]
    under_way = []
    oks = 0
    while waiting or under_way:
        while waiting and sum([len(line) for line in under_way]) + len(waiting[0]) <= 128:
            under_way.append(waiting[0])
            machine.put(waiting.pop(0))
        for line in machine.cycles():
            assert line == "ok", line
            oks += 1
            under_way.pop(0)
    assert oks == len(SQUARE)
    machine.settle()
    assert machine.controller.position() == [320, 640, -400]


def check_a_flood_is_refused_line_by_line():
    """A sender that counts nothing: lines without room are refused, and every line has its answer."""
    machine = Machine().ready()
    machine.do("G4P0")
    machine.put(b"G4P1\n" + b"G91G0X1\n" * 300)
    said = []
    while len(said) < 301:
        said += machine.cycles()
    kept = said.count("ok") - 1
    assert 100 < kept < 200 and said.count("error:11") == 300 - kept
    machine.settle()
    assert machine.controller.position() == [320 * kept, 0, 0]
    assert machine.ask("G4P0") == ["ok"]


FLOOD = [b"G91G1X%d.%dF3000;%s\n" % (number % 2, number % 10, b"c" * (number % 97)) for number in range(150)]


def check_every_line_end_is_answered_in_order(seed):
    """Lines of any length, in pieces of any size, all without waiting: the first are done, then each line without room is refused, each line has one
    answer, and exactly the lines answered by ok are done.
    """
    random = Random(seed)
    machine = Machine().ready()
    data = b"".join(FLOOD)
    said = []
    while data:
        count = random.choice((1, 14, 64, 128, 4096))
        machine.put(data[:count])
        data = data[count:]
        said += machine.cycles(random.between(0, 1))
    while len(answers(said)) < len(FLOOD):
        said += machine.cycles()
    assert set(said) <= set(("ok", "error:11")), said
    machine.settle()
    tenths = 0
    for number in range(len(FLOOD)):
        if said[number] == "ok":
            tenths += number % 2 * 10 + number % 10
    assert machine.controller.position() == [32 * tenths, 0, 0]
    assert machine.cycles(20) == [] and machine.ask("G4P0") == ["ok"]


def check_comments_and_blanks_do_not_count(first, second, third, size):
    """Comments and blanks of any length, in pieces of any size; a line that is too long without them is refused."""
    machine = Machine().ready()
    good = b"G0" + b" " * first + b"X1(" + b"a" * second + b")Y2;(" + b"b" * third
    bad = b"(" + b"c" * second + b")G0X9" + b" " * first + b"." + b"0" * 80 + b"(" + b"d" * third
    for line, answer in ((good, "ok"), (bad, "error:11"), (b"(" * (1 + second), "ok"), (b"G0Z-1", "ok")):
        data = line + b"\n"
        said = []
        while data:
            machine.put(data[:size])
            data = data[size:]
            said += machine.cycles()
        assert answers(said + machine.cycles(2)) == [answer], line
    machine.settle()
    assert machine.controller.position() == [320, 640, -400]


def check_lines_too_long():
    machine = Machine().ready()
    assert machine.ask("G0X1" + "0" * 76) == ["error:2"]
    assert machine.ask("G0X1." + "0" * 76) == ["error:11"]
    assert machine.ask("G0 X1 " + " " * 60 + "(a comment)" + " " * 60) == ["ok"]
    assert machine.ask("G0X1" + " " * 300) == ["ok"] and machine.ask("G0X1;" + "c" * 300) == ["ok"]
    machine.settle()
    assert machine.controller.position() == [320, 0, 0]


def check_two_links_share_the_machine():
    machine = Machine().ready()
    serial = machine.port.lines["serial"]
    machine.do("G10 L2 P1 X1", "G0 X5")
    machine.settle()
    serial.outgoing = b""
    serial.incoming += b"G91 G0 X1\n$LINK=0\nG91 G0 X1\n"
    machine.cycles(1)
    machine.settle()
    assert serial.outgoing == b"error:112\r\n[MSG:Command handed over]\r\nok\r\nok\r\n"
    assert machine.controller.position() == [7 * 320, 0, 0]
    machine.do("$LINK=1", "G0 X0")
    machine.settle()
    assert machine.controller.position() == [320, 0, 0]
    machine.put(b"\x18")
    machine.cycles(2)
    assert b"Grbl 1.1h" in serial.outgoing

"""The plotter's language: every packet of the documents, and every single fault on the wire."""

from passo import error_texts, errors
from passo.commands import (
    ACCEPTED, BAD, DRAW, FINISHED, HAND_OVER, HELLO, HOME, JOG, POINT, REFUSED, SPEED, STATUS, STOP, Command, Event,
)
from passo.protocols.plotter import host as plotter
from passo.protocols.plotter.host import ANSWERS, COMMANDS, PACKET, Plotter, packet, status_bytes, status_from

GAP_MS = 5
COORDINATE = 65535
KNOWN = tuple(sorted([code for name, code in COMMANDS.items() if name != "WORDS"]))  # which only boards with jobs or a journal know
CASES = {
    "check_every_packet_in_any_chunks": (
        ("points", "list", 12, ("pen", 0, 1), ("x", 0, COORDINATE), ("y", 0, COORDINATE)), ("chunk", 1, 17),
    ),
    "check_two_faults_are_not_passed_over": (
        ("code", "choice") + KNOWN,
        ("x", 0, COORDINATE), ("y", 0, COORDINATE), ("lost", 0, 5), ("doubled", 0, 4),
    ),
    "check_single_faults": (
        ("code", "choice") + KNOWN,
        ("x", 0, COORDINATE), ("y", 0, COORDINATE), ("flip", 1, 255),
    ),
    "check_noise": (("noise", "bytes", 40), ("x", 0, COORDINATE), ("y", 0, COORDINATE)),
    "check_status": (
        ("state", "choice") + plotter.STATES,
        ("error", 0, 255), ("x", -9, 70000), ("y", 0, COORDINATE), ("drawn", 0, COORDINATE), ("free", 0, 100_000),
    ),
}
RUNS = {"check_single_faults": 60}
EXAMPLES = {"check_two_faults_are_not_passed_over": ((COMMANDS["MOVE"], 0, 0, 0, 4),)}  # good by its sum, unknown

LOGGED = (
    ("MOVE", 366, 202, "6d 01 6e 00 ca a6"),
    ("LINE", 366, 360, "6c 01 6e 01 68 44"),
    ("LINE", 508, 360, "6c 01 fc 01 68 d2"),
    ("LINE", 508, 202, "6c 01 fc 00 ca 33"),
    ("LINE", 366, 202, "6c 01 6e 00 ca a5"),
    ("SPEED", 1000, 0, "73 03 e8 00 00 5e"),
    ("ORIGIN", 0, 0, "6f 00 00 00 00 6f"),
    ("REQUEST", 0, 0, "72 00 00 00 00 72"),
    ("MOVE", 644, 314, "6d 02 84 01 3a 2e"),
    ("LINE", 644, 454, "6c 02 84 01 c6 b9"),
    ("LINE", 884, 454, "6c 03 74 01 c6 aa"),
    ("LINE", 884, 314, "6c 03 74 01 3a 1e"),
    ("LINE", 644, 314, "6c 02 84 01 3a 2d"),
    ("END", 0, 0, "65 00 00 00 00 65"),
)


def check_packets_of_the_log():
    for name, x, y, text in LOGGED:
        assert packet(COMMANDS[name], x, y) == bytes([int(byte, 16) for byte in text.split()])


def feed_all(language, data, now_ms):
    """Everything `data` means once the line has been quiet for longer than any time-out."""
    commands = list(language.feed(data, now_ms))
    for wait in (GAP_MS + 1, plotter.RESYNC_MS + GAP_MS + 2):
        commands += language.feed(b"", now_ms + wait)
    return commands


def meaning(command):
    return command.kind, command.target, command.value, command.tool, command.error


def check_every_command():
    kinds = {
        "REQUEST": HELLO, "LINE": POINT, "MOVE": POINT, "END": DRAW, "ORIGIN": HOME, "SPEED": SPEED, "UP": JOG,
        "LEFT": JOG, "DOWN": JOG, "RIGHT": JOG, "STOP": STOP, "STATUS": STATUS, "LINK": HAND_OVER,
    }
    for name, code in COMMANDS.items():
        commands = feed_all(Plotter(GAP_MS), packet(code, 300, 7), 0)
        assert [command.kind for command in commands] == [kinds.get(name, BAD)]  # WORDS: of boards with jobs or a journal


def check_jog_directions():
    for up, wanted in (((0, 1), ((0, 1), (0, -1), (-1, 0), (1, 0))), ((-1, 0), ((-1, 0), (1, 0), (0, -1), (0, 1)))):
        language = Plotter(GAP_MS, up)
        for name, target in zip(("UP", "DOWN", "LEFT", "RIGHT"), wanted):
            assert feed_all(language, packet(COMMANDS[name]), 0)[0].target == target


def check_every_answer():
    def answer(kind, command, event=ACCEPTED):
        return Plotter().reply(Event(event, Command(command)))

    assert answer(ACCEPTED, HELLO) == b"k"
    assert answer(ACCEPTED, POINT) == b"n"
    assert answer(ACCEPTED, JOG) == b"n"
    assert answer(ACCEPTED, SPEED) == b"s"
    assert answer(ACCEPTED, HAND_OVER) == b"t"
    assert answer(FINISHED, HOME, FINISHED) == b"o"
    assert answer(FINISHED, DRAW, FINISHED) == b"d"
    assert answer(FINISHED, STOP, FINISHED) == b"d"
    for kind in (HELLO, POINT, JOG, SPEED, HOME, DRAW):
        assert answer(REFUSED, kind, REFUSED) == b""
    for error in (errors.CHECKSUM, errors.BYTES_DROPPED, errors.UNKNOWN_COMMAND):
        assert Plotter().reply(Event(REFUSED, Command(BAD, error=error), error)) == b"r"
    assert Plotter().reply(Event(REFUSED, Command(BAD, error=errors.STOPPED), errors.STOPPED)) == b""
    assert sorted(ANSWERS) == sorted([ord(letter) for letter in "kndosrt"])


def check_every_packet_in_any_chunks(points, chunk):
    """Packets one behind the other, cut anywhere, are all understood, in order."""
    names = ("MOVE", "LINE")
    data = b"".join([packet(COMMANDS[names[pen]], x, y) for pen, x, y in points])
    language = Plotter(GAP_MS)
    commands = []
    now_ms = 0
    for at in range(0, len(data), chunk):
        now_ms += 1
        commands += language.feed(data[at : at + chunk], now_ms)
        now_ms += GAP_MS
        commands += language.feed(b"", now_ms)
    good = [(command.target, command.tool) for command in commands if command.kind == POINT]
    resent = [command for command in commands if command.kind == BAD]
    if not resent:
        assert good == [((x, y), bool(pen)) for pen, x, y in points]
    # A host that sends without waiting can meet bytes that read two ways; they are asked for again, never guessed.
    for place in good:
        assert place in [((x, y), bool(pen)) for pen, x, y in points]


def faults(data, flip):
    """`data` with each single byte lost, doubled or flipped."""
    for at in range(len(data)):
        yield data[:at] + data[at + 1 :]
        yield data[: at + 1] + data[at:]
        yield data[:at] + bytes((data[at] ^ flip,)) + data[at + 1 :]


def check_single_faults(code, x, y, flip):
    """After one fault the packet is understood as it was meant or asked for again, never both; sent again it is understood."""
    data = packet(code, x, y)
    language = Plotter(GAP_MS)
    wanted = meaning(feed_all(language, data, 0)[0])
    now_ms = 10_000
    for damaged in faults(data, flip):
        for arrives in (len(damaged), PACKET):  # all at once, or the rest a moment later
            commands = list(language.feed(damaged[:arrives], now_ms))
            commands += language.feed(damaged[arrives:], now_ms + 1)
            commands += language.feed(b"", now_ms + 2 + GAP_MS)
            commands += language.feed(b"", now_ms + 2 + GAP_MS + plotter.RESYNC_MS)
            asked = [command for command in commands if language.reply(Event(REFUSED, command)) == b"r"]
            good = [meaning(command) for command in commands if command not in asked]
            assert good in ([], [wanted]) and len(asked) + len(good) == 1
            if not good:
                assert [meaning(command) for command in feed_all(language, data, now_ms + 5000)] == [wanted]
            now_ms += 20_000


def check_two_faults_are_not_passed_over(code, x, y, lost, doubled):
    """A byte lost and one doubled: the packet is understood, or asked for again once as soon as the line is quiet; never
    silence, also where the sum is good by chance."""
    data = packet(code, x, y)
    data = data[:lost] + data[lost + 1 :]
    data = data[:doubled] + data[doubled:][:1] + data[doubled:]
    language = Plotter(GAP_MS)
    commands = list(language.feed(data, 0)) + list(language.feed(b"", GAP_MS)) + list(language.feed(b"", 2 * GAP_MS))
    assert len(commands) == 1
    if commands[0].kind == BAD:
        assert language.reply(Event(REFUSED, commands[0], commands[0].error)) == b"r"
    assert list(language.feed(packet(COMMANDS["REQUEST"]), 60_000)) or list(language.feed(b"", 60_100))


def check_noise(noise, x, y):
    """Whatever came before, the line quiet for two seconds, the next good packet is understood."""
    language = Plotter(GAP_MS)
    feed_all(language, noise, 0)
    commands = feed_all(language, packet(COMMANDS["LINE"], x, y), 60_000)
    assert [meaning(command) for command in commands] == [(POINT, (x, y), 0, True, 0)]


def check_two_second_rule():
    language = Plotter(GAP_MS)
    torn = packet(COMMANDS["LINE"], 1, 2)[:4]
    assert list(language.feed(torn, 100)) == []
    assert list(language.feed(b"", 100 + plotter.RESYNC_MS - 1)) == []
    commands = list(language.feed(b"", 100 + plotter.RESYNC_MS))
    assert [(command.kind, command.error) for command in commands] == [(BAD, errors.BYTES_DROPPED)]
    assert list(language.feed(b"", 100 + 3 * plotter.RESYNC_MS)) == []


def check_status(state, error, x, y, drawn, free):
    report = {"state": state, "error": error, "position": [x, y], "drawn": drawn, "free": free}
    data = status_bytes(report)
    assert len(data) == plotter.STATUS_LENGTH
    fields = status_from(data)
    assert fields["state"] == state and fields["error"] == error and fields["y"] == y and fields["drawn"] == drawn
    assert fields["x"] == max(0, min(x, COORDINATE)) and fields["free"] == min(free, COORDINATE)
    for at in range(len(data)):
        broken = data[:at] + bytes((data[at] ^ 1,)) + data[at + 1 :]
        try:
            status_from(broken)
        except ValueError:
            continue
        raise AssertionError("accepted")


def check_error_table():
    for number in sorted(error_texts.TEXTS):
        assert 0 <= number <= 255 and len(error_texts.text(number)) > 5
    assert error_texts.text(999) == "error 999"

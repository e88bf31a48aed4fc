"""The torch manipulator's frames: byte for byte, torn, among noise; and what the machine makes of them."""

from free_machine import FreeMachine, Jogs
from passo import errors
from passo.commands import ACCEPTED, BAD, CONNECT, FINISHED, REFUSED, RESET, RUN, STATUS, STILL, STOP, UNLOCK, Event
from passo.options.independent.commands import AS_JOG, AT_REST, ZERO
from passo.protocols.torch import protocol as torch
from passo.protocols.torch.frames import QUESTIONS
from passo.protocols.torch.protocol import Torch

INTEGER = (-(1 << 31), (1 << 31) - 1)
CASES = {
    "check_move_round_trip": (
        ("x", 0, (1 << 29) - 2), ("x_speed",) + INTEGER, ("y", 0, (1 << 29) - 2), ("y_speed",) + INTEGER,
    ),
    "check_torn_frames": (("which", 0, 12), ("value",) + INTEGER, ("chunk", 1, 18)),
    "check_noise": (("noise", "bytes", 40), ("which", 0, 12)),
    "check_questions_of_other_languages": (("which", 0, 12),),
    "check_in_any_pieces": (("cuts", "list", 12, ("at", 0, 60)),),
    "check_moves": (
        ("moves", "list", 4, ("x", 0, 150), ("x_speed", 1, 8000), ("y", 0, 150), ("y_speed", 1, 8000), ("signs", 0, 3)),
    ),
    "check_a_button_held": (
        ("jog", 1, 1500), ("speed", 40, 9000), ("period_ms", 5, 200), ("held_ms", 0, 1500), ("ramps", 0, 1),
    ),
    "check_whole_jogs": (("times", 1, 255), ("jog", 1, 40)),
    "check_move_after_a_halt": (("ticks", 1, 2_500_000), ("x_speed", 1, 9000), ("y_speed", 1, 9000)),
}
RUNS = {"check_a_button_held": 40, "check_whole_jogs": 20, "check_moves": 25, "check_move_after_a_halt": 25}
EXAMPLES = {"check_a_button_held": ((83, 1240, 30, 1000, 0), (1000, 830, 30, 2000, 0))}
AHEAD_TICKS = 100 * 12_500  # the board file's default
GAP_MS = 5
LINK = {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "protocol": "torch", "idle_gap_ms": GAP_MS}


def hexed(data):
    return " ".join(["%02x" % byte for byte in data])


def frames():
    """One of each frame that a host may send."""
    names = ("CONNECT", "STOP", "DISCONNECT", "INFO", "ORIGIN", "JOG_X+", "JOG_X-", "JOG_Y+", "JOG_Y-")
    return [torch.frame(name) for name in names] + [
        torch.move(100, 480, 255, -830), torch.configure(48, 83, -480, 830), torch.frame("FINISHED"),
        torch.passo(torch.STATUS_OF),
    ]  # fmt: skip


def understood(protocol, data, now_ms):
    """The commands in `data`, and in a short silence behind it."""
    return list(protocol.feed(data, now_ms)) + list(protocol.feed(b"", now_ms + 2))


def machine(jog=None, planning=None, **changes):
    link = dict(LINK)
    link.update(changes)
    made = FreeMachine(links=[link], jog=jog or {}, planning=planning or {})
    made.poll(1_000_000)  # nothing is under way any more from the start
    return made


def check_frames_byte_for_byte():
    """As the table has them."""
    for name, code in (
        ("CONNECT", "ee"), ("STOP", "dd"), ("DISCONNECT", "cc"), ("INFO", "bb"), ("FINISHED", "aa"), ("ORIGIN", "88"),
        ("JOG_X+", "f9"), ("JOG_X-", "f7"), ("JOG_Y+", "f4"), ("JOG_Y-", "f1"),
    ):
        assert hexed(torch.frame(name)) == code + " ff"
    assert hexed(torch.move(100, 480, 70000, -830)) == "fe 00 00 00 64 00 00 01 e0 00 01 11 70 ff ff fc c2 ff"
    assert hexed(torch.configure(48, 83, 480, 830)) == "99 00 00 00 30 00 00 00 53 00 00 01 e0 00 00 03 3e ff"
    assert hexed(torch.answer("STOP", 12, -3)) == "dd 00 00 00 0c ff ff ff fd ff"
    assert hexed(torch.answer("INFO", -1, 256)) == "bb ff ff ff ff 00 00 01 00 ff"
    assert torch.answer_from(torch.answer("INFO", -1, 256)) == ("INFO", {"x": -1, "y": 256})
    assert torch.answer_from(b"\xaa\xff") == ("FINISHED", {})


def check_what_each_frame_asks():
    protocol = Torch(Jogs((48, 83), (480, 830)))
    kinds = []
    for data in frames():
        found = understood(protocol, data, 0)
        kinds += [command.kind for command in found]
        for command in found:
            protocol.reply(Event(REFUSED, command, errors.BUSY))
    assert kinds == [CONNECT, STOP, CONNECT, STATUS, ZERO, RUN, RUN, RUN, RUN, RUN, STILL, STATUS]
    for name, steps in (
        ("JOG_X+", [48, None]), ("JOG_X-", [-48, None]), ("JOG_Y+", [None, 83]), ("JOG_Y-", [None, -83]),
    ):
        (command,) = understood(protocol, torch.frame(name), 0)
        assert list(command.steps) == steps and command.when == AS_JOG and command.rates == [(480, 1000), (830, 1000)]
    found = understood(protocol, torch.frame("CONNECT") + torch.frame("DISCONNECT"), 0)
    assert [command.value for command in found] == [1, 0]
    for value, kind in ((1, RESET), (0, UNLOCK)):
        assert protocol.feed(torch.passo(torch.UNLOCK_OF, value), 0)[0].kind == kind
    assert protocol.feed(b"\x77?\x00\x00\xff", 0)[0].kind == BAD


def check_move_round_trip(x, x_speed, y, y_speed):
    """Counts are unsigned, speeds signed: the speed's sign is the direction. 0xFF may stand anywhere in the body."""
    protocol = Torch(Jogs((1, 1), (1, 1)))
    (command,) = protocol.feed(torch.move(x, x_speed, y, y_speed), 0)
    assert command.when == AT_REST
    for steps, rate, count, speed in zip(command.steps, command.rates, (x, y), (x_speed, y_speed)):
        assert (steps or 0) == (count if speed > 0 else -count) and rate == (abs(speed), 1000)


def check_counts_out_of_reach():
    protocol = Torch(Jogs((1, 1), (1, 1)))
    for count in ((1 << 29) - 1, 1 << 29, (1 << 32) - 1):
        assert protocol.feed(torch.move(count, 100, 0, 0), 0)[0].kind == BAD
        assert protocol.feed(torch.configure(count, 1, 1, 1), 0)[0].kind == BAD


def configured(protocol):
    """The jogs that `protocol` would ask for: of X and Y, steps and rate."""
    jogs = [understood(protocol, torch.frame(name), 9000)[0] for name in ("JOG_X+", "JOG_Y+")]
    return jogs[0].steps[0], jogs[1].steps[1], jogs[0].rates[0][0], jogs[1].rates[1][0]


def check_both_lengths_of_configure():
    """18 bytes at once; 14 when the line stays silent behind them; a refused one changes nothing."""
    for data, wait_ms, wanted in (
        (torch.configure(300, 400, 500, -255), 0, (300, 400, 500, 255)),
        (torch.frame("CONFIGURE", torch.integers(300, 500, -1)), GAP_MS, (300, 300, 500, 1)),
    ):
        for taken in (ACCEPTED, REFUSED):
            protocol = Torch(Jogs((48, 83), (480, 830)), GAP_MS)
            found = protocol.feed(data[:14], 0)
            assert found == [] and protocol.feed(b"", GAP_MS - 1) == []
            found = protocol.feed(data[14:], GAP_MS - 1) + (protocol.feed(b"", 2 * GAP_MS) if wait_ms else [])
            assert [command.kind for command in found] == [STILL]
            protocol.reply(Event(taken, found[0], errors.BUSY))
            assert configured(protocol) == (wanted if taken == ACCEPTED else (48, 83, 480, 830))


def check_frames_behind_configure_wait_for_it():
    """A jog right behind a configuration already has its steps."""
    protocol = Torch(Jogs((48, 83), (480, 830)), GAP_MS)
    (asked,) = protocol.feed(torch.configure(7, 8, 9, 10) + torch.frame("JOG_X+"), 0)
    assert protocol.feed(b"", 100) == []
    protocol.reply(Event(ACCEPTED, asked))
    (jog,) = protocol.feed(b"", 101)
    assert jog.steps == [7, None] and jog.rates[0] == (9, 1000)


def check_torn_frames(which, value, chunk):
    """Torn at every byte: nothing but a numbered error, and the next good frame works."""
    data = frames()[which]
    if which == 9:
        data = torch.move(abs(value) & 0xFFFFFF, value, 255, value)
    for cut in range(1, len(data)):
        for start, end in ((0, cut), (cut, len(data))):
            if start and torn_is_whole(data[start:end]):
                continue
            protocol = Torch(Jogs((48, 83), (480, 830)), GAP_MS)
            found = []
            for at in range(start, end, chunk):
                found += protocol.feed(data[at : min(at + chunk, end)], 0)
            found += protocol.feed(b"", GAP_MS)
            kinds = [command.kind for command in found]
            assert kinds[-1] == BAD and found[-1].error == errors.GARBLED
            assert not [kind for kind in kinds if kind not in (BAD, STATUS, STOP)]
            assert start or kinds == [BAD]
            assert jogged(protocol, 2 * GAP_MS)
            assert protocol.feed(b"", 9 * GAP_MS) == []


def jogged(protocol, now_ms):
    """A jog, as far as the language goes: believed when the line is silent behind it, or another frame follows."""
    data = torch.frame("JOG_X+")
    found = protocol.feed(data, now_ms)
    assert found == [] and protocol.feed(b"", now_ms + 1) == []
    found = protocol.feed(b"", now_ms + 2)
    return [command.kind for command in found] == [RUN]


def torn_is_whole(data):
    """True where what is left of a frame is a frame by itself: no receiver can tell."""
    lengths = {len(frame): 1 for frame in frames()}
    return data[-1] == 0xFF and data[0] in torch.CODES.values() and (len(data) in lengths or len(data) == 14)


def check_a_torn_frame_is_forgotten_without_a_look_in_between():
    protocol = Torch(Jogs((48, 83), (480, 830)), GAP_MS)
    assert not protocol.feed(torch.move(1, 2, 3, 4)[:9], 0)
    (good,) = protocol.feed(torch.frame("INFO"), 1000)
    assert good.kind == STATUS


def check_questions_of_other_languages(which):
    """`?` alone, as passo status asks, is no noise: nothing is logged. Behind a frame's beginning it is."""
    for question in QUESTIONS:
        for pieces in ((question,), tuple([question[at : at + 1] for at in range(len(question))])):
            protocol = Torch(Jogs((48, 83), (480, 830)), GAP_MS)
            found = []
            for piece in pieces:
                found += protocol.feed(piece, 0)
            assert found + protocol.feed(b"", GAP_MS) == []
            assert understood(protocol, frames()[which], GAP_MS) is not None
        protocol = Torch(Jogs((48, 83), (480, 830)), GAP_MS)
        found = protocol.feed(question + b"?", 0) + protocol.feed(b"", GAP_MS)
        assert [command.kind for command in found] == [BAD]


def check_noise(noise, which):
    """Noise that is no frame between two silences asks for nothing; the frame behind it works."""
    at = 0
    while at < len(noise):  # cut whole frames out of it
        if torn_is_whole(noise[at : at + 2]) or torn_is_whole(noise[at : at + 5]) or torn_is_whole(noise[at : at + 14]):
            noise = noise[:at] + b"\x00" + noise[at + 1 :]
        if torn_is_whole(noise[at : at + 18]):
            noise = noise[:at] + b"\x00" + noise[at + 1 :]
        at += 1
    protocol = Torch(Jogs((48, 83), (480, 830)), GAP_MS)
    found = protocol.feed(noise, 0) + protocol.feed(b"", GAP_MS)
    assert [command.kind for command in found] == ([BAD] if noise and bytes(noise) not in QUESTIONS else [])
    data = frames()[which]
    found = understood(protocol, data, GAP_MS)
    assert len(found) == (0 if data[0] == 0xAA else 1) and not [command for command in found if command.kind == BAD]


def check_in_any_pieces(cuts):
    """However a stream of good frames is cut up, without silences, it asks for the same."""
    data = b"".join([frame for frame in frames() if frame[0] != 0x99])
    whole = [command.kind for command in understood(Torch(Jogs((48, 83), (480, 830))), data, 0)]
    protocol = Torch(Jogs((48, 83), (480, 830)))
    found = []
    before = 0
    for cut in sorted(cuts) + [len(data)]:
        found += protocol.feed(data[before:cut], 0)
        before = max(cut, before)
    found += protocol.feed(b"", 2)
    assert [command.kind for command in found] == whole


def check_moves(moves):
    """Each goes on from where the one before ended; INFO tells of the last one; the machine says so when it is asked to."""
    board = machine(tell_end=True)
    place = [0, 0]
    for x, x_speed, y, y_speed, signs in moves:
        speeds = [-speed if signs >> axis & 1 else speed for axis, speed in enumerate((x_speed * 10, y_speed * 10))]
        board.send(torch.move(x, speeds[0], y, speeds[1]))
        board.cycle()
        if max(speeds) > 48_000 or min(speeds) < -48_000:
            if (abs(speeds[0]) > 48_000 and x) or (abs(speeds[1]) > 83_000 and y):
                assert not board.controller.busy()
                assert board.controller.machine.log.last == errors.SPEED_RANGE and board.take() == b""
                continue
        board.settle()
        board.cycle()
        made = [count if speed > 0 else -count for count, speed in zip((x, y), speeds)]
        place = [at + by for at, by in zip(place, made)]
        assert board.take() == torch.frame("FINISHED")
        assert board.made() == place == board.controller.position()
        board.send(torch.frame("INFO"))
        board.cycle()
        assert board.take() == torch.answer("INFO", *made)


def check_move_after_a_halt(ticks, x_speed, y_speed):
    """STOP answers with the steps made; the next move goes on from there, without a jump."""
    board = machine()
    board.send(torch.move(5000, x_speed, 5000, -y_speed))
    board.poll(ticks)
    board.send(torch.frame("STOP"))
    before = board.made()
    board.cycle()
    after = board.made()
    assert after == before
    assert board.take() == torch.answer("STOP", *after)
    board.send(torch.move(20, 1000, 30, 2000))
    board.settle()
    assert board.made() == [after[0] + 20, after[1] + 30]
    assert board.take() == b""


def check_jogs_held():
    """A jog that is repeated is one motion without a gap; anything else that comes meanwhile is dropped and counted."""
    board = machine()
    for repeat in range(30):
        board.send(torch.frame("JOG_Y+"))
        board.poll(600_000)
        if repeat == 5:
            others = [frame for frame in frames() if frame[0] not in (0xBB, 0xDD, 0xAA, 0x77, 0xF4)]
            for other in others:
                board.send(other)
                board.poll(10_000)
            board.send(torch.passo(torch.STATUS_OF))
            board.poll(100_000)
            told = torch.answer_from(board.take())[1]
            assert told["dropped"] == len(others) and told["error"] == errors.BUSY and told["state"] == "jog"
    board.settle()
    ticks = [tick for tick, step in board.steps[1]]
    assert board.made() == [0, len(ticks)] and 30 * 600_000 - 600_000 < ticks[-1] - ticks[0] < 31 * 600_000 + AHEAD_TICKS
    gaps = [after - before for before, after in zip(ticks, ticks[1:])]
    assert max(gaps) - min(gaps) <= 1 and abs(gaps[0] - 12_500_000 / 480) <= 1
    assert board.take() == b""


def check_a_button_held(jog, speed, period_ms, held_ms, ramps):
    """From the last frame on the axis goes on for the board file's time at most, or to the end of the first jog, which is
    whole; up to there it runs without a gap, and no frame is counted as dropped."""
    board = machine(planning={"independent_ramps": bool(ramps)})
    board.send(torch.configure(jog, jog, speed, speed))
    board.poll(200_000)
    begun = board.port.now
    last = 0
    while last <= held_ms:
        board.send(torch.frame("JOG_X-"))
        before = -board.made()[0]
        frame = board.port.now
        board.poll(period_ms * 12_500)
        last += period_ms
    board.settle()
    made = -board.made()[0]
    assert made >= jog and [step for _, step in board.steps[0]] == made * [-1]
    most = speed * AHEAD_TICKS // 12_500_000
    # Frames of two bytes are believed after two silent milliseconds, and looked at once in 8.
    # Each frame's motion is still under way when the next one comes.
    goes_on = min(jog * 1000 // speed, 100 - 1000 // speed) > period_ms + 15
    assert made <= max(jog, before + (most if goes_on else max(most, jog)) + speed * 12 // 1000 + 2)
    ticks = [tick for tick, _ in board.steps[0]]
    gaps = [after - at for at, after in zip(ticks, ticks[1:])]
    if goes_on and not ramps:
        assert not gaps or max(gaps) <= 12_500_000 // speed + 1
        assert ticks[-1] >= frame or made == jog
    board.send(torch.passo(torch.STATUS_OF))
    board.cycle()
    assert torch.answer_from(board.take())[1]["dropped"] == 0
    assert begun <= ticks[0]


def check_whole_jogs(times, jog):
    """PASSO's jogs are `times` whole ones, as one; also the longest that fits, and none if it does not fit."""
    board = machine()
    board.send(torch.configure(jog, jog, 4000, 4000) + torch.passo(torch.CODES["JOG_Y-"], times))
    board.poll(200_000)
    board.settle()
    assert board.made() == [0, -times * jog]
    gaps = [after[0] - at[0] for at, after in zip(board.steps[1], board.steps[1][1:])]
    assert not gaps or max(gaps) <= 12_500_000 // 4000 + 1
    board.send(torch.configure((1 << 29) - 2, 1, 4000, 4000) + torch.passo(torch.CODES["JOG_X+"], 2))
    board.poll(200_000)
    assert board.made()[0] == 0 and board.controller.machine.log.last == errors.TRAVEL


def check_the_time_ahead_is_the_board_files():
    for ahead_ms in (20, 500):
        board = machine(jog={"ahead_ms": ahead_ms})
        board.send(torch.configure(50, 50, 1000, 1000))
        board.poll(200_000)
        for _ in range(40):
            board.send(torch.frame("JOG_X+"))
            board.poll(15 * 12_500)
        before = board.made()[0]
        board.settle()
        over = board.made()[0] - before
        assert ahead_ms - 27 <= over <= max(ahead_ms, 50), over


def check_configured_jogs_and_origin():
    board = machine()
    board.send(torch.configure(31, 41, 3000, 4000) + torch.frame("JOG_X-"))
    board.poll(100_000)
    board.settle()
    assert board.made() == [-31, 0]
    board.send(torch.frame("ORIGIN") + torch.frame("INFO"))
    board.cycle()
    assert board.take() == torch.answer("INFO", -31, 0)
    assert board.controller.position() == [0, 0]
    board.send(torch.frame("JOG_Y-"))
    board.poll(100_000)
    board.settle()
    assert board.controller.position() == [0, -41] and board.made() == [-31, -41]
    board.send(torch.frame("INFO"))
    board.cycle()
    assert board.take() == torch.answer("INFO", 0, -41)


def check_relays():
    """Break before make; the motors are the other controller's at the start, on a fault and at the end."""
    board = FreeMachine(
        links=[LINK], changeover_ms=30,
        outputs=[
            {"name": "relay", "pin": 20, "role": "ours"}, {"name": "theirs", "pin": 21, "role": "theirs"},
            {"name": "other", "pin": 22},
        ],
    )  # fmt: skip
    board.poll(1_500_000)
    ticks_ms = 12_500

    def switched():
        log = [entry for entry in board.world.outputs if entry[1] in ("relay", "theirs")]
        board.world.outputs = []
        return log

    levels = {}
    for _, name, level in switched():
        levels[name] = level
    assert levels == {"relay": 0, "theirs": 1}
    for name, ours in (("CONNECT", 1), ("DISCONNECT", 0), ("CONNECT", 1)):
        asked = board.port.now
        board.send(torch.frame(name) + torch.move(3, 480, 0, 0))
        board.settle()
        board.poll(1_500_000)
        log = switched()
        on = [entry for entry in log if entry[2]]
        off = [entry for entry in log if not entry[2]]
        assert [entry[1] for entry in on] == ["relay" if ours else "theirs"]
        assert off[-1][0] + 30 * ticks_ms <= on[0][0]
        steps = [tick for tick, _ in board.steps[0] if tick >= asked]
        assert len(steps) == (3 if ours else 0)
        assert not ours or steps[0] >= on[0][0] + 30 * ticks_ms
        assert ours or board.controller.machine.log.last == errors.NO_MOTORS
    board.send(torch.move(5000, 480, 0, 0))
    board.poll(1_000_000)
    board.controller.machine.raise_alarm(errors.ALARM_HARD_LIMIT, "test")
    assert switched()[0][1:] == ("relay", 0)
    made = board.made()
    board.send(torch.frame("CONNECT") + torch.move(10, 480, 10, 480) + torch.frame("JOG_X+"))
    board.poll(2_000_000)
    assert board.made() == made and ("relay", 1) not in [entry[1:] for entry in switched()]
    board.send(torch.passo(torch.STATUS_OF))
    board.cycle()
    told = torch.answer_from(board.take())[1]
    assert told["state"] == "alarm" and not told["ours"]
    board.send(torch.passo(torch.UNLOCK_OF, 1) + torch.passo(torch.UNLOCK_OF) + torch.frame("CONNECT"))
    board.poll(2_000_000)
    assert board.controller.state == "idle" and ("relay", 1) in [entry[1:] for entry in switched()]
    board.app.stop()
    assert ("relay", 0) in [entry[1:] for entry in switched()]


def check_the_log():
    """The newest entry first, one a question; zeros behind the last."""
    board = machine()

    def asked(back):
        board.send(torch.passo(torch.LOG_OF, back))
        board.cycle()
        return torch.answer_from(board.take())

    assert asked(0) == ("LOG", {"number": 0, "older": 0, "ms": 0, "who": ""})
    begun = board.port.machine_ms()
    board.send(torch.move(5, 0, 5, 480))
    board.cycle()
    board.controller.machine.raise_alarm(errors.ALARM_HARD_LIMIT, "emergency stop")
    name, newest = asked(0)
    assert name == "LOG" and begun <= newest["ms"] <= board.port.machine_ms()
    assert (newest["number"], newest["older"], newest["who"]) == (errors.ALARM_HARD_LIMIT, 1, "emergenc")
    assert asked(1)[1]["number"] == errors.SPEED_RANGE and asked(1)[1]["who"] == "pc"
    assert asked(2)[1] == asked(255)[1] == {"number": 0, "older": 0, "ms": 0, "who": ""}
    board.send(torch.passo(torch.STATUS_OF))
    board.cycle()
    assert torch.answer_from(board.take())[1]["error"] == errors.ALARM_HARD_LIMIT  # reading the log takes nothing away


def check_another_link_is_silent_until_it_has_the_command():
    """Refused without a word, counted and logged; it may ask, and stop; PASSO LINK takes the command."""
    first = {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "protocol": "plotter"}
    second = dict(LINK)
    second.update({"name": "b", "port": "usb"})
    board = FreeMachine(links=[first, second])
    line = board.port.lines["b"]

    def says(data):
        line.incoming += data
        board.poll(200_000)
        said, line.outgoing = line.outgoing, b""
        return said

    assert says(torch.move(5, 480, 5, 480)) == b"" and board.made() == [0, 0]
    assert board.controller.machine.log.entries[-1][1:] == (errors.COMMANDED_ELSEWHERE, "b")
    assert says(torch.frame("INFO")) == torch.answer("INFO", 0, 0)
    assert says(torch.frame("STOP")) == torch.answer("STOP", 0, 0)
    assert torch.answer_from(says(torch.passo(torch.STATUS_OF)))[1]["dropped"] == 1
    assert says(torch.passo(torch.LINK_OF, 9)) == b""
    says(torch.passo(torch.LINK_OF))
    says(torch.move(5, 480, 5, 480))
    board.settle()
    assert board.made() == [5, 5]

"""The page served by the board itself: the whole firmware, real sockets, stepped time."""

from board_browser import PAGE, ServedRouter, masked, receive
from passo import errors
from passo.web.websocket import BINARY, CLOSE, PING, TEXT, Frames, accept_of, frame
from router import BOARD, World

MM = 320  # steps
SPEED = 3000
RAMP_MS = 220  # from 50 mm/s at 250 mm/s², and a segment
TICKS_PER_MS = 12_500
CASES = {
    "check_frames_in_any_pieces": (("sizes", "list", 6, ("size", 0, 400)), ("cut", 1, 60)),
    "check_frames_of_noise": (("noise", "bytes", 60),),
    "check_noise_on_a_socket": (("noise", "bytes", 200),),
    "check_a_jog_that_nobody_renews": (("late_ms", 201, 1200),),
}
RUNS = {"check_noise_on_a_socket": 6, "check_a_jog_that_nobody_renews": 2}


# --- frames


def check_the_handshake():
    """The example of RFC 6455, 1.3."""
    assert accept_of(b"dGhlIHNhbXBsZSBub25jZQ==") == b"s3pPLMBiTxaQ9kYGzzhZRbK+xOo="
    assert frame(TEXT, b"Hello") == b"\x81\x05Hello"
    assert Frames(5).feed(b"\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58\x81\x80abcd") == [(TEXT, b"Hello"), (TEXT, b"")]


def check_frames_in_any_pieces(sizes, cut):
    frames = Frames(400)
    texts = [bytes([(at * 7 + size) & 0xFF for at in range(size)]) for size in sizes]
    data = b"".join([masked(BINARY, text) for text in texts])
    found = []
    for start in range(0, len(data), cut):
        found += frames.feed(data[start : start + cut])
    assert found == [(BINARY, text) for text in texts]


def refused(data):
    try:
        Frames(300).feed(data)
    except ValueError:
        return True
    return False


def check_frames_of_noise(noise):
    try:
        for kind, data in Frames(300).feed(noise):
            assert kind in (TEXT, BINARY, CLOSE, PING, 10) and len(data) <= 300
    except ValueError:
        pass


def check_what_is_no_frame():
    assert refused(b"\x81\x05Hello"), "not masked"
    assert refused(b"\x01\x85"), "in pieces"
    assert refused(b"\x80\x85"), "the rest of one in pieces"
    assert refused(b"\xc1\x85") and refused(b"\x83\x85"), "unknown"
    assert refused(b"\x81\xff" + bytes(8)), "64 bits long"
    assert refused(b"\x81\xfe\x01\x2d"), "301 bytes"
    assert refused(b"\x89\xfe\x00\xff"), "a long ping"
    assert not refused(b"\x81\xfe\x01\x2c")


# --- the page


def check_orders_over_the_air():
    board = ServedRouter()
    page = board.page()
    assert page.hello["language"] == "grbl" and "jobs" not in page.hello["can"] and "jog" in page.hello["can"]
    page.until(lambda state: state["link"])
    before = list(board.world.place)
    for order in ("step", "give", "unlock", "jog", "home", "line"):
        answer = page.order(order, False, by={"x": 5}, way={"x": 1}, speed=SPEED, lease=1, beat=1, line="G0X5", to="page")
        assert answer["error"] == errors.NO_SESSION, order
    assert page.state["owner"] == "guest" and page.order("step", by={"x": 1}, speed=SPEED)["error"] == errors.COMMANDED_ELSEWHERE
    page = board.commanding()
    assert answers_of(board.ask("G0X1")) == ["error:%d" % errors.COMMANDED_ELSEWHERE], "the cable's line must be refused"
    assert page.order("step", by={"x": 5, "y": -2}, speed=SPEED)["error"] == 0
    page.until(lambda state: state["state"] == "Jog")
    page.until(lambda state: state["state"] == "Idle")
    assert list(board.world.place) == [before[0] + 5 * MM, before[1] - 2 * MM, before[2]]
    assert [round(mm * MM) for mm in page.state["m"]] == [5 * MM, -2 * MM, 0]
    assert page.order("give", to="guest")["error"] == 0
    assert answers_of(board.ask("G21")) == ["ok"], "it has the command back"
    for order in ("run", "teach", "job_part", "machine"):
        assert page.order(order, name="a", text="G0X1", what="begin", at=0)["error"] == errors.UNKNOWN_COMMAND, order
    assert page.order("jobs")["jobs"] == []


def answers_of(said):
    return [line for line in said if line == "ok" or line.startswith("error:")]


def check_the_tool_wants_somebody_there():
    """If the board file names an input for it: the spindle and a resume; switching off is always allowed."""
    world = World()
    world.switches["hand"] = 0
    inputs = BOARD["inputs"] + [{"name": "hand", "pin": 28, "active": 1}]
    board = ServedRouter(world=world, network={"host": "passo", "presence": "hand"}, inputs=inputs)
    page = board.commanding()

    def switch(name):
        """Return (the errors in the page's messages, the tool)"""
        error = page.order("output", name=name, rpm=1000)["error"]
        board.run_ms(1500)
        logs = [message["log"][-1] for message in page.told if message["t"] == "log"]
        page.told.clear()
        assert logs == [error] * bool(error), "the answer and the log of all pages must have the error"
        return logs, world.tool

    assert switch("spindle_cw") == ([errors.PRESENCE], 0)
    world.switches["hand"] = 1
    assert switch("spindle_cw") == ([], 1)
    world.switches["hand"] = 0
    board.run_ms(300)
    assert world.tool == 1, "letting go of the input must not stop the spindle"
    assert switch("spindle_off") == ([], 0)
    assert switch("spindle_ccw") == ([errors.PRESENCE], 0)


def check_five_states_a_second():
    """To each of two pages, while it moves; their places lie on the path made."""
    board = ServedRouter()
    page = board.commanding()
    other = board.page()
    page.order("step", by={"x": 40}, speed=1000)
    page.until(lambda state: state["state"] == "Jog")
    for each in (page, other):
        each.pushes.clear()
    board.run_ms(2000)
    for each in (page, other):
        assert 9 <= len(each.pushes) <= 11, len(each.pushes)
        way = [state["m"][0] for _, state in each.pushes]
        assert way == sorted(way) and way[-1] > way[0] + 20
    gaps = [after[0] - before[0] for before, after in zip(page.pushes, page.pushes[1:])]
    assert max(gaps) <= 260, gaps


def check_four_pages_and_no_more():
    """A fifth takes the place of one that has proven nothing; of none that has."""
    board = ServedRouter()
    first = board.commanding()
    looker = board.page()
    more = [board.page() for _ in range(3)]
    assert more[2].hello and first.alive and not looker.alive
    for page in more:
        assert page.order("log")["log"] == []
    fifth = board.page(None)
    board.run_ms(100)
    assert b" 503 " in fifth.head and not fifth.alive and [page.alive for page in [first] + more] == [True] * 4


def stopped_after(board, since):
    """Milliseconds from tick `since` to the last step."""
    steps = [row[0] for row in board.world.path if row[0] > since]
    return (steps[-1] - since) / TICKS_PER_MS if steps else 0


def hold_jog(board, page, lease, milliseconds):
    """Hold a jog of X for `milliseconds`, renewed each 60 ms. Returns the tick of the last renewal."""
    board.world.path = []
    page.begin("jog", lease=lease, beat=page.state["beat"], way={"x": 1}, speed=SPEED)
    for _ in range(milliseconds // 60):
        board.run_ms(60)
        page.begin("keep", lease=lease, beat=page.state["beat"])
    board.run_ms(5)
    wrong = [message for message in page.told if message.get("error")]
    assert not wrong, wrong
    return board.port.now


def check_a_jog_that_nobody_renews(late_ms):
    board = ServedRouter()
    page = board.commanding()
    since = hold_jog(board, page, 7, 900)
    assert board.world.place[0] > 3000 + 20 * MM
    board.run_ms(late_ms)
    assert page.order("keep", lease=7, beat=page.state["beat"])["error"] == errors.LEASE
    board.run_ms(800)
    assert stopped_after(board, since) <= 250 + RAMP_MS, stopped_after(board, since)
    stood = list(board.world.place)
    assert page.order("keep", lease=7, beat=page.state["beat"])["error"] == errors.LEASE
    assert page.order("jog", lease=7, beat=page.state["beat"], way={"x": 1}, speed=SPEED)["error"] == errors.LEASE
    board.run_ms(300)
    assert list(board.world.place) == stood


def check_a_jog_whose_page_goes():
    """Released, closed, or cut: it ends within 100 ms and its ramp."""
    for how in ("release", "close", "garbage"):
        board = ServedRouter()
        page = board.commanding()
        since = hold_jog(board, page, 1, 600)
        if how == "release":
            page.begin("release", lease=1)
        elif how == "close":
            page.wire.close()
            board.browsers.remove(page)
        else:
            page.send(b"\x00\x00\x00\x00")
        board.run_ms(1000)
        assert 0 < stopped_after(board, since) <= 100 + RAMP_MS, (how, stopped_after(board, since))
        assert board.controller.state == "idle", how


def check_stop_wants_no_key():
    for how in ("socket", "post"):
        board = ServedRouter()
        board.ready()
        stranger = board.page("A" * 16)
        board.do("G1 X60 F3000")
        board.run_ms(300)
        if how == "socket":
            stranger.say('{"do":"stop"}')
        else:
            assert b'"error": 0' in board.get("/stop", "POST")
        board.run_ms(100)
        stood = list(board.world.place)
        assert board.controller.machine.alarm and 3000 < stood[0] < 3000 + 60 * MM
        board.run_ms(300)
        assert list(board.world.place) == stood


def posted_stop(board, page):
    """A STOP as the page's script posts it: it names the page's newest order."""
    said = ("%s.%d" % (page.session.nonce, page.count)).encode()
    assert b'"error": 0' in board.get("/stop", "POST", more=b"Content-Length: %d\r\n" % len(said), body=said)


def check_a_stop_that_overtakes_orders():
    """Orders that were sent before a STOP do not move the machine after it: those still under way, and those that wait to be read."""
    step = {"do": "step", "by": {"x": 5}, "speed": SPEED}
    board = ServedRouter()
    page = board.commanding()
    before = list(board.world.place)
    late = [page.message(step) for _ in range(7)]
    posted_stop(board, page)
    for message in late:
        page.say(message)
    board.run_ms(500)
    assert [told["error"] for told in page.told if told["t"] == "answer"] == [errors.STOPPED] * 7 and page.alive
    assert list(board.world.place) == before
    for wrong in (b"", b".", b"x.1", page.session.nonce.encode() + b".", page.session.nonce.encode() + b".\xff", b"\xff" * 200):
        assert b'"error": 0' in board.get("/stop", "POST", more=b"Content-Length: %d\r\n" % len(wrong), body=wrong)
    assert page.order("step", by={"x": 5}, speed=SPEED)["error"] == 0, "the next order must be carried out"
    board.run_ms(1500)
    assert list(board.world.place) == [before[0] + 5 * MM] + before[1:]
    other = board.page()
    for each in (page, other):
        each.begin("step", by={"x": 5}, speed=SPEED)
    for _ in range(20):  # both wait behind each other
        board.server._server.poll(int(board.now_ms()))
    assert len(board.server._messages) == 2
    assert board.server._stop_machine(b"") and len(board.server._messages) == 3
    board.run_ms(500)
    assert [[told["error"] for told in each.told if told["t"] == "answer"][-1] for each in (page, other)] == [errors.STOPPED] * 2
    assert list(board.world.place) == [before[0] + 5 * MM] + before[1:]
    assert other.order("step", by={"x": -5}, speed=SPEED)["error"] == 0
    board.run_ms(1500)
    assert list(board.world.place) == before


def check_a_wrong_key():
    board = ServedRouter()
    page = board.page("A" * 16)
    before = list(board.world.place)
    for number in range(4):
        page.begin("step", by={"x": 5}, speed=SPEED)
        assert page.wait(lambda told: told["t"] == "answer")["error"] == errors.NO_SESSION, number
    page.begin("step", by={"x": 5}, speed=SPEED)
    board.run_ms(50)
    assert not page.alive, "after five of them it is closed"
    honest = board.commanding()
    message = honest.message({"do": "step", "by": {"x": 5}, "speed": SPEED})
    other = board.page()
    other.say(message)
    assert other.wait(lambda told: told["t"] == "answer")["error"] == errors.NO_SESSION
    honest.say(message)
    honest.say(message)
    board.run_ms(1500)
    assert [told["error"] for told in honest.told if told["t"] == "answer"] == [0, errors.NO_SESSION]
    assert list(board.world.place) == [before[0] + 5 * MM] + before[1:], "once"


def check_noise_on_a_socket(noise):
    board = ServedRouter()
    page = board.page()
    page.until(lambda state: state["link"])
    before = list(board.world.place)
    for data in (noise, masked(TEXT, noise[:125]), masked(TEXT, b"{" + noise[:100]), masked(TEXT, b'{"do":' + noise[:100] + b"}")):
        page.send(data)
        board.run_ms(20)
        if not page.alive:
            page = board.page()
    for text in ("[" * 900, '{1:2}', '{"do":{}}', '{"do":["stop"]}', '{"do":"look","every":[]}', '{"do":null}', "3", '"a"', '{"do":"keep","id":1e400}'):
        page.say(text)
        board.run_ms(20)
        if not page.alive:
            page = board.page()
    for order in ({"by": {1: 2}}, {"by": {"xx": 1}}, {"by": [1]}, {"by": {"x": None}}, {"by": {"x": 1e39}, "speed": 1e39}, {"by": "x"}):
        assert page.order("step", **order)["error"] == errors.ORDER_FIELD, order
    assert list(board.world.place) == before
    assert b"200 OK" in board.get("/")


def check_the_files():
    board = ServedRouter()
    with open(PAGE + "panel.js", "rb") as file:
        wanted = file.read()
    wires = [board.connect() for _ in range(6)]
    for wire in wires:
        wire.send(b"GET /panel.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    came = [b""] * 6
    for _ in range(1500):
        board.run_ms(1)
        came = [data + (receive(wire) or b"") for data, wire in zip(came, wires)]
    for data in came:
        head, _, body = data.partition(b"\r\n\r\n")
        assert b" 200 OK" in head and body == wanted
    for path in ("/../panel.js", "/wifi.json", "/..%2fapi.py", "//panel.js", "/page/panel.js", "/.", "/panel.js%00", "/panel.js.gz", "/api.py"):
        assert b" 404 " in board.get(path)[:40], path
    assert b" 403 " in board.get("/", host=b"evil.example")[:40]
    assert b" 405 " in board.get("/", "POST")[:40] and b" 404 " in board.get("/stop")[:40]
    upgrade = b"Upgrade: websocket\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
    assert b" 403 " in board.get("/ws", more=upgrade)[:40], "without an Origin"
    assert b" 403 " in board.get("/ws", more=upgrade + b"Origin: http://evil.example\r\n")[:40]
    assert b" 404 " in board.get("/ws", more=b"Origin: http://127.0.0.1\r\n")[:40], "no WebSocket"


def check_a_page_that_says_nothing_is_given_up():
    """A page that does not answer a ping loses its slot, and one that does not read, too."""
    board = ServedRouter()
    alive = board.page()
    dead = board.page()
    dead.ponging = False
    board.run_ms(9000)
    assert alive.alive and not dead.alive


# --- a sender by a WebSocket


def check_a_sender():
    """Proven lines, cut in any way, at /grbl; without the key only what asks or makes safe; one sender at a time."""
    board = ServedRouter()
    sender = board.sender()
    assert sender.said().find(b"[PASSO:") == 0
    assert answers(sender, b"$X\n", proven=False) == b"error:%d" % errors.NOT_ADMITTED
    sender.put(b"?")
    assert b"<" in sender.said()
    assert answers(sender, b"$LINK=0") == b"ok" and answers(sender, b"$X") == b"ok"
    before = list(board.world.place)
    assert answers(sender, b"G91 G1 X2 F3000", cut=7) == b"ok"
    board.settle()
    assert list(board.world.place) == [before[0] + 2 * MM] + before[1:]
    other = board.sender()
    board.run_ms(50)
    assert b" 503 " in other.head, "one that has proven the key keeps its place"
    sender.line(b"$J=G91X50F3000")
    board.run_ms(300)
    sender.wire.close()
    board.browsers.remove(sender)
    board.run_ms(600)
    assert board.controller.state == "idle" and board.world.place[0] < before[0] + 40 * MM, "its jog has ended with it"
    again = board.sender()
    assert again.said().find(b"[PASSO:") == 0


def answers(sender, line, proven=True, cut=1000):
    """Return the answer to a line."""
    sender.said()
    if proven:
        sender.line(line, cut)
    else:
        sender.put(line)
    found = b""
    for _ in range(100):
        found += sender.said()
        if b"ok" in found or b"error" in found:
            break
    return [each for each in found.split(b"\r\n") if each[:2] == b"ok" or each[:5] == b"error"][0]


def check_orders_that_a_reset_overtakes():
    """Orders that a page sent before a reset by the cable move nothing, and each has an answer."""
    board = ServedRouter()
    page = board.commanding()
    before = list(board.world.place)
    page.begin("step", by={"x": 5}, speed=SPEED, id=1001)
    page.begin("step", by={"y": 5}, speed=SPEED, id=1002)
    board.put(b"\x18")
    answers = [page.wait(lambda message: message.get("id") == number) for number in (1001, 1002)]
    assert None not in answers, answers
    board.run_ms(600)
    assert list(board.world.place) == before
    assert page.order("step", by={"x": 1}, speed=SPEED)["error"] == 0
    page.until(lambda state: state["state"] == "Jog")


def check_a_typed_line_is_answered_and_a_reset_told():
    """A row of lines goes by these: ok or error of each, and the note of a reset by another link."""
    board = ServedRouter()
    page = board.commanding()

    def told(text):
        return page.wait(lambda message: message["t"] == "said" and message["text"][: len(text)] == text)

    for line, answer in (("G21", "ok"), ("G91 X", "error:%d" % errors.NUMBER), ("$$", "$0="), ("?", "<"), ("G91 G1 X3 F600", "ok")):
        page.told.clear()
        page.order("line", line=line)
        assert told(answer), line
    page.told.clear()
    board.put(b"\x18")
    assert told("Grbl"), "by the cable"
    page.told.clear()
    page.order("unlock")
    page.order("stop")
    assert told("Grbl"), "by a page"


def check_each_order_of_a_router():
    """Zeros, places, overrides, settings, typed lines, hold and resume, homing: the next state shows each order's effect."""
    board = ServedRouter()
    page = board.commanding()

    def done(do, **fields):
        error = page.order(do, **fields)["error"]
        assert error == 0, (do, error)

    start = list(page.state["m"])
    done("zero", axes="xy")
    page.until(lambda state: state["w"][:2] == [0, 0] and state["m"] == start)
    done("goto", to={"x": 2.5, "y": -1}, speed=SPEED)
    page.until(lambda state: state["state"] == "Idle" and state["w"][:2] == [2.5, -1])
    assert board.world.place[0] == 3000 + 2.5 * MM
    for what, to, wanted in (("feed", "+10", [110, 100, 100]), ("rapid", "50", [110, 50, 100]), ("spindle", "-1", [110, 50, 99]), ("feed", "100", [100, 50, 99])):
        done("override", what=what, to=to)
        page.until(lambda state: state["ov"] == wanted)
    assert page.order("override", what="rapid", to="+10")["error"] == errors.NUMBER
    page.told.clear()
    done("set", number=110, value=4000)
    told = page.wait(lambda message: message["t"] == "settings")
    assert told["settings"]["110"] == page.order("settings")["settings"]["110"] == "4000.000", told
    done("line", line="G91 G1 X1 F600")
    page.until(lambda state: state["state"] == "Idle" and state["w"][0] == 3.5)
    assert page.order("line", line="G91 X")["error"] == errors.NUMBER, "not a line"
    done("line", line="$G")
    assert page.wait(lambda message: message["t"] == "said" and message["text"][:4] == "[GC:")
    done("step", by={"x": 20}, speed=SPEED)
    page.until(lambda state: state["state"] == "Jog")
    done("hold")
    page.until(lambda state: state["state"] == "Idle")
    done("line", line="G1 X20 F3000")
    page.until(lambda state: state["state"] == "Run" and state["feed"] > 2000 and state["line"] == 0)
    done("hold")
    page.until(lambda state: state["state"] == "Hold" and state["sub"] == "0")
    stood = list(board.world.place)
    assert page.order("step", by={"x": 1}, speed=SPEED)["error"], "amid a line"
    done("resume")
    page.until(lambda state: state["state"] == "Idle")
    assert board.world.place[0] > stood[0]
    done("line", line="G4 P0.5")
    page.until(lambda state: 0 < state["wait"] <= 0.5)
    page.until(lambda state: state["state"] == "Idle" and not state["wait"])
    done("home")
    page.until(lambda state: state["state"] == "Home")
    page.until(lambda state: state["state"] == "Idle")
    assert page.state["m"] == [0, 0, 0]


def check_an_alarm_that_only_a_reset_ends():
    """A limit: the page gets the alarm, and unlocks the machine, or homes it, by one order."""
    for order, behind in (("unlock", "Idle"), ("home", "Home")):
        board = ServedRouter()
        page = board.commanding()
        assert page.order("line", line="$21=1")["error"] == 0
        assert page.order("step", by={"x": 5}, speed=SPEED)["error"] == 0
        page.until(lambda state: state["state"] == "Jog")
        board.world.switches["limit_y"] = 1
        page.until(lambda state: state["state"] == "Alarm")
        assert page.state["alarm"] == errors.ALARM_HARD_LIMIT and page.order("log")["log"] == [errors.ALARM_HARD_LIMIT]
        del board.world.switches["limit_y"]
        assert page.order("step", by={"x": 5}, speed=SPEED)["error"] == errors.LOCKED
        assert page.order(order)["error"] == 0
        page.until(lambda state: state["state"] == behind)
        page.until(lambda state: state["state"] == "Idle" and state["alarm"] == 0)

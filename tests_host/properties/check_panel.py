"""The page's orders: the pages that may give them, the lease of a jog, and that no other message moves the machine."""

import os

from boards.router_3axis import BOARD
from check_jobs import folder
from draws import Random
from panel_desk import Desk
from passo import errors
from passo.options.jobs.errors import NO_JOB, STORED_NAME
from passo.protocols.page.jog import Limits
from passo.protocols.page.lease import FRESH_MS, LEASE_MS, Lease
from passo.protocols.page.orders import too_deep
from passo.records import TICKS_PER_MS
from passo.web.pace import Pace
from passo.web.session import Hmac, Session
from host_tools.clients.page_key import in_groups, make_key, read_key
from host_tools.page.teach import lines_of
from host_tools.clients.grbl_wire import PAGE, Wire, dwell_ms

SPEED = 3000
MM = 320  # steps
RAMP_MS = 220  # from 50 mm/s at 250 mm/s², and a segment
CASES = {
    "check_noise_moves_nothing": (("seed", "seed"),),
    "check_a_late_keep_revives_nothing": (("late_ms", 201, 2000),),
    "check_a_lease": (("events", "list", 30, ("what", 0, 3), ("number", 0, 4), ("wait_ms", 0, 260)),),
}
RUNS = {"check_noise_moves_nothing": 15, "check_a_late_keep_revives_nothing": 4, "check_a_lease": 60}
NOT_QUICK = ("check_a_target_beyond_the_travel", "check_directions_of_every_size", "check_the_line_beyond_the_travel")


def check_hmac_is_that_of_rfc_4231():
    assert Hmac(b"\x0b" * 20).hex_digest(b"Hi There") == "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7"
    assert Hmac(b"Jefe").hex_digest(b"what do ya want for nothing?") == "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843"
    assert Hmac(b"\xaa" * 131).hex_digest(b"Test Using Larger Than Block-Size Key - Hash Key First") == "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54"


def check_a_session():
    session = Session("KEY", "nonce")
    other = Session("KEY", "another")
    body = '{"do":"hold"}'
    message = "1.%s.%s" % (session.proof("1", body), body)
    assert other.open(message) is None, "the nonce of another connection"
    assert Session("YEK", "nonce").open(message) is None
    assert session.open(message.replace("hold", "home")) is None
    assert session.open(message.replace("1.", "2.", 1)) is None
    assert session.open(message) == body
    assert session.open(message) is None, "the same again"
    for torn in ("", ".", "..", "1", "x.y.z", message[:-1], "-1" + message[1:], "1" * 400 + ".a.b"):
        assert session.open(torn) is None
    assert session.open("12.%s.x" % session.proof("12", "x")) == "x"
    assert session.open("11.%s.x" % session.proof("11", "x")) is None, "an older one"


def check_keys():
    made = make_key(lambda count: bytes(range(100, 100 + count)))
    assert len(made) == 16 and read_key(" " + in_groups(made).lower()) == made
    assert in_groups("ABCDEFGH") == "ABCD-EFGH"


def check_a_lease(events):
    """Against a plain model: a lease is alive for LEASE_MS from its last renewal, and a number never lives twice."""
    lease = Lease()
    now = 0x1FFFFF00  # the clock runs over
    newest, until, used = 0, -1, 0
    at = 0
    for what, number, wait in events:
        at += wait
        now = (now + wait) & 0x1FFFFFFF
        lease.note_beat(at + 1, now)
        alive = newest and at <= until
        if not alive:
            newest = 0
        if what == 0:
            wanted = not alive and number > used
            assert lease.begin(number, at + 1, now) == wanted
            if wanted:
                newest, used, until = number, number, at + LEASE_MS
        elif what == 1:
            wanted = bool(alive and number == newest)
            assert lease.renew(number, at + 1, now) == wanted
            if wanted:
                until = at + LEASE_MS
        elif what == 2:
            lease.end()
            newest = 0
        else:
            assert bool(lease.is_alive(now)) == bool(alive)


def check_what_was_held_up_counts_for_nothing():
    lease = Lease()
    lease.note_beat(1, 1000)
    assert not lease.begin(1, 1, 1001 + FRESH_MS)
    lease.note_beat(2, 2000)
    assert not lease.begin(1, 2, 2000), "its number is used up"
    assert lease.begin(2, 2, 2000)
    assert not lease.renew(2, 1, 2100), "it has not seen the newest reports"


def check_a_page_is_told_as_often_as_it_asks():
    state = {"state": "Idle", "link": True, "alarm": 0, "owner": "page", "job": None, "m": [0.0]}
    pace = Pace()
    assert [pace.is_due(state, now) for now in range(0, 500, 50)] == [True] * 10
    for every, wanted in ((500, 4), (100, 20), (1000, 2), (0, 1)):
        assert pace.look({"do": "look", "every": every})["error"] == 0
        assert sum([pace.is_due(state, now & 0x1FFFFFFF) for now in range(0x1FFFFF00, 0x1FFFFF00 + 2000, 50)]) == wanted, every
    changed = dict(state)
    changed["alarm"] = 211
    assert pace.is_due(changed, 0) and not pace.is_due(changed, 50) and pace.is_due(state, 100), "a changed state must be due at once"
    for wrong in (-1, 0.5, True, None, "50", 10_001):
        assert pace.look({"do": "look", "every": wrong})["error"] == errors.ORDER_FIELD, wrong
    assert not pace.is_due(state, 150), "a wrong one changes nothing"


def stopped_after(desk, since):
    """Milliseconds from tick `since` to the last step."""
    steps = [row[0] for row in desk.board.world.path if row[0] > since]
    return (steps[-1] - since) / TICKS_PER_MS if steps else 0


def check_a_jog_ends_on_release():
    desk = Desk()
    desk.board.world.path = []
    desk.hold_jog(1, 900, way={"x": 1}, speed=SPEED)
    assert desk.machine.state["feed"] > SPEED * 0.98, "it reaches its speed"
    since = desk.board.port.now
    assert desk.order("release", lease=1) == 0
    desk.run_ms(1500)
    assert stopped_after(desk, since) <= 100 + RAMP_MS, stopped_after(desk, since)
    assert desk.machine.state["state"] == "Idle"
    before = desk.place()
    assert before[1:] == [2500, -1800] and before[0] > 3000 + 30 * MM
    assert desk.order("keep", lease=1, beat=desk.beats) == errors.LEASE
    assert desk.order("jog", lease=1, beat=desk.beats, way={"x": 1}, speed=SPEED) == errors.LEASE
    desk.run_ms(500)
    assert desk.place() == before


def check_a_late_keep_revives_nothing(late_ms):
    """If the page does not renew it, the jog ends within 250 ms and its ramp, and a late keep does not bring it back."""
    desk = Desk()
    desk.board.world.path = []
    desk.hold_jog(5, 600, way={"x": 1, "y": 1}, speed=SPEED)
    since = desk.board.port.now
    desk.run_ms(late_ms)
    assert desk.order("keep", lease=5, beat=desk.beats) == errors.LEASE
    desk.run_ms(800)
    assert stopped_after(desk, since) <= 250 + RAMP_MS, stopped_after(desk, since)
    before = desk.place()
    assert before[0] - 3000 == before[1] - 2500, "both axes alike"
    assert desk.order("keep", lease=5, beat=desk.beats) == errors.LEASE
    desk.run_ms(300)
    assert desk.place() == before


def check_a_dead_server_leaves_little():
    """With no program that feeds the board, not even to cancel, the queue has the path of a moment and of the braking."""
    desk = Desk()
    desk.board.world.path = []
    desk.hold_jog(1, 900, way={"x": -1}, speed=2000)
    since = desk.board.port.now
    while desk.board.port.now < since + 2000 * TICKS_PER_MS:
        desk.board.app.cycle()
    assert desk.board.controller.state == "idle"
    assert stopped_after(desk, since) <= 250 + RAMP_MS, stopped_after(desk, since)


def check_a_jog_ends_at_the_travel():
    desk = Desk()
    desk.board.do("$20=1")
    desk.run_ms(200)
    number = 1
    desk.order("home")
    desk.run_ms(200)
    desk.settle()
    assert desk.order("jog", lease=number, beat=desk.beats, way={"x": -1}, speed=SPEED) == 0
    desk.run_ms(150)
    desk.order("release")
    desk.settle()
    assert desk.machine.state["alarm"] == 0 and desk.machine.state["state"] == "Idle"


def check_without_the_key_only_stop():
    desk = Desk()
    before = desk.place()
    fields = {"by": {"x": 1}, "to": {"x": 1}, "way": {"x": 1}, "speed": 100, "lease": 1, "beat": desk.beats, "axes": "x",
              "name": "a", "line": "G0X1", "what": "begin", "number": 100, "value": 1, "at": 0, "text": "G0X1"}  # fmt: skip
    for name in sorted(desk.api._orders) + sorted(desk.machine.orders):
        assert desk.order(name, False, **fields) == errors.NO_SESSION, name
        desk.run_ms(20)
    assert desk.place() == before and desk.machine.state["state"] == "Idle"
    desk.order("step", by={"x": 20}, speed=SPEED)
    desk.run_ms(200)
    assert desk.order("stop", False) == 0
    desk.run_ms(60)
    stood = desk.place()
    desk.run_ms(500)
    assert desk.place() == stood and stood[0] < before[0] + 20 * MM


def check_stop_amid_a_jog():
    """The reset is the first byte sent: after a jog cancel it could find the machine at a stand, and raise no alarm."""
    desk = Desk()
    desk.hold_jog(1, 600, way={"x": 1}, speed=SPEED)
    said = []
    write = desk.machine.wire.write
    desk.machine.wire.write = lambda data: (said.append(bytes(data)), write(data))
    assert desk.order("stop", False) == 0
    assert said == [b"\x18"], said
    desk.run_ms(300)
    stood = desk.place()
    assert desk.machine.state["state"] == "Alarm" and desk.order("keep", lease=1, beat=desk.beats) == errors.LEASE
    desk.run_ms(300)
    assert desk.place() == stood and b"\x85" not in said


def check_a_target_beyond_the_travel():
    """One press of Unlock, or of Home, ends the alarm that asks for a reset, and the page does not tell of it any more; so it is if the
    page began after the alarm."""
    for order, seen in (("unlock", True), ("home", True), ("unlock", False), ("home", False)):
        desk = Desk()
        for line in ("$22=1", "$20=1"):
            desk.order("line", line=line)
            desk.run_ms(50)
        assert desk.order("home") == 0
        desk.settle()
        desk.order("line", line="G91G1X900F1000")
        desk.run_ms(200)
        assert desk.machine.state["state"] == "Alarm" and desk.machine.state["alarm"] == errors.ALARM_SOFT_LIMIT
        assert desk.order("jog", lease=1, beat=desk.beats, way={"x": 1}, speed=SPEED) == errors.LOCKED
        assert desk.order("step", by={"x": 1}, speed=SPEED) == desk.order("goto", to={"x": 1}, speed=SPEED) == errors.LOCKED
        if not seen:
            desk.machine.raise_alarm(0)
        assert desk.order(order) == 0
        desk.settle()
        desk.run_ms(200)
        assert desk.machine.state["state"] == "Idle" and desk.machine.state["alarm"] == 0, desk.machine.state
        assert desk.order("step", by={"x": 1}, speed=SPEED) == 0
        desk.settle()
        assert desk.machine.state["state"] == "Idle"


def check_nested_orders():
    """However deep, and in a text as well: nothing is raised, and no stack is needed."""
    for opened, closed in ("[]", ('{"a":', "}")):
        for depth, deep in ((2, False), (8, False), (9, True), (1000, True), (20000, True)):
            text = opened * depth + "1" + closed * depth
            assert too_deep(text) == deep, (opened, depth)
    assert not too_deep('{"do":"line","line":"' + "[" * 50 + '\\"' + "{" * 50 + '"}')
    assert too_deep('"\\"[[[[["' + "[" * 9)


def check_directions_of_every_size():
    """A jog's way is a direction: of any size, unless it is too small for a direction; a smaller axis beside it goes along or not at all."""
    for exponent in list(range(-330, 310, 40)) + list(range(-8, 7)):
        for other in (0, 1, -1e-7, 1e-320, -1e300):
            desk = Desk()
            size = float("1e%d" % exponent)
            error = desk.order("jog", lease=1, beat=desk.beats, way={"x": size, "y": other}, speed=SPEED)
            assert error in (0, errors.ORDER_FIELD), (size, other, error)
            if abs(other) <= 1:
                assert error == (0 if 1e-6 <= max(size, abs(other)) <= 1e5 else errors.ORDER_FIELD), (size, other)
            desk.order("release")
    for value in ("nan", "inf", "-inf"):
        assert Desk().order("jog", lease=1, beat=1, way={"x": float(value)}, speed=SPEED) == errors.ORDER_FIELD
        assert Desk().order("step", by={"x": 1.0}, speed=float(value)) == errors.ORDER_FIELD


PRESENCE = {
    "network": {"presence": "hand"},
    "inputs": BOARD["inputs"] + [{"name": "hand", "pin": 28, "active": 1}],
}


def check_who_is_far_away_wants_somebody_at_the_machine():
    desk = Desk(**PRESENCE)
    switches = desk.board.world.switches
    desk.store.put_job("a", "G21G91\nG1X4F3000\n")
    starts = (
        {"do": "output", "name": "spindle_cw", "rpm": 1000}, {"do": "output", "name": "spindle_ccw"}, {"do": "run", "name": "a"}, {"do": "resume"},
        {"do": "line", "line": "G1 X1 F100 m 03 S1000"}, {"do": "line", "line": "M4"}, {"do": "line", "line": "M(off)3"},
        {"do": "line", "line": "G4P0~"},
        {"do": "stored", "what": "run", "name": "A"}, {"do": "line", "line": "$F=A"}, {"do": "line", "line": "$N0=M3"},
    )  # fmt: skip
    switches["hand"] = 0
    desk.run_ms(100)
    before = desk.place()
    for order in starts:
        assert desk.api.answer_order(order, True, True)["error"] == errors.PRESENCE, order
        assert desk.api.answer_order(order, False, True)["error"] == errors.NO_SESSION, order
    for order in ({"do": "line", "line": "M9"}, {"do": "line", "line": "G4P0"}, {"do": "output", "name": "spindle_off"}, {"do": "hold"}):
        assert desk.api.answer_order(order, True, True)["error"] != errors.PRESENCE, order
        desk.run_ms(100)
    desk.settle()
    assert desk.place() == before and desk.board.world.tool == 0
    desk.order("resume")
    switches["hand"] = 1
    desk.run_ms(100)
    assert desk.api.answer_order(starts[2], True, True)["error"] == 0
    desk.settle()
    assert desk.place()[0] == before[0] + 4 * MM
    switches["hand"] = 0
    desk.run_ms(100)
    assert desk.order("run", name="a") == 0, "somebody at this computer"
    desk.settle()


WRONG = (
    {}, {"by": {}}, {"by": {"q": 1}, "speed": 100}, {"by": {"x": "1"}, "speed": 100}, {"by": {"x": True}, "speed": 100},
    {"by": {"x": 1e30}, "speed": 100}, {"by": {"x": float("nan")}, "speed": 100}, {"by": {"x": 1}, "speed": 0}, {"by": {"x": 1}},
    {"by": [1], "speed": 100}, {"by": {"xx": 1}, "speed": 100}, {"by": {"x": 1}, "speed": float("inf")},
)


def check_wrong_fields_move_nothing():
    desk = Desk()
    before = desk.place()
    for fields in WRONG:
        assert desk.order("step", **fields) == errors.ORDER_FIELD, fields
    for line in ("G0X1\nG0X2", "\x18", "G0X1\x85", "X" * 200, 5, None, "é"):
        assert desk.order("line", line=line) == errors.ORDER_FIELD
    for order in (None, [], "stop", 7, {"do": []}, {"do": "eval"}, {"do": "__class__"}):
        assert desk.api.answer_order(order, True)["error"] == errors.UNKNOWN_COMMAND
    desk.run_ms(100)
    assert desk.place() == before


def check_noise_moves_nothing(seed):
    """Random orders without the key, in any state of the machine."""
    desk = Desk()
    random = Random(seed)
    before = desk.place()
    names = sorted(desk.api._orders) + sorted(desk.machine.orders) + ["", "look", "reset"]
    for _ in range(60):
        fields = {"by": {random.choice("xyzq"): random.between(-50, 50)}, "speed": random.between(-5, 5000)}
        for name in ("lease", "beat", "at", "number"):
            fields[name] = random.between(-2, 40)
        fields["way"] = {"x": random.between(-1, 1)}
        assert desk.order(random.choice(names), False, **fields)
        desk.run_ms(5)
    assert desk.place() == before


def check_steps_and_places():
    desk = Desk()
    assert desk.order("step", by={"x": 5, "y": -2.5}, speed=SPEED) == 0
    desk.run_ms(50)
    assert desk.order("step", by={"x": 5}, speed=SPEED) == errors.BUSY
    desk.settle()
    assert desk.place() == [3000 + 5 * MM, 2500 - 800, -1800]
    assert desk.order("zero", axes="xy") == 0
    desk.settle()
    assert desk.machine.state["w"][:2] == [0, 0]
    assert desk.order("goto", to={"x": 1, "y": 1}, speed=SPEED) == 0
    desk.settle()
    assert desk.place() == [3000 + 6 * MM, 2500 - 800 + MM, -1800]


def check_a_job_runs_pauses_and_repeats():
    desk = Desk()
    start = desk.place()
    desk.store.put_job("a", "G21G91\nG1X4F3000\nY4\nX-4\nY-4\n")
    assert desk.order("run", name="a", passes=2) == 0
    desk.run_ms(150)
    assert desk.order("hold") == 0
    desk.run_ms(400)
    stood = desk.place()
    desk.run_ms(300)
    assert desk.place() == stood and desk.machine.state["state"] == "Hold"
    assert desk.order("resume") == 0
    desk.settle()
    job = desk.machine.state["job"]
    assert (job["how"], job["pass"], job["line"], job["error"]) == ("done", 2, 5, 0), job
    assert desk.place() == start


def check_a_job_line_by_line():
    desk = Desk()
    start = desk.place()
    desk.store.put_job("a", "G21G91\nG1X1F3000\nY1\nX-1\nY-1\n")
    assert desk.order("play", what="step") == errors.NO_SUCH_JOB
    assert desk.order("run", name="a", single=True) == 0
    desk.run_ms(300)
    assert desk.machine.state["job"]["done"] == 0
    for x, y in ((0, 0), (1, 0), (1, 1)):
        assert desk.order("play", what="step") == 0
        desk.run_ms(500)
        assert desk.place() == [start[0] + x * MM, start[1] + y * MM, start[2]]
    assert desk.machine.page_state()["job"]["single"] and desk.machine.state["job"]["line"] == 3
    assert desk.order("play", what="back") == errors.UNKNOWN_COMMAND
    assert desk.order("play", what="run") == 0
    desk.settle()
    assert desk.machine.state["job"]["how"] == "done" and desk.place() == start


def check_a_refused_line_ends_the_job():
    desk = Desk()
    desk.store.put_job("a", "G21G91\nG1X4F3000\nG1X4Q\nX40\n")
    assert desk.order("run", name="a") == 0
    desk.settle()
    job = desk.machine.state["job"]
    assert job["how"] == "failed" and job["error"] and job["line"] == 3, job
    assert desk.place()[0] <= 3000 + 4 * MM, "nothing behind it"


def check_a_job_is_only_checked():
    desk = Desk()
    before = desk.place()
    desk.store.put_job("a", "G21G91\nG1X4F3000\nY4\n")
    desk.store.put_job("b", "G21G91\nG1X4F3000\nG5.7\n")
    for name, how in (("a", "done"), ("b", "failed")):
        assert desk.order("run", name=name, check=True) == 0
        desk.settle()
        desk.run_ms(500)
        assert desk.machine.state["job"]["how"] == how and desk.machine.state["job"]["checked"]
        assert desk.place() == before and desk.board.controller.state != "check"
        assert desk.machine.state["state"] == "Idle" and desk.machine.state["alarm"] == 0, "as before"


def check_the_line_beyond_the_travel():
    """The error has the line's own number, in a run and in a check; after the check the machine is ready."""
    for check in (True, False):
        desk = Desk()
        assert desk.order("home") == 0
        desk.settle()
        desk.run_ms(500)
        near = ["X%d" % mm for mm in range(1, 101)]  # more than are looked ahead: it moves as the alarm comes, and is held on its way to the stand
        desk.store.put_job("far", "G21G90\nG1X0F3000\n" + "\n".join(near) + "\nX900\nX6\n")
        assert desk.order("run", name="far", check=check) == 0
        desk.settle()
        desk.run_ms(1000)
        job = desk.machine.state["job"]
        assert job["how"] == "failed" and job["line"] == 103, job
        assert desk.machine.state["state"] == ("Idle" if check else "Alarm")
        if not check:
            assert desk.machine.state["alarm"] == errors.ALARM_SOFT_LIMIT
            assert desk.order("unlock") == 0
            desk.settle()
            desk.run_ms(200)
            assert desk.machine.state["state"] == "Idle" and desk.machine.state["alarm"] == 0


def check_why_it_is_held():
    """The state shows a pause and a change of tool until the machine goes on."""
    desk = Desk()
    desk.store.put_job("a", "G21G91\nG1X1F3000\nM0\nG1X1\nM6T2\nX1\n")
    assert desk.order("run", name="a") == 0
    for why in ("pause", "T2"):
        desk.run_ms(1500)
        assert desk.machine.state["state"] == "Hold" and desk.machine.state["why"] == why
        assert desk.order("resume") == 0
        desk.run_ms(100)
    desk.settle()
    desk.run_ms(500)
    assert desk.machine.state["why"] == "" and desk.machine.state["job"]["how"] == "done"


def check_a_sender_beside_the_page():
    """It asks as it likes, moves only when it commands, and its lines are answered in order."""
    said = []
    desk = Desk(said.append)
    guest = desk.machine.guest

    def heard():
        text = b"".join(said).decode()
        said.clear()
        return text

    before = desk.place()
    heard()
    guest.feed(b"$G\nG91G1X1F1000\n?")
    desk.run_ms(300)
    text = heard()
    assert "[GC:" in text and text.count("ok") == 1 and "error:112" in text and text.count("<Idle") == 1, text
    assert text.find("ok") < text.find("error:112")
    assert desk.place() == before
    guest.feed(b"$LINK=0\nG91G1X1F1000\n")
    assert desk.order("step", by={"x": 1}, speed=500) == errors.COMMANDED_ELSEWHERE
    desk.settle()
    assert desk.place()[0] == before[0] + MM and heard().count("ok") == 2
    guest.feed(b"G1X30\n")
    desk.run_ms(100)
    assert desk.order("give", to="page") == errors.BUSY
    assert desk.order("stop", False) == 0
    desk.run_ms(500)
    assert "Grbl 1.1" in heard()


def check_letters_of_a_sender_beside_the_page():
    """Bytes beyond ASCII stay in their line, which the board refuses; a real-time byte acts, alone or as UTF-8, and spoils no line."""
    said = []
    desk = Desk(said.append)
    guest = desk.machine.guest
    guest.feed(b"$LINK=0\n")
    desk.run_ms(300)
    before = desk.place()
    for data in ("G91G1X1F900\nX\u22125\nX1\n".encode(), b"\xc2\x91X1\n", b"\x91X1\n", b"X\x965\n"):
        for cut in (1, 2, len(data) - 3):
            said.clear()
            guest.feed(data[:cut])
            desk.cycle()
            guest.feed(data[cut:])
            desk.run_ms(300)
            desk.settle()
            text = b"".join(said).decode()
            odd = data[:1] == b"G"
            assert (text.count("ok\r"), text.count("error:1\r")) == ((2, 1) if odd else (1, 0)), (data, cut, text)
            assert ("Letters beyond ASCII acted" in text) == (odd or b"\x96" in data), (data, cut, text)
    assert desk.place()[0] == before[0] + MM * (3 * 2 + 3 + 3 + 3 * 5)


def check_taught_moves_make_the_same_steps():
    desk = Desk()
    start = desk.place()
    assert desk.order("teach", what="begin") == 0
    desk.run_ms(100)
    for way in ({"x": 3.1}, {"x": 2.2}, {"y": 4}, {"x": -1.5, "y": -1.5}):
        assert desk.order("step", by=way, speed=2000) == 0
        desk.settle()
    desk.hold_jog(1, 300, way={"x": 1}, speed=1200)
    desk.order("release", lease=1)
    desk.settle()
    taught = desk.place()
    assert desk.order("teach", what="save", name="t") == 0
    text = desk.store.jobs["t"]
    assert text.count("G1") == 4, text  # two in a line are one
    back = {"x": (start[0] - taught[0]) / MM, "y": (start[1] - taught[1]) / MM}
    desk.order("step", by=back, speed=3000)
    desk.settle()
    assert desk.place() == start
    assert desk.order("run", name="t") == 0
    desk.settle()
    assert desk.place() == taught


def check_the_jobs_of_the_board():
    where = folder()
    desk = Desk(jobs={"language": "grbl", "folder": where, "button": "", "start": ""})

    def listed():
        assert desk.order("stored", what="list") == 0
        desk.run_ms(100)
        return [event for event in desk.told if event["t"] == "stored"][-1]["jobs"]

    def ended(how, error=0):
        desk.settle()
        job = desk.machine.state["job"]
        assert (job["how"], job["error"], job["name"]) == (how, error, "PART.NC"), job
        desk.run_ms(300)

    before = desk.place()
    assert listed() == []
    desk.store.put_job("part.nc", "G21G91\nG1X4F3000\nY4\nX-4\nY-4\n" + "(more)" * 60 + "\n")
    assert desk.order("stored", what="store", name="PART.NC", job="part.nc") == 0
    assert desk.order("step", by={"x": 1}, speed=100) == errors.BUSY, "not while it is stored"
    ended("kept")
    assert listed() == [["PART.NC", len(desk.store.jobs["part.nc"])]]
    assert desk.order("stored", what="run", name="PART.NC", check=True) == 0
    ended("done")
    assert desk.place() == before and desk.machine.state["state"] == "Idle"
    assert desk.order("stored", what="run", name="PART.NC") == 0
    desk.run_ms(250)
    assert desk.machine.state["state"] == "Run" and desk.order("run", name="part.nc") == errors.BUSY
    assert desk.order("hold") == 0
    desk.run_ms(400)
    stood = desk.place()
    assert stood != before and desk.machine.state["state"] == "Hold"
    assert desk.order("resume") == 0
    ended("done")
    assert desk.place() == before
    assert desk.order("stored", what="run", name="PART.NC") == 0
    desk.run_ms(250)
    assert desk.order("abort") == 0
    ended("failed", errors.STOPPED)
    assert desk.machine.state["state"] == "Idle", "it came to a stand on its path"
    desk.store.put_job("part.nc", "G1X1F100\nG5.7\n")
    assert desk.order("stored", what="store", name="PART.NC", job="part.nc") == 0
    ended("kept")
    assert desk.order("stored", what="run", name="PART.NC") == 0
    desk.settle()
    job = desk.machine.state["job"]
    assert job["how"] == "failed" and job["error"] and job["line"] == 2, job
    for wrong in ("a.nc", "", "PART~", "../X", 5, None):
        assert desk.order("stored", what="run", name=wrong) == STORED_NAME, wrong
    assert desk.order("stored", what="run", name="NONE") == 0
    desk.run_ms(200)
    assert desk.machine.state["job"]["error"] == NO_JOB
    assert desk.order("stored", what="delete", name="PART.NC") == 0
    desk.run_ms(200)
    assert listed() == []
    os.rmdir(where)


def check_a_board_that_keeps_no_jobs():
    desk = Desk()
    assert desk.order("stored", what="list") == 0
    desk.run_ms(100)
    assert [event for event in desk.told if event["t"] == "stored"][-1]["jobs"] is None


def check_a_wait_is_counted_down():
    desk = Desk()
    seen = []
    desk.machine.watcher = lambda state: seen.append((desk.now_ms(), state["wait"]))
    desk.store.put_job("a", "G21G91\nG1X1F3000\nG4 P0.8\nX-1\n")
    assert desk.order("run", name="a") == 0
    desk.settle()
    waits = [(at, left) for at, left in seen if left]
    assert len(waits) > 12 and 0.7 <= waits[0][1] <= 0.8 and waits[-1][1] < 0.1, waits
    for at, left in waits:
        assert abs(left * 1000 - (800 - (at - waits[0][0]))) <= 60, (at, left, waits[0])
    assert seen[-1][1] == 0
    for line, wanted in ((b"G4P2", 2000), (b"N7 G04 P.25", 250), (b"g4p1.5", 1500), (b"G40P2", 0), (b"G4X1", 0), (b"G1X4P2", 0), (b"G4P.", 0), (b"", 0)):
        assert dwell_ms(line) == wanted, line


def check_straight_runs():
    assert lines_of([(0, 0), (1, 1), (2, 2), (3, 3), (3, 4)]) == ["G1 X3.000 Y3.000", "G1 Y4.000"]
    assert lines_of([(0, 0), (2, 0), (1, 0)]) == ["G1 X2.000", "G1 X1.000"], "there and back is no straight run"


def check_no_axis_is_driven_beyond_its_own():
    limits = Limits([5000, 5000, 1500], [250, 250, 150])
    assert limits.limits_along((1, 0, 0)) == (5000, 250)
    speed, _ = limits.limits_along((0.6, 0, 0.8))
    assert abs(speed - 1875) < 1


def check_answers_find_their_way():
    sent, heard, answered = [], [], []
    wire = Wire(sent.append, lambda line, owner: heard.append((line, owner)))
    assert wire.send_line(PAGE, b"A", answered.append) and wire.send_line(1, b"B")
    wire.feed(b"[x]\r\no", 0)
    wire.feed(b"k\r\nerror:9\r\nok\r\n", 0)
    assert answered == [0] and heard == [("[x]", PAGE), ("error:9", 1)]
    assert not wire.send_line(PAGE, b"x" * 100) or not wire.send_line(PAGE, b"x" * 100)


def check_what_is_asked_by_a_typed_line_is_shown():
    """All of `$$`, and the report of `?`, which the page keeps for itself otherwise."""
    desk = Desk()
    for line, begins, least in (("$$", "$", 30), ("?", "<Idle|", 1), ("$#", "[", 6)):
        desk.told.clear()
        assert desk.order("line", line=line) == 0
        desk.run_ms(500)
        said = [event["text"] for event in desk.told if event["t"] == "said"]
        assert said[-1] == "ok" and len([text for text in said if text[: len(begins)] == begins]) >= least, said
    desk.told.clear()
    desk.order("line", line="G4P0")
    desk.run_ms(500)
    assert [event["text"] for event in desk.told if event["t"] == "said"] == ["ok"]


def check_a_typed_line_that_is_refused_is_explained():
    """If the PC knows what in the line is wrong, it says so before the answer."""
    desk = Desk()
    desk.machine.cause = lambda error, line: "%d in %s" % (error, line.decode()) if b"*" in line else ""
    for line, said in (("G1 X5*18", ["1 in G1 X5*18", "error:1"]), ("G1 X", ["error:2"]), ("G4 P0 (*)", ["ok"])):
        desk.told.clear()
        desk.order("line", line=line)
        desk.run_ms(500)
        assert [event["text"] for event in desk.told if event["t"] == "said"] == said, line


def check_one_answer_too_many_ends_the_job():
    """Another program sends lines by the same port: the page's lines are not answered one by one any more."""
    desk = Desk()
    desk.store.put_job("a", "G21G91\nG1F3000\n" + "X1\n" * 60)
    assert desk.order("run", name="a") == 0
    desk.run_ms(200)
    before = desk.place()[0]
    desk.line.incoming += b"G4P0\n"
    desk.settle()
    job = desk.machine.state["job"]
    assert (job["how"], job["error"]) == ("failed", errors.FOREIGN_ANSWER), job
    assert before < desk.place()[0] <= before + 60 * MM
    assert desk.order("run", name="a") == 0, "the next one may run"
    desk.settle()
    assert desk.machine.state["job"]["how"] == "done", desk.machine.state["job"]

"""Stored jobs on the page that the board itself serves: uploaded in pieces and run; whatever is torn, too long or out of place is refused."""

from binascii import b2a_base64, crc32

from board_browser import ServedRouter
from check_jobs import folder, remove, stored_form
from passo import errors
from passo.options.jobs.errors import JOB_DAMAGED, JOB_SPACE, JOB_STOPPED, JOB_UPLOAD, NO_JOB, STORED_NAME
from passo.options.jobs.language_page import PIECE
from router import BOARD, World

MM = 320  # steps
JOB = b"G21\nG91\nF3000\n" + b"G1X4\nY4\nX-4\nY-4\n" * 40 + b"G1X2Y1\n"
CASES = {"check_an_upload_that_is_damaged": (("at", 0, len(JOB)), ("bit", 0, 7))}
RUNS = {"check_an_upload_that_is_damaged": 4}
NOT_QUICK = ("check_an_upload_is_run",)


def served(**changes):
    board = ServedRouter(jobs={"language": "grbl", "folder": folder(), "button": "", "start": ""}, **changes)
    board.folder = board.app.board["jobs"]["folder"]
    page = board.commanding()
    assert "kept" in page.hello["can"] and "jobs" not in page.hello["can"]
    return board, page


def ask(page, what, **fields):
    return page.order("stored", what=what, **fields)["error"]


def begin(page, packed, name="PART.NC", data=JOB, crc=None):
    crc = crc32(data) & 0xFFFFFFFF if crc is None else crc
    return ask(page, "begin", name=name, size=len(data), crc="%08x" % crc, stored=len(packed))


def pieces(page, packed, name="PART.NC", count=1000):
    for at in range(0, min(len(packed), count * PIECE), PIECE):
        error = ask(page, "piece", name=name, at=at, data=b2a_base64(packed[at : at + PIECE]).decode().strip())
        if error:
            return error
    return 0


def listed(page):
    assert ask(page, "list") == 0
    return page.wait(lambda message: message["t"] == "stored")["jobs"]


def check_an_upload_is_run():
    board, page = served()
    packed = stored_form(JOB)
    assert listed(page) == []
    assert begin(page, packed) == 0 and pieces(page, packed) == 0
    page.until(lambda state: state["job"] and (state["job"]["how"], state["job"]["name"], state["job"]["done"]) == ("store", "PART.NC", 100))
    assert listed(page) == [], "it counts once it is whole"
    assert ask(page, "end", name="PART.NC") == 0
    page.until(lambda state: state["job"]["how"] == "kept")
    assert listed(page) == [["PART.NC", len(JOB)]]
    before = list(board.world.place)
    assert ask(page, "run", name="PART.NC") == 0
    page.until(lambda state: state["job"]["how"] == "run" and 20 < state["job"]["done"] < 90)
    assert page.state["owner"] == "page" and page.order("hold")["error"] == 0
    page.until(lambda state: state["state"] == "Hold")
    for what in ("list", "delete", "run"):
        assert ask(page, what, name="PART.NC") != 0, what
    assert begin(page, packed, "OTHER.NC") != 0
    assert page.order("resume")["error"] == 0
    page.until(lambda state: state["job"]["how"] == "done")
    page.until(lambda state: state["state"] == "Idle")
    assert [now - then for now, then in zip(board.world.place, before)] == [2 * MM, MM, 0]
    assert ask(page, "run", name="PART.NC") == 0
    page.until(lambda state: state["state"] == "Run")
    assert page.order("stop", False)["error"] == 0
    page.until(lambda state: state["job"]["how"] == "failed" and state["job"]["error"] == JOB_STOPPED)
    page.until(lambda state: state["state"] == "Alarm")
    assert ask(page, "delete", name="PART.NC") == 0 and listed(page) == []
    assert page.order("unlock")["error"] == 0
    page.until(lambda state: state["state"] == "Idle")
    assert ask(page, "run", name="PART.NC") == NO_JOB
    remove(board)


def check_what_is_no_upload():
    board, page = served()
    packed = stored_form(JOB)
    for name in ("../BOARD.PY", "A/B", ".HIDDEN", "part", "", "X" * 25, "A\\B", "A\x00B"):
        for what in ("begin", "piece", "end", "run", "delete"):
            assert ask(page, what, name=name, size=9, crc="0", stored=9, at=0, data="AAAA") in (STORED_NAME, errors.ORDER_FIELD), name
    for what in ("list", "begin", "piece", "end", "run", "delete"):
        answer = page.order("stored", False, what=what, name="PART.NC", size=9, crc="0", stored=9, at=0, data="AAAA")
        assert answer["error"] == errors.NO_SESSION
    for fields in ({"size": 0}, {"stored": -1}, {"stored": 1 << 40}, {"crc": "xyz"}, {"crc": 5}, {"size": "9"}):
        good = {"size": 9, "crc": "0", "stored": 9}
        good.update(fields)
        assert ask(page, "begin", name="PART.NC", **good) == errors.ORDER_FIELD, fields
    assert ask(page, "begin", name="PART.NC", size=9, crc="0", stored=0x0FFFFFFF) in (0, JOB_SPACE)
    assert ask(page, "piece", name="OTHER.NC", at=0, data="AAAA") == JOB_UPLOAD
    assert begin(page, packed) == 0 and pieces(page, packed, count=1) == 0
    for at in (0, PIECE - 1, PIECE + 1, 2 * PIECE):
        assert ask(page, "piece", name="PART.NC", at=at, data="AAAA") == errors.JOB_PIECE, at
    for data in ("A" * 401, "\u00e9", 5, "A"):
        assert ask(page, "piece", name="PART.NC", at=PIECE, data=data) in (errors.ORDER_FIELD, errors.JOB_PIECE), data
    assert ask(page, "end", name="PART.NC") == JOB_UPLOAD and listed(page) == []
    assert begin(page, packed[:-1]) == 0
    assert pieces(page, packed) == JOB_UPLOAD, "more than was announced"
    other = board.page()
    assert begin(page, packed) == 0 and pieces(page, packed, count=1) == 0
    assert begin(other, packed, "OTHER.NC") == 0
    assert ask(page, "piece", name="PART.NC", at=PIECE, data="AAAA") == JOB_UPLOAD, "another page has begun one"
    page.wire.close()
    board.browsers.remove(page)
    board.run_ms(200)
    assert pieces(other, packed, "OTHER.NC") == 0 and ask(other, "end", name="OTHER.NC") == 0
    other.until(lambda state: state["job"]["how"] == "kept")
    assert listed(other) == [["OTHER.NC", len(JOB)]]
    assert other.order("step", by={"x": 20}, speed=3000)["error"] == 0
    assert begin(other, packed) == errors.BUSY
    other.until(lambda state: state["state"] == "Jog")
    assert begin(other, packed) == errors.BUSY and ask(other, "run", name="OTHER.NC") == errors.BUSY
    other.until(lambda state: state["state"] == "Idle")
    assert other.order("give", to="guest")["error"] == 0
    other.until(lambda state: state["owner"] == "guest")
    assert begin(other, packed) == errors.COMMANDED_ELSEWHERE
    remove(board)


def check_a_run_wants_somebody_there():
    """If the board file names an input for it. To upload moves nothing."""
    world = World()
    world.switches["hand"] = 0
    inputs = BOARD["inputs"] + [{"name": "hand", "pin": 28, "active": 1}]
    board, page = served(world=world, network={"host": "passo", "presence": "hand"}, inputs=inputs)
    packed = stored_form(JOB)
    assert begin(page, packed) == 0 and pieces(page, packed) == 0 and ask(page, "end", name="PART.NC") == 0
    page.until(lambda state: state["job"] and state["job"]["how"] == "kept")
    before = list(world.place)
    assert ask(page, "run", name="PART.NC") == errors.PRESENCE
    board.run_ms(300)
    assert list(world.place) == before
    world.switches["hand"] = 1
    assert ask(page, "run", name="PART.NC") == 0
    page.until(lambda state: state["state"] == "Run")
    remove(board)


def check_an_upload_that_is_damaged(at, bit):
    """One bit, anywhere: the stored job stays."""
    board, page = served()
    packed = stored_form(JOB)
    wrong = bytearray(packed)
    wrong[at * (len(packed) - 1) // len(JOB)] ^= 1 << bit
    for data in (packed, bytes(wrong)):
        assert begin(page, packed) == 0 and pieces(page, data) == 0
        error = ask(page, "end", name="PART.NC")
        board.run_ms(400)
    error = error or page.state["job"]["error"]
    assert error == JOB_DAMAGED or page.state["job"]["how"] == "kept", "only the right bytes may be kept"
    assert listed(page) == [["PART.NC", len(JOB)]]
    remove(board)

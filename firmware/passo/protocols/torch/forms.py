"""The torch manipulator's HTTP table of 2020: one request in, the fields of its answer out. The server is web/http.py.

A request is a byte that the answer begins with, a byte of flags (REQUEST_PROVEN, REQUEST_JSON), then path, blank and body:
`/COMMAND x=100&y=100&xv=100&yv=100`. An answer is that byte and `code=254&state=running&error=0&…`, or the same as JSON.

Each request becomes the frame of the same name, so that both links do the same. `code` is the frame's code, `state` what the machine does:
stopped, running, finished, alarm … COMMAND and CONFIG repeat their numbers. INFO and HALT tell `x` and `y`, the signed steps since the last
move or jog as the frames do, and `px` and `py`, the position in steps from the origin. A refused request moves nothing: `error` has the
number. SETTING is Passo's own: it sets one and keeps it. ON takes the command too if nothing moves, because the program of 2020 has no word
for that.
"""

from micropython import const

from passo import errors
from passo.commands import ACCEPTED, BAD, FINISHED, HAND_OVER, REFUSED, RUN, SETTING, STATUS, STATUS_WORDS, STILL, STOP, Command
from passo.protocols.setting_lines import decimal_text
from passo.protocols.torch.protocol import CODES, Torch, configure, frame, move
from passo.records import REQUEST_JSON, REQUEST_PROVEN

_MOST_BODY = const(200)
_FREE = (b"/HALT", b"/INFO")  # without a proof
_NAMES = {
    b"/ON": "CONNECT", b"/OFF": "DISCONNECT", b"/HALT": "STOP", b"/INFO": "INFO", b"/ORIGIN": "ORIGIN",
    b"/JOGX+": "JOG_X+", b"/JOGX-": "JOG_X-", b"/JOGY+": "JOG_Y+", b"/JOGY-": "JOG_Y-",
}  # fmt: skip
_FIELDS = {b"/COMMAND": ("x", "xv", "y", "yv"), b"/CONFIG": ("jogx", "jogy", "xv", "yv")}
_FRAMES = {b"/COMMAND": ("MOVE", move), b"/CONFIG": ("CONFIGURE", configure)}
_SETTING = b"/SETTING"  # Passo's own: number=100&value=48.5; value= is the board file's
PATHS = tuple(_NAMES) + tuple(_FIELDS) + (_SETTING,)
_UNSIGNED = ("x", "y", "jogx", "jogy")
_HALF = 0x80000000
_OPEN = const(8)


def parse_whole(text, least, most):
    """Return the whole number of a text of ASCII digits, with a sign or not; None if it is none, or not within least … most."""
    digits = text[1:] if text[:1] in ("-", "+") else text
    if not digits or len(digits) > 10:
        return None
    for digit in digits:
        if not "0" <= digit <= "9":
            return None
    value = -int(digits) if text[0] == "-" else int(digits)
    return value if least <= value <= most else None


def parse_form(body):
    """Return {key: text} of `key=value&key=value`; None if a key occurs twice, or it is no such text."""
    found = {}
    for part in body.split("&") if body else ():
        key, equals, value = part.partition("=")
        if not equals or key in found:
            return None
        found[key] = value
    return found


class Forms(Torch):
    POSTS = tuple([path for path in PATHS if path != b"/INFO"])
    GETS = (b"/INFO",)  # the request for a page's events, too
    FREE = _FREE
    KEYED = (_SETTING,)
    PAGE = "torch.html"

    def __init__(self, machine):
        """`machine`: the machine's state."""
        Torch.__init__(self, machine.settings)
        self._machine = machine
        self._ended = False  # the last move or jog has come to its end
        self._open = []  # (command, number, JSON, path, fields) of requests without an answer

    def feed(self, data, now_ms):
        """Return the commands of one request."""
        if len(data) < 2:
            return ()
        path, _, body = bytes(data[2:]).partition(b" ")
        commands = self._request_commands(path, body, data[1])
        command = commands[-1]  # the one that is answered
        fields = body if command.kind != BAD and path in _FIELDS else b""
        if len(self._open) >= _OPEN:
            self._open.pop(0)
        self._open.append((command, data[0], data[1] & REQUEST_JSON, path, fields))
        return commands

    def _request_commands(self, path, body, flags):
        """Return the commands of a request, the one that is answered last."""
        if path not in PATHS:
            return (Command(BAD, error=errors.UNKNOWN_COMMAND),)
        if not flags & REQUEST_PROVEN and path not in _FREE:
            return (Command(BAD, error=errors.NOT_ADMITTED),)
        if path == _SETTING:
            return (self._setting_command(body),)
        if path in _FIELDS:
            frame_bytes = self._request_frame(path, body)
            if frame_bytes is None:
                return (Command(BAD, error=errors.GARBLED),)
        else:
            frame_bytes = frame(_NAMES[path])
        command = self._frame_command(frame_bytes)
        self._asked = None  # the server hands over one request at a time
        return (Command(HAND_OVER), command) if path == b"/ON" else (command,)

    def _setting_command(self, body):
        """Return the Command that sets and keeps a setting."""
        try:
            found = parse_form(body.decode()) if len(body) <= _MOST_BODY else None
        except ValueError:
            found = None
        if found is None or set(found) != {"number", "value"}:
            return Command(BAD, error=errors.GARBLED)
        return self.words.line_command("$%s=%s" % (found["number"], found["value"]))

    def _request_frame(self, path, body):
        """Return the frame of a request with fields; None if one is missing, too many or out of its range."""
        if len(body) > _MOST_BODY:
            return None
        try:
            found = parse_form(body.decode())
        except ValueError:
            return None
        names = _FIELDS[path]
        if found is None or len(found) != len(names):
            return None
        values = []
        for name in names:
            unsigned = name in _UNSIGNED
            least = 0 if unsigned else -_HALF
            value = parse_whole(found.get(name, ""), least, 2 * _HALF - 1 if unsigned else _HALF - 1)
            if value is None:
                return None
            values.append(value)
        return _FRAMES[path][1](*values)

    # --- answers

    def reply(self, event):
        """Return the answer to the request that `event` is about; b"" if another event is."""
        command = event.command
        if event.kind == REFUSED:
            self.dropped = (self.dropped + 1) & 0x1FFFFFFF
        elif event.kind == FINISHED and command.kind == RUN:
            self._ended = True
            return b""
        for request in self._open:
            if request[0] is command:
                self._open.remove(request)
                return self._answer_request(event, *request)
        return b""

    def _answer_request(self, event, command, number, as_json, path, fields):
        """Return a request's answer, behind its number."""
        if command.kind == STOP or command.kind == RUN and event.kind == ACCEPTED:
            self._ended = False
        if command.kind == STILL and event.kind == ACCEPTED:
            self._keep_configured(*command.value)
        told = [("code", self._code_of(path)), ("state", self._state_word()), ("error", event.error)]
        if event.kind != REFUSED:
            if command.kind == SETTING:
                number, value, places = event.value
                told += [("number", number), ("value", decimal_text(value, places))]
            if command.kind == STATUS or command.kind == STOP:
                told += self._position_fields(event.value)
            if command.kind == STATUS:
                told += self._more_fields(event.value)
            if fields:
                found = parse_form(fields.decode())
                told += [(name, int(found[name])) for name in _FIELDS[path]]
        return bytes((number,)) + _answer_text(told, as_json).encode()

    def _position_fields(self, report):
        """Return the fields of positions, in steps."""
        made, position = report["made"], report["position"]
        return [("x", made[0]), ("y", made[1]), ("px", position[0]), ("py", position[1])]

    def _more_fields(self, report):
        """Return the fields that only INFO has."""
        x, y = self._machine.steps_per_m[:2]
        told = [("last", report["error"]), ("ours", 1 if report["ours"] else 0), ("spmx", x), ("spmy", y)]
        return told + [(word, report[key]) for key, word in STATUS_WORDS if report.get(key) is not None]

    def _code_of(self, path):
        """Return the code of the frame that a path stands for, 0 if it has none."""
        name = _FRAMES[path][0] if path in _FRAMES else _NAMES.get(path)
        return CODES.get(name, 0)

    def _state_word(self):
        """Return the document's word for the state, or Passo's own."""
        state = self._machine.state
        if state == "run" or state == "jog":
            return "running"
        if state == "idle":
            return "finished" if self._ended else "stopped"
        return state

    def drop(self, event):
        """Note that no move ends as finished; a frame under way has been refused, and answered by that."""
        self._ended = False
        return b""


def _answer_text(told, as_json):
    """Return fields as `key=value&…`, or as JSON."""
    if not as_json:
        return "&".join(["%s=%s" % pair for pair in told])
    return "{%s}" % ", ".join(['"%s": %s' % (name, value if isinstance(value, int) else '"%s"' % value) for name, value in told])

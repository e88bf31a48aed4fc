"""The orders of a page: an order as a dict in, an answer as a dict out. The only code that checks orders from a network.

    orders = Orders(machine)
    orders.answer_order({"do": "step", "by": {"x": 1.0}, "speed": 500}, proven)     # {"t": "answer", "do": "step", "error": 0}

Orders of one language come from its machine (`orders`), which checks them with the functions of this module. STOP needs no proof. All
other orders that act want a session that has proven its key; those that only read do not. A PC adds jobs that are streamed, teach-in and
the choice of a machine (host_tools/page/orders.py).
"""

import json

from micropython import const

from passo import errors

_MOST_MM = 100_000.0
_MOST_SPEED = 1_000_000.0
_LEAST_WAY = 1e-6  # of a direction: less is no direction, and its square may be 0
_LINE = const(120)
_MOST_NUMBER = const(0x1FFFFFFF)
_QUOTE, _BACKSLASH, _BRACE, _BRACKET = const(34), const(92), const(123), const(91)
_DEEPEST = const(8)  # brackets in each other: an order has two


class Wrong(Exception):
    """A field is missing, or out of its bounds."""


def too_deep(text):
    """True if brackets of JSON stand in each other more than _DEEPEST times: a parser that calls itself would run out of stack."""
    depth = 0
    quoted = escaped = False
    for code in text.encode():  # bytes: MicroPython keeps each letter that it takes out of a text as a name for good
        if escaped:
            escaped = False
        elif quoted:
            escaped = code == _BACKSLASH
            quoted = code != _QUOTE
        elif code == _QUOTE:
            quoted = True
        elif code == _BRACE or code == _BRACKET:
            depth += 1
            if depth > _DEEPEST:
                return True
        elif code == _BRACE + 2 or code == _BRACKET + 2:  # the closing ones
            depth -= 1
    return False


def order_of(text):
    """The order in a message, usually a dict. Raises ValueError if it is no JSON, or too deep."""
    if text.count("{") + text.count("[") > _DEEPEST and too_deep(text):
        raise ValueError(text)
    return json.loads(text)


def number_field(order, name, least, most, otherwise=None):
    """The number in field `name` of an order, from `least` to `most`; `otherwise`: if it is missing. Raises Wrong."""
    value = order.get(name, otherwise)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not least <= value <= most:
        raise Wrong(name)
    return value


def text_field(order, name, most):
    """The text in field `name` of an order, printable ASCII, `most` letters at most. Raises Wrong."""
    value = order.get(name)
    if not isinstance(value, str) or len(value) > most or [code for code in value.encode("utf-8", "surrogatepass") if not 32 <= code <= 126]:
        raise Wrong(name)
    return value


def positions_field(order, name, axes):
    """The positions in field `name` of an order, {axis: mm}, of `axes` only. Raises Wrong."""
    value = order.get(name)
    if not isinstance(value, dict) or not value:
        raise Wrong(name)
    for axis in value:
        if not isinstance(axis, str) or len(axis) != 1 or axis not in axes:  # MicroPython takes JSON whose keys are no texts
            raise Wrong(name)
        number_field(value, axis, -_MOST_MM, _MOST_MM)
    return value


class Orders:
    def __init__(self, machine):
        self.machine = machine
        self._orders = {
            "hold": self._order_hold, "resume": self._order_resume, "home": self._order_home, "unlock": self._order_unlock, "zero": self._order_zero,
            "goto": self._order_goto, "step": self._order_step, "jog": self._order_jog, "keep": self._order_keep, "release": self._order_release,
            "override": self._order_override, "output": self._order_output, "set": self._order_set, "line": self._order_line, "give": self._order_give,
            "jobs": self._order_jobs, "abort": self._order_abort, "log": self._order_log, "settings": self._order_settings, "play": self._order_play,
        }  # fmt: skip

    def page_orders(self):
        """Return the orders that a page may give."""
        return list(self.machine.can)

    def first_message(self):
        """Return a page's first message, a dict."""
        machine = self.machine
        return {"can": self.page_orders(), "axes": machine.axes, "turns": machine.turns, "language": machine.language, "travel": machine.travel}

    def answer_order(self, order, proven):
        """Carry out an order and return its answer, a dict. `proven`: its session has the key."""
        name = order.get("do") if isinstance(order, dict) else None
        if name == "stop":
            self.machine.lease.number += 1  # every page sees the new number, and ends what it does line by line
            return self._plain_answer("stop", self.machine.stop())
        do = (self._orders.get(name) or self.machine.orders.get(name)) if isinstance(name, str) else None
        if do is None:
            return self._plain_answer("", errors.UNKNOWN_COMMAND)
        if not proven:
            return self._plain_answer(name, errors.NO_SESSION)
        try:
            found = do(order)
        except Wrong:
            return self._plain_answer(name, errors.ORDER_FIELD)
        return found if isinstance(found, dict) else {"t": "answer", "do": name, "error": found}

    def _plain_answer(self, name, error):
        return {"t": "answer", "do": name, "error": error}

    # --- motion
    # Each _order_NAME(order) carries out the order NAME, a dict, and returns 0, an error, or a message. Raises Wrong.

    def _order_hold(self, order):
        return self.machine.hold()

    def _order_resume(self, order):
        return self.machine.refusal() or self.machine.resume()

    def _order_home(self, order):
        return self.machine.refusal() or self.machine.busy_error() or self.machine.home()

    def _order_unlock(self, order):
        return self.machine.refusal() or self.machine.unlock()

    def _order_zero(self, order):
        axes = text_field(order, "axes", 4)
        if not axes or [axis for axis in axes if axis not in self.machine.axes]:
            raise Wrong("axes")
        return self.machine.refusal() or self.machine.set_work_zero(axes)

    def _order_goto(self, order):
        position = positions_field(order, "to", self.machine.axes)
        speed = number_field(order, "speed", 0.1, _MOST_SPEED)
        return self.machine.refusal(by_hand=True) or self.machine.go_to(position, speed)

    def _order_step(self, order):
        way = positions_field(order, "by", self.machine.axes)
        speed = number_field(order, "speed", 0.1, _MOST_SPEED)
        return self.machine.refusal(by_hand=True) or self.machine.step_by(way, speed)

    def _order_jog(self, order):
        """Begin a jog along the order's `way` at `speed` mm/min, under its lease. Returns 0 or an error. Raises Wrong."""
        lease = number_field(order, "lease", 1, _MOST_NUMBER)
        beat = number_field(order, "beat", 0, _MOST_NUMBER)
        way = positions_field(order, "way", self.machine.axes)
        direction = [way.get(axis, 0) for axis in self.machine.axes]
        most = max([abs(part) for part in direction])
        if most < _LEAST_WAY:
            raise Wrong("way")
        direction = [part / most if abs(part) >= most * _LEAST_WAY else 0 for part in direction]
        speed = number_field(order, "speed", 0.1, _MOST_SPEED)
        return self.machine.refusal(by_hand=True) or self.machine.begin_jog(lease, beat, direction, speed)

    def _order_keep(self, order):
        lease = number_field(order, "lease", 1, _MOST_NUMBER)
        beat = number_field(order, "beat", 0, _MOST_NUMBER)
        return 0 if self.machine.renew_jog(lease, beat) else errors.LEASE

    def _order_release(self, order):
        self.machine.end_jog()
        return 0

    def _order_override(self, order):
        return self.machine.refusal() or self.machine.set_override(text_field(order, "what", 8), text_field(order, "to", 4))

    def _order_output(self, order):
        rpm = number_field(order, "rpm", 0, 1_000_000, 0)
        return self.machine.refusal() or self.machine.set_output(text_field(order, "name", 16), rpm)

    def _order_line(self, order):
        return self.machine.refusal() or self.machine.run_line(text_field(order, "line", _LINE))

    def _order_give(self, order):
        return self.machine.hand_over("guest" if order.get("to") == "guest" else "page")

    # --- settings and log

    def _order_settings(self, order):
        return {"t": "settings", "axes": self.machine.axes, "settings": self.machine.settings_texts()}

    def _order_set(self, order):
        which = number_field(order, "number", 0, 999)
        if which != int(which):
            raise Wrong("number")
        value = number_field(order, "value", -1e9, 1e9)
        return self.machine.refusal() or self.machine.set_setting(int(which), ("%.3f" % value).rstrip("0").rstrip("."))

    def _order_log(self, order):
        return {"t": "log", "log": self.machine.log(), "all": True}

    # --- jobs

    def _order_jobs(self, order):
        return {"t": "jobs", "jobs": []}

    def _order_play(self, order):
        """Go on with a job: forward, backward, a step at a time. Returns 0 or an error."""
        return self.machine.refusal() or self.machine.play(text_field(order, "what", 16))

    def _order_abort(self, order):
        return self.machine.abort()

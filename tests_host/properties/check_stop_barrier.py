"""A STOP beside a page's WebSocket refuses the orders that were sent before it: no other ones, whoever says it, and however late it comes."""

from draws import Random
from passo import errors
from passo.web.pages import Pages
from passo.web.session import Session

KEY = "ABCDEFGHJKLMNPQR"
WINDOW = 100  # orders under way, at most
CASES = {"check_orders_and_stops_in_any_order": (("seed", "seed"),)}
RUNS = {"check_orders_and_stops_in_any_order": 100}  # of 100 orders each


class Sender:
    """A page and its server."""

    def __init__(self):
        self.pages = Pages(KEY, 4)
        self.page = self.pages.add_page(None, {}, 0)
        self.session = Session(KEY, self.page.session.nonce)
        self.count = 0  # of the newest order sent
        self.under_way = []
        self.now_ms = 0

    def send(self):
        self.count += 1
        body = '{"do":"step"}'
        self.under_way.append("%d.%s.%s" % (self.count, self.session.proof(str(self.count), body), body))

    def arrive(self):
        """True if the oldest order under way may act."""
        self.now_ms += 100
        text, answer = self.pages.open(self.page, self.under_way.pop(0), self.now_ms)
        assert text is not None or answer["error"] == errors.STOPPED, answer
        return text is not None

    def stop(self, count, nonce=None):
        self.pages.refuse_older(b"%s.%d" % ((nonce or self.page.session.nonce).encode(), count))


def check_orders_and_stops_in_any_order(seed):
    """Orders come in their order, STOPs at any time; strangers say STOP with counts of their own."""
    random = Random(seed)
    sender = Sender()
    stops = []  # that the page has said, and that are under way
    barrier = arrived = 0
    while arrived < 100:
        what = random.between(0, 9)
        if what < 4 and len(sender.under_way) < WINDOW:
            sender.send()
        elif what < 7 and sender.under_way:
            arrived += 1
            assert sender.arrive() == (arrived > barrier), (arrived, barrier)
        elif what == 7:
            stops.append(sender.count)
        elif what == 8 and stops:
            count = stops.pop(random.between(0, len(stops) - 1))
            sender.stop(count)
            barrier = max(barrier, count)
            assert sender.page.before >= count, "bytes before the stop may not act"
        elif what == 9:
            count = random.choice((0, arrived, arrived + random.between(0, 200), random.between(0, 99_999_999)))
            sender.stop(count, random.choice((None, None, "0" * 32)) if count > arrived + WINDOW else "0" * 32)
        assert sender.page.before == barrier <= sender.page.session.count + WINDOW


def check_a_late_stop_leaves_a_newer_one_s_barrier():
    sender = Sender()
    for _ in range(5):
        sender.send()
    sender.stop(5)
    sender.stop(2)
    assert [sender.arrive() for _ in range(5)] == [False] * 5
    sender.send()
    assert sender.arrive()


def check_a_forged_stop_silences_no_page():
    sender = Sender()
    for _ in range(3):
        sender.send()
        assert sender.arrive()
    for count in (3 + WINDOW + 1, 5_000, 99_999_999):
        sender.stop(count)
    sender.send()
    assert sender.arrive()
    sender.stop(4 + WINDOW)
    for count in range(5, 4 + WINDOW + 2):
        sender.send()
        assert sender.arrive() == (count > 4 + WINDOW), count


def check_a_stop_that_is_none():
    sender = Sender()
    nonce = sender.page.session.nonce.encode()
    for wrong in (b"", b".", nonce, nonce + b".", nonce + b".-1", nonce + b".1.2", nonce + b".\xff", nonce + b". 1", nonce + b"." + b"9" * 400, b"\xff" * 99):
        sender.pages.refuse_older(wrong)
    sender.send()
    assert sender.arrive() and sender.page.before == 0

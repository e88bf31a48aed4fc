"""The page's side of the wire beside a virtual board, in stepped time: the server's work, without a network. Each desk adds its board.

    desk.order("step", by={"x": 5}, speed=600)      # 0: its error
    desk.until(lambda state: state["state"] == "Idle")
    desk.hold_jog(1, 480, way={"x": 1})
"""

from passo.records import COUNT_MASK, TICKS_PER_MS

PUSH_MS = 50


class SteppedDesk:
    jog_speed = 600

    def __init__(self, app, port, line):
        """`line`: the MemoryLine that the page speaks on. A subclass has `machine` and `api`."""
        self.app, self.port, self.line = app, port, line
        self.told = []
        self.beats = 0
        self._pushed = 0

    def put(self, data):
        """Bytes of the page, to the board."""
        self.line.incoming += data

    def now_ms(self):
        return (self.port.now // TICKS_PER_MS) & COUNT_MASK

    def order(self, do, proven=True, **fields):
        """The error of an order's answer; 0: none."""
        return self.ask(do, proven, **fields).get("error", 0)

    def ask(self, do, proven=True, **fields):
        fields["do"] = do
        return self.api.answer_order(fields, proven)

    def cycle(self):
        self.app.cycle()
        data = self.line.outgoing
        self.line.outgoing = b""
        now = self.now_ms()
        self.machine.feed(bytes(data), now)
        self.machine.poll(now)
        if (now - self._pushed) & COUNT_MASK >= PUSH_MS:
            self._pushed = now
            self.beats += 1
            self.machine.note_beat(self.beats)

    def run_ms(self, milliseconds):
        end = self.port.now + milliseconds * TICKS_PER_MS
        while self.port.now < end:
            self.cycle()

    def until(self, wanted, limit_ms=60_000):
        end = self.port.now + limit_ms * TICKS_PER_MS
        while not wanted(self.machine.page_state()):
            assert self.port.now < end, self.machine.state
            self.cycle()

    def settle(self):
        """Until reports say that it stands."""
        self.run_ms(150)
        self.until(lambda state: state["state"] in ("Idle", "Hold", "Alarm"))
        self.run_ms(100)

    def hold_jog(self, lease, milliseconds, **fields):
        """Hold a jog for `milliseconds`, renewed each 60 ms."""
        if "speed" not in fields:
            fields["speed"] = self.jog_speed
        error = self.order("jog", lease=lease, beat=self.beats, **fields)
        assert error == 0, error
        while milliseconds > 0:
            self.run_ms(60)
            milliseconds -= 60
            assert self.order("keep", lease=lease, beat=self.beats) == 0

"""A PC that sends points to a Rig as fast as they are answered, with `window` packets under way.

    sender = Sender(usb_rig())              # or Sender(Rig(router(3)), 57_600): its UART at this rate
    sent = sender.send(300, window=1, hz=100_000)
    sent.rate, sent.share, sent.late, sent.lost

With a window of 1 it is a program that waits for each NEXT before it sends the next packet. The PC itself takes no time.
"""

from dataclasses import dataclass

from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.rig import Rig, router_board, ticks_of
from host_tools.emulator.traffic import move_packets
from host_tools.emulator.wire import BITS_A_BYTE

WINDOW = 32  # packets under way of a program that does not wait
NEXT = b"n"
_START_HZ, _START_S = 5000, 0.01  # as after a ramp
_LINE_S = 4  # longer than sending takes
_LIMIT_US = 3_000_000
_USB = {"name": "pc", "port": "usb", "protocol": "plotter", "idle_gap_ms": 5}
_RATE = """
app.links[0].serial.close()
app.links[0].serial.__init__(dict(board["links"][0], baud={baud}))
"""
_LOOP = """
import micropython
micropython.kbd_intr(-1)
gc.collect()
gc.threshold(-1)
if {hz}:
    for deltas, ticks in {lines}:
        planner.line(deltas, ticks, False)
    planner.flush()
    controller.machine.awake = True
    while not player.busy():
        app.cycle()
print("ready")
while controller.features["drawing"].points.count < {count}:
    app.cycle()
print(feeder.late, controller.machine.log.entries)
"""


def usb_rig(uf2=None):
    """Return a Rig whose link is USB."""
    return Rig(router_board(3, links=[_USB]), uf2)


@dataclass
class Sent:
    rate: float  # points a second, from the first byte of the first one to the answer to the last
    share: float  # of the wire's bytes a second; 0 for USB
    late: int  # step words
    lost: int  # bytes that found the UART's FIFO full
    answers: bytes
    log: str  # the board's log: empty if all is well


class Sender:
    """For one send(), or several on copies of the rig. The board keeps 500 points."""

    def __init__(self, rig, baud=0):
        self._pico, self._wire, self._baud = rig.pico, None, baud
        if baud:
            self._pico.exec(_RATE.format(baud=baud))
            self._wire = rig.wire()
            self._wire.listeners.append(lambda byte: self._take_answers(bytes((byte,))))
        self._packets = []  # not yet sent
        self._answers = bytearray()
        self._wanted = self._ended = 0  # how many, and the cycle at which they were all there

    def _send_bytes(self, data):
        """Send bytes over the UART at the given baud rate, or over USB if there is no UART wire."""
        if self._wire:
            self._wire.feed(data, self._baud)
        else:
            self._pico.usb.write(data)

    def _take_answers(self, data):
        """Take the board's bytes, send a packet for each NEXT in them, and note the cycle at which all answers are there."""
        self._answers += data
        for _ in range(min(data.count(NEXT), len(self._packets))):
            self._send_bytes(self._packets.pop(0))
        if not self._ended and len(self._answers) >= self._wanted:
            self._ended = self._pico.cycle

    def send(self, count, window=WINDOW, hz=0):
        """Send `count` points, while three axes step `hz` times a second."""
        from passo.protocols.plotter.host import PACKET

        pico, console = self._pico, self._pico.console
        lines = [((int(rate * seconds),) * 3, rate) for rate, seconds in ((_START_HZ, _START_S), (hz, _LINE_S)) if hz]
        timed = [(deltas, ticks_of(deltas, rate)) for deltas, rate in lines]
        console.start(_LOOP.format(hz=hz, lines=timed, count=count))
        console.expect(b"ready\r\n")
        if not self._wire:
            pico.usb.heard = self._take_answers
        data = move_packets(count)
        self._packets = [data[at : at + PACKET] for at in range(window * PACKET, len(data), PACKET)]
        self._wanted, begun = count, pico.cycle
        self._send_bytes(data[: window * PACKET])
        if not pico.run_until(lambda: self._ended, _LIMIT_US, 500):
            raise TimeoutError(f"{len(self._answers)} of {count} answers")
        pico.usb.heard = console.text.extend
        console.text.extend(self._answers[count:])
        late, log = console.expect(b"\x04")[:-1].decode().split(" ", 1)
        rate = count * CYCLES_PER_US * 1e6 / (self._ended - begun)
        share = rate * PACKET * BITS_A_BYTE / self._baud if self._wire else 0
        lost = self._wire.overruns if self._wire else 0
        return Sent(rate, share, int(late), lost, bytes(self._answers[:count]), log.strip())

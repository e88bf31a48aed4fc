"""A machine with stored jobs and their journal, on which all kinds of orders come for long, in a heap that is bounded.

    MICROPYPATH=build/unix/STATE:tests_host/properties:tests_host/sims:. micropython -X heapsize=900k \\
        tests_host/properties/soak_memory.py BOARD ORDERS UPLOADS RESETS

Prints what MicroPython says of its memory a hundred times, all of it collected; at last the numbers of errors that were answered. Loading takes more memory
than running, and another heap than a board's: the script takes the memory left, but for LEFT.
"""

import gc
import os
import sys
from binascii import b2a_base64, crc32
from time import time_ns

import micropython

FLASH = bytearray(b"\xff" * 16_384)  # of the journal, in one piece: no part of a board's memory, it is made before the modules that are

from check_jobs import stored_form
from digest import board_named
from draws import Random
from fuzz_grbl import Port
from mixed_orders import job, mixed
from passo.app import App
from passo.config.boardfile import check
from passo.config.journal import FileSlots

PATIENCE = 20_000  # turns
SHOWN = 100  # times
LOCKED = b"error:9"
WIRED = "interlock", "gantry", "inverter", "encoders"  # options that want wires
LEFT = 62_000  # bytes that are free at the start, a tenth of those in use, as on a Pico


class Pages:
    """The journal's flash, in one piece."""

    BLOCKS, SLOTS, BYTES = 4, 128, 32

    def __init__(self):
        self._all = FLASH

    def read(self, block, slot):
        at = (block * self.SLOTS + slot) * self.BYTES
        return bytes(self._all[at : at + self.BYTES])

    def write(self, block, slot, data):
        at = (block * self.SLOTS + slot) * self.BYTES
        self._all[at : at + self.BYTES] = data

    def erase_block(self, block):
        for slot in range(self.SLOTS):
            self.write(block, slot, b"\xff" * self.BYTES)


class Board(Port):
    def __init__(self):
        Port.__init__(self)
        self.pages = Pages()

    def writing(self, on):
        pass

    def feed_watchdog(self):
        pass


class Sender:
    def __init__(self, name, folder):
        board = board_named(name)
        board.update({key: None for key in WIRED}, player="timer", journal={"every_ms": 500}, jobs={"language": "grbl", "folder": folder})
        for item in board["inputs"]:
            item.pop("filter_us", None)  # of an interlock
        board = check(board)
        self.port = Board()
        self.app = App(board, self.port, None, FileSlots(folder + "/settings"))
        self.random = Random(len(name))
        data = job(self.random)  # once: the PC's own work is not to count
        packed = stored_form(data)
        self._job = b",grbl,%d,%08x,%d" % (len(data), crc32(data) & 0xFFFFFFFF, len(packed))
        self._parts = [b"$F:" + b2a_base64(packed[at : at + 57]).strip() for at in range(0, len(packed), 57)]
        self.orders = 0
        self.errors = {}
        self.reset()

    def _await(self, found):
        """Run until `found` of the answers is true, and return them."""
        said = b""
        for _ in range(PATIENCE):
            self.app.cycle()
            said += self.port.outgoing
            self.port.outgoing = b""
            if found(said):
                return said
        raise AssertionError("no answer: %r" % said)

    def ask(self, line):
        self.orders += 1
        self.port.incoming = line + b"\n"
        said = self._await(lambda said: said.endswith(b"ok\r\n") or b"error:" in said and said.endswith(b"\r\n"))
        at = said.find(b"error:")
        if at >= 0:
            error = said[at:].split(b"\r\n")[0]
            self.errors[error] = self.errors.get(error, 0) + 1
            if error == LOCKED and line != b"$X":
                self.reset()
        return said

    def still(self):
        self.orders += 1
        self.port.incoming = b"?"
        while b"<Idle" not in self._await(lambda said: said.endswith(b">\r\n")):
            self.port.incoming = b"?"

    def reset(self):
        self.port.incoming = b"\x18"
        self._await(lambda said: b"for help]" in said)
        self.ask(b"$X")
        self.app.controller.queue.set_origin()  # the steps are on no machine

    def order(self):
        stands, lines = mixed(self.random)
        if stands:
            self.still()
        for line in lines:
            self.ask(line)

    def upload(self):
        """A job is sent, run or stopped, and replaced by the next."""
        self.still()
        name = self.random.choice((b"A", b"LONGER.GCODE"))
        self.ask(b"$FS=" + name + self._job)
        for part in self._parts:
            self.ask(part)
        assert self.ask(b"$FE") == b"ok\r\n"
        said = self.ask(b"$F=" + name)
        if self.random.between(0, 1):
            self.reset()
        elif b"[MSG:Job" not in said:
            self._await(lambda said: b"[MSG:Job" in said and b" done]" in said)


def soak(sender, orders, uploads, resets):
    parts = max(uploads, resets, SHOWN)
    done = [0, 0, 0]
    for part in range(1, parts + 1):
        while sender.orders < orders * part // parts:
            sender.order()
        for index, (count, action) in enumerate(((uploads, sender.upload), (resets, sender.reset), (SHOWN, shown))):
            if done[index] < count * part // parts:
                done[index] += 1
                action()


def shown():
    gc.collect()
    micropython.mem_info()


def main(arguments):
    folder = "%s/passo-memory-%d" % (os.getenv("TMPDIR") or "/tmp", time_ns())
    os.mkdir(folder)
    sender = Sender(arguments[0], folder)
    gc.collect()
    taken = ()
    while gc.mem_free() > LEFT:
        taken = (bytearray(64), taken)  # small: it takes the small pieces first that loading has left
    shown()
    soak(sender, *[int(word) for word in arguments[1:4]])
    print("errors", sender.errors, "orders", sender.orders)
    for name in os.listdir(folder):
        os.remove(folder + "/" + name)
    os.rmdir(folder)


if __name__ == "__main__":
    main(sys.argv[1:])

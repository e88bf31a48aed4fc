"""A small client of frames.md: sends a G-code file to a board, in frames, and shows what it answers.

    python frames_client.py /dev/ttyACM0 part.gcode

It needs pyserial. Frames are as long as one line; four are under way. Ctrl-C resets the board.
"""

import sys
import time
import zlib

import serial

HELLO = bytes.fromhex("000e100101010404121d19050c0f1500")
WELCOME, DATA, ACK, AGAIN, URGENT, CUT, REPORT, LEAVE, TAKEN, CLOSED = range(2, 12)  # kinds
FRAMES, CREDIT_BYTES, NUMBERS = 4, 64, 4096


def encode(kind, number, ack, credit, data=b""):
    """A frame with its delimiters."""
    body = (kind << 12 | number).to_bytes(2, "big") + (credit << 12 | ack).to_bytes(2, "big") + bytes([len(data)]) + data
    body += zlib.crc32(body).to_bytes(4, "little")
    return b"\0" + b"".join(bytes([len(part) + 1]) + part for part in body.split(b"\0")) + b"\0"


def decode(chunk):
    """(kind, number, ack, credit, data) of what stood between two delimiters; None if it is damaged."""
    body, at = bytearray(chunk), 0
    while at < len(body):
        body[at], at = 0, at + body[at]
    body = body[1:]
    if at != len(chunk) or len(body) < 9 or len(body) != body[4] + 9 or zlib.crc32(body[:-4]).to_bytes(4, "little") != body[-4:]:
        return None
    high, low = body[0] << 8 | body[1], body[2] << 8 | body[3]
    return high >> 12, high % NUMBERS, low % NUMBERS, low >> 12, bytes(body[5:-4])


class Board:
    def __init__(self, port):
        """Raises OSError if the board has no frames."""
        self.port, self.wire = serial.Serial(port, 115200, timeout=0.01), b""
        self.answers = b""  # of the board
        self.lines, self.flying = [], 0  # not yet acknowledged; so many of them are under way
        self.first = self.wanted = self.urgent = self.credit = 0  # numbers of: our first byte kept, the board's next, our next urgent frame
        self.open = self.begun = self.fresh = self.taken = False
        self.sent_at = self.asked_at = self.heard_at = 0.0
        while not self.fresh:  # a session that another program has left open is ended first
            self.hello(0.25)
            if not self.fresh:
                self.send(LEAVE, self.urgent)
                time.sleep(0.05)
        self.begun = True

    def hello(self, patience_s):
        """Send HELLO until WELCOME comes."""
        self.open = False
        end = time.monotonic() + patience_s
        while not self.open:
            if time.monotonic() > end:
                raise OSError("the board does not answer any more" if self.begun else "the board has no frames")
            self.port.write(HELLO)
            again = time.monotonic() + 0.08
            while not self.open and time.monotonic() < again:
                self.poll()

    def send(self, kind, number=0, data=b""):
        self.port.write(encode(kind, number, self.wanted, 15, data))

    def poll(self):
        """Understand what has come, then send what may be sent."""
        *chunks, self.wire = (self.wire + self.port.read(max(1, self.port.in_waiting))).split(b"\0")
        for chunk in filter(None, chunks):
            if found := decode(chunk):
                self.heard_at = time.monotonic()
                self.understand(*found)
            elif len(chunk) >= 10:
                self.ask_again()
        now = time.monotonic()
        if not self.open:
            return
        if not self.lines:
            self.heard_at = now
        elif now - self.heard_at > 0.25:
            self.hello(5)
        elif now - self.sent_at > 0.15:
            self.flying = 0
        bytes_flying = sum(map(len, self.lines[: self.flying]))
        while self.flying < min(FRAMES, len(self.lines)):
            line = self.lines[self.flying]
            if bytes_flying + len(line) > self.credit * CREDIT_BYTES:
                break
            self.send(DATA, (self.first + bytes_flying) % NUMBERS, line)
            bytes_flying, self.flying, self.sent_at = bytes_flying + len(line), self.flying + 1, now

    def understand(self, kind, number, ack, credit, data):
        if kind == CLOSED:
            raise OSError("answers of the board were lost")
        if kind == WELCOME:
            if not self.begun:
                self.first, self.wanted, self.urgent, self.fresh = ack, number, data[3] << 8 | data[4], data[1]
            elif data[1] and self.first:
                raise OSError("the board has been reset")
            self.open = True
            self.send(ACK)
        while self.lines and 0 < (ack - self.first) % NUMBERS < NUMBERS // 2:
            self.first = (self.first + len(self.lines.pop(0))) % NUMBERS
            self.flying = max(0, self.flying - 1)
        self.credit = credit
        if kind == AGAIN:
            self.flying = 0
        elif kind == TAKEN and number == self.urgent:
            self.first, self.urgent, self.taken = ack, (self.urgent + 1) % NUMBERS, True
        elif kind == DATA and self.open:  # else the board may read plain text
            known = (self.wanted - number) % NUMBERS
            if known > NUMBERS // 2:
                self.ask_again()
            else:
                self.answers += data[known:]
                self.wanted = (self.wanted + max(0, len(data) - known)) % NUMBERS
                self.send(ACK)

    def ask_again(self):
        if self.open and time.monotonic() - self.asked_at > 0.03:
            self.asked_at = time.monotonic()
            self.send(AGAIN)

    def reset(self):
        """Ctrl-X, ahead of all lines, which are dropped."""
        behind = (self.first + sum(map(len, self.lines[:FRAMES]))) % NUMBERS  # all that may have been sent
        self.lines, self.flying, self.taken = [], 0, False
        while not self.taken:
            self.send(CUT, self.urgent, behind.to_bytes(2, "big") + b"\x18")
            self.poll()


def main(port, file):
    board = Board(port)
    lines = [line.strip() + b"\n" for line in open(file, "rb") if line.strip()]
    board.lines = lines[:]
    try:
        while board.answers.count(b"ok") + board.answers.count(b"error") < len(lines):
            board.poll()
    except KeyboardInterrupt:
        board.reset()
    sys.stdout.write(board.answers.decode())
    board.send(LEAVE, board.urgent)


if __name__ == "__main__":
    main(*sys.argv[1:])

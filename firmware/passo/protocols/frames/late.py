"""Frames that come on a plain link: the link has left frames, and a frame of before comes late.

    late = Late(binary)
    text = late.without_frames(data, now_ms)    # what is for the language
    text = late.quiet(now_ms)                   # the same if nothing has come
    late.found                                  # frames dropped; the caller's to clear

00 begins a frame. It is dropped up to the next 00, and so is one that is cut off: after LONGEST bytes, when the rest of the line under
way is spoilt by a 00, or after 100 ms without a byte. Else the first line of a late frame would be refused, and its second one
carried out. In a language in which 00 is a byte like others (`binary`) only sound frames are dropped, and what begins with 00
is kept back for 4 ms at most.
"""

from micropython import const

from passo.protocols.frames.codec import LONGEST, sound
from passo.records import COUNT_MASK

_CUT_MS = const(100)  # without a byte: what has begun is cut off
_BINARY_MS = const(4)  # less than idle_gap_ms, so that no RESEND overtakes it


class Late:
    def __init__(self, binary):
        self._binary = binary
        self.held = b""  # what may be a frame, from its 00 on
        self._held_ms = 0
        self.found = 0

    def without_frames(self, data, now_ms):
        text = self.held + bytes(data)
        self.held = out = b""
        at = text.find(b"\0")
        while at >= 0:
            out += text[:at]
            text = text[at:]
            begin = 1
            while text[begin : begin + 1] == b"\0":
                begin += 1
            end = text.find(b"\0", begin)
            if end < 0 and len(text) - begin <= LONGEST:
                self.held = text
                self._held_ms = now_ms
                return out
            if self._binary:
                if begin < end <= begin + LONGEST and sound(bytearray(text), begin, end):
                    self.found += 1
                else:  # bytes of the language
                    end = begin
                    out += text[:begin]
            elif 0 <= end <= begin + LONGEST:
                self.found += 1
            else:
                self.found += 1
                end = begin + LONGEST
                out += b"\0"
            text = text[end:]
            at = text.find(b"\0")
        return out + text

    def quiet(self, now_ms):
        if not self.held or (now_ms - self._held_ms) & COUNT_MASK < (_BINARY_MS if self._binary else _CUT_MS):
            return b""
        text = self.held
        self.held = b""
        if self._binary:
            return text
        if text.strip(b"\0"):
            self.found += 1
        return b""

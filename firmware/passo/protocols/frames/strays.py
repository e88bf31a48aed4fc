"""Frames that come on a plain link: the link has left frames, and an old frame comes late.

    strays = Strays(binary, amid)
    text = strays.without_frames(data, now_ms)    # what is for the language
    text = strays.after_silence(now_ms)           # the same if nothing has come
    strays.found                                  # frames dropped; the caller's to clear

00 begins a frame. It is dropped up to the next 00, and so is one that is cut off: after LONGEST bytes, when the rest of the line under way
is spoilt by a 00, or after 100 ms without a byte. Else the first line of a late frame would be refused, and its second one carried out. A
message that had begun before the 00 is spoilt by a 00, because the bytes after the frame are not its end; the bytes within a second after a
frame that is cut off by silence are spoilt, too, because they may be its rest. In a language in which 00 is a byte like others (`binary`)
only sound frames are dropped, and bytes from a 00 on are kept back for 4 ms at most.
"""

from micropython import const

from passo.protocols.frames.codec import LONGEST, is_sound
from passo.records import COUNT_MASK

_CUT_MS = const(100)  # without a byte: a frame begun is cut off
_NO_REST_MS = const(1000)  # the same: no rest of it comes any more
_BINARY_MS = const(4)  # less than idle_gap_ms, so that no RESEND overtakes it


class Strays:
    def __init__(self, binary, amid):
        """`amid(text)`: True if the language, once it has read `text`, is amid a message; None: it has none of several bytes."""
        self._binary = binary
        self._asked = amid
        self.held = b""  # bytes that may be a frame, from its 00 on
        self._held_ms = 0
        self._cut = False  # the frame dropped last has not ended as a line does
        self.found = 0

    def without_frames(self, data, now_ms):
        """Return the bytes of `data`, and of those kept back, that are for the language."""
        text = self.held + bytes(data)
        self.held = out = b""
        at = text.find(b"\0")
        if self._cut and at:
            self._cut = False
            if (now_ms - self._held_ms) & COUNT_MASK < _NO_REST_MS:
                out = b"\0"
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
                if begin < end <= begin + LONGEST and is_sound(bytearray(text), begin, end):
                    self.found += 1
                else:  # bytes of the language
                    end = begin
                    out += text[:begin]
            else:
                self.found += 1
                cut = not 0 <= end <= begin + LONGEST
                if cut or self._is_amid(out):
                    out += b"\0"
                if cut:
                    end = begin + LONGEST
                else:
                    self._note_end(text[begin:end])
            text = text[end:]
            at = text.find(b"\0")
        return out + text

    def after_silence(self, now_ms):
        """Return the bytes kept back that are for the language, once the line has been silent for long enough; b"" before."""
        if not self.held or (now_ms - self._held_ms) & COUNT_MASK < (_BINARY_MS if self._binary else _CUT_MS):
            return b""
        text = self.held
        self.held = b""
        if self._binary:
            return text
        text = text.strip(b"\0")
        if text:
            self.found += 1
        if self._is_amid(b""):
            return b"\0"
        if text:
            self._note_end(text)
        return b""

    def _note_end(self, text):
        """Note whether the rest of a line may come behind the dropped bytes `text`."""
        self._cut = self._asked is not None and text[-1] not in b"\r\n" and not is_sound(bytearray(text), 0, len(text))

    def _is_amid(self, text):
        """Return True if the language, once it has read `text`, is amid a message."""
        return self._asked is not None and self._asked(text)

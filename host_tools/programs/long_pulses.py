"""Pulse files of any length on the PC: played from any command, backward, and repeated, as bytes to be streamed.

    file = LongFile("relief.txt", "xyz")
    file.total, file.seek(500_000).place        # commands; where the head is before one of them
    for chunk in file.play_forward(500_000): …       # bytes of a pulse file: the state there, then the rest
    for chunk in file.play_backward(500_000): …      # from there to the start: directions inverted, tool and speeds as they were

The file is read block by block; an index keeps the state at each block's beginning. A stream begins with `lead_of()` commands that
set the state; then it has one for each command of the file, in order: a position in the stream is a position in the file. Backward a wait,
and a question for the speed, become `*0`; at the start the drives go off.
"""

import re
import zlib
from dataclasses import dataclass

import numpy as np

from host_tools.failure import Failure, reason
from passo.protocols.pulses.errors import NO_CODE, NUMBER_MISSING

BLOCK = 1 << 18
_TOKEN = re.compile(rb"[A-Z\s]+|[*+]\d+|[\[\]()$@]")
_BLANK = b" \t\r\n"


@dataclass
class State:
    """Before a command of a file. `at`: its byte; `number`: commands before it; `place`: steps from the file's start."""

    at: int
    number: int
    place: tuple
    tool: bytes = b")"
    speed: bytes = b"@"
    drives: bytes = b""


class LongFile:
    def __init__(self, path, axes):
        """`axes`: names of those that the machine has. Raises Failure with line and column of the fault."""
        self._path = path
        self._axes = len(axes[:3])
        self._vectors = _step_vectors(self._axes)
        self._mirror = _mirror_table()
        self._index = []
        self.powers = False  # it has a [
        state = State(0, 0, (0,) * self._axes)
        for state_before, block in self._read_blocks(state):
            self._check_block(state_before, block)
            self._index.append(state_before)
            state = self._state_after(state_before, block)
            self.powers = self.powers or b"[" in block
        self._end = state
        self.total = state.number
        if not self.total:
            raise Failure("{} has no command", path)

    def _read_blocks(self, state):
        """Yield (state, bytes) of each block from `state` on; none ends amid a number."""
        at = state.at
        try:
            with open(self._path, "rb") as file:
                file.seek(at)
                while True:
                    block = file.read(BLOCK)
                    if not block:
                        return
                    while block[-1:] in b"*+0123456789" and (more := file.read(1)):
                        block += more
                    yield state, block
                    state = self._state_after(state, block)
        except OSError as error:
            raise Failure("cannot read {}: {}", self._path, reason(error)) from error

    def _check_block(self, state, block):
        """Check that each byte of a block belongs to a code, and each number is in its range. Raises Failure with line and column of the first that
        does not."""
        from host_tools.language import error_text
        from passo import errors
        from passo.protocols.pulses.codes import SPEED_MM_MIN, WAIT_MS

        at, error = 0, None
        for token in _TOKEN.finditer(block):
            text = token.group()
            if token.start() != at:
                break
            if text[:1] in b"*+" and int(text[1:]) > (WAIT_MS if text[:1] == b"*" else SPEED_MM_MIN)[1]:
                error = errors.NUMBER_RANGE
                break
            if not text[:1] in b"*+[]()$@":
                wrong = text.translate(None, self._vectors[0])
                if wrong:
                    at += text.index(wrong[:1])
                    break
            at = token.end()
        if at == len(block):
            return
        if error is None:
            error = NUMBER_MISSING if block[at : at + 1] in b"*+" else NO_CODE
        before = self._read_bytes(0, state.at) + block[:at]
        line, column = before.count(b"\n") + 1, at + state.at - (before.rfind(b"\n") + 1) + 1
        raise Failure("{}:{}:{}: error {}: {}", self._path, line, column, error, error_text(error))

    def _read_bytes(self, begin, end):
        with open(self._path, "rb") as file:
            file.seek(begin)
            return file.read(end - begin)

    def _state_after(self, state, block):
        """Return the State behind `block`."""
        codes = np.frombuffer(block, np.uint8)
        counts = np.bincount(codes, minlength=256)
        place = tuple(int(here + counts @ self._vectors[1][axis]) for axis, here in enumerate(state.place))
        number = state.number + int(counts[_COMMANDS].sum())
        found = State(state.at + len(block), number, place, state.tool, state.speed, state.drives)
        for token in re.finditer(rb"\+\d+|[$@()\[\]]", block):
            _note_code(found, token.group())
        return found

    # --- what can be asked

    def seek(self, number):
        """Return the State before command `number`, 0 … total. Raises Failure."""
        if not 0 <= number <= self.total:
            raise Failure("{} has {} commands: there is no place {}", self._path, self.total, number)
        if number == self.total:
            return self._end
        low = [state.number for state in self._index]
        state = self._index[int(np.searchsorted(low, number, "right")) - 1]
        block = next(self._read_blocks(state))[1]
        is_command = np.isin(np.frombuffer(block, np.uint8), _COMMANDS)
        at = int(np.searchsorted(np.cumsum(is_command), number - state.number + 1))
        return self._state_after(state, block[:at])

    def play_forward(self, number=0, times=1):
        """Yield chunks of bytes from command `number` to the end, and `times` − 1 times the whole file behind that."""
        state = self.seek(number)
        yield self._lead_codes(state, False)
        for _ in range(times):
            for _, block in self._read_blocks(state):
                yield block
            state = self._index[0]

    def play_backward(self, number=None):
        """Yield chunks of bytes that lead back from command `number`, by default the end, to the start."""
        state = self.seek(self.total if number is None else number)
        yield self._lead_codes(state, True)
        for index in range(len(self._index) - 1, -1, -1):
            begin = self._index[index]
            if begin.at < state.at:
                end = min(state.at, self._index[index + 1].at if index + 1 < len(self._index) else self._end.at)
                yield self._reverse_block(begin, self._read_bytes(begin.at, end))
        if self.powers and state.drives:
            yield b"]"  # as before the file's first [

    def job_number(self):
        """Return the number by which a board's journal knows this file: the CRC-32 of its codes, as of a stored job."""
        crc = 0
        for _, block in self._read_blocks(self._index[0]):
            crc = zlib.crc32(codes_of(block), crc)
        return crc or 1

    def highest_steps(self):
        """Return the highest position of the last axis, in steps from the file's start."""
        steps = self._vectors[1][-1]
        tops = [0]
        for state, block in self._read_blocks(self._index[0]):
            tops.append(state.place[-1] + int(np.cumsum(steps[np.frombuffer(block, np.uint8)]).max(initial=0)))
        return max(tops)

    def lead_of(self, number, backward):
        """Return how many commands set the state at `number`, in front of those of the file."""
        codes = self._lead_codes(self.seek(number), backward)
        return int(np.isin(np.frombuffer(codes, np.uint8), _COMMANDS).sum())

    def _lead_codes(self, state, backward):
        """Return the codes that set a state. Backward the drives are on, as they were on the way forward."""
        if not state.number:
            return b""
        drives = b"[" if backward and self.powers and state.drives else state.drives
        return drives + state.speed + state.tool

    def _reverse_block(self, begin, block):
        """Return the codes that play a block backward."""
        state = State(begin.at, 0, begin.place, begin.tool, begin.speed, begin.drives)
        parts = []
        for token in _TOKEN.finditer(block):
            text = token.group()
            if text[:1] in b"()":
                parts.append(state.tool)
            elif text[:1] in b"+$@" and text.strip(b"+0") != b"":
                parts.append(state.speed)
            elif text[:1] in b"*+[]":
                parts.append(b"*0")
            else:
                parts.append(text.translate(self._mirror)[::-1])
            _note_code(state, text)
        return b"".join(reversed(parts))


def codes_of(data):
    """Return the bytes of a pulse file without its blanks."""
    return data.translate(None, _BLANK)


def _note_code(state, text):
    """Change `state` by a code that sets one. `+0` leaves the speed to the operator: the one before it is the best guess."""
    if text in (b"(", b")"):
        state.tool = text
    elif text in (b"[", b"]"):
        state.drives = text
    elif text[:1] in b"+$@" and text.strip(b"+0") != b"":
        state.speed = text


def _step_vectors(axes):
    """Return (the codes and blanks that are allowed, the steps of each axis by byte)."""
    from passo.protocols.pulses.codes import CODES

    steps = np.zeros((axes, 256), np.int64)
    allowed = bytearray(_BLANK)
    for letter, code in enumerate(CODES):
        if not (code & 7) >> axes:
            allowed.append(65 + letter)
            for axis in range(axes):
                if code >> axis & 1:
                    steps[axis, 65 + letter] = -1 if code >> 4 + axis & 1 else 1
    return bytes(allowed), steps


def _mirror_table():
    """Return the table that translates each step's code to that of the opposite step."""
    from host_tools.programs.pulse_file import letter_of
    from passo.protocols.pulses.codes import CODES

    table = bytearray(range(256))
    for letter, code in enumerate(CODES):
        mask = code & 7
        table[65 + letter] = ord(letter_of(mask, (code >> 4 & 7) ^ mask))
    return bytes(table)


_COMMANDS = np.frombuffer(b"ABCDEFGHIJKLMNOPQRSTUVWXYZ[]()$@*+", np.uint8)

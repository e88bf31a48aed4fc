"""A board's black box, as firmware/passo/options/blackbox/control.py keeps it: read, and said as text.

    files = {name: bytes}                   # blackbox.bin, board.py, settings.0, settings.1, crash.txt, as far as the board has them
    path.write_bytes(pack_files(files))         # one file
    box = Box.from_files(unpack_files(path.read_bytes()))
    box.rows, box.snapshots, box.text       # Row, Snapshot; the bytes of the link from `box.base` on
    box.start()                             # the snapshot from which it can be replayed
"""

import io
import struct
import zipfile
from dataclasses import dataclass
from functools import cached_property

from host_tools import boards
from host_tools.failure import Failure, reason
from passo.options.blackbox.config import (
    BOX_ADDED, BOX_AT, BOX_BASE, BOX_END, BOX_FIRST, BOX_HEAD,
    BOX_MAGIC_0, BOX_MAGIC_1, BOX_NUMBERS, BOX_ROW, BOX_ROWS, BOX_SAMPLED, BOX_SAMPLES, BOX_SNAPSHOT, BOX_SNAPSHOTS, BOX_TAKEN, BOX_TEXT,
    NAME, OLD, box_head,
)  # fmt: skip
from passo.config.boardfile import BoardError, check
from passo.options.blackbox.control import ALARM, DROPPED, HALTED, HOMED, INPUTS, LOGGED, ORDER, SAMPLE, STATES, STOOD, WAITS

PLACES = (HALTED, DROPPED, STOOD, SAMPLE)  # rows with a position
STOPS = (HALTED, DROPPED, STOOD)
FILE, BOARD_FILE = NAME, "board.py"
FILES = NAME, OLD, BOARD_FILE, "settings.0", "settings.1", "crash.txt", "last_crash.txt"  # of the board, as far as it has them
_FIRST_LINE = b"passo blackbox "
_MOST_BYTES = 1 << 20


@dataclass
class Row:
    """`ms` since the board's start; `come`, `taken`: bytes of the stream by then."""

    kind: int
    ms: int
    come: int
    taken: int
    value: int  # blocks played, a number, a command
    position: list
    override: int = 100
    state: str = ""
    levels: dict = None  # of inputs: {name: active}


@dataclass
class Snapshot:
    ms: int
    taken: int
    rows: int  # of all that were made, those before it
    added: int
    flags: int
    position: list
    modal: list  # as protocols/grbl/log.py writes it

    @property
    def backlash_taken(self):
        """The steps of backlash that are taken up at the snapshot's position, of each axis."""
        return [self.flags >> 3 + 7 * axis & 127 for axis in range(len(self.position))]


@dataclass
class Box:
    why: str  # "alarm", "end" (of the app: crash or REPL), "reset" (watchdog, button)
    board: dict
    rows: list
    samples: list  # rows, too
    first: int  # number of the oldest row
    snapshots: list
    base: int
    text: bytes
    taken: int
    settings: tuple = (b"", b"")
    crash: str = ""
    table: dict = None  # the board file's, unchecked

    @classmethod
    def from_files(cls, files, older=False):
        """Return the newest box of a board's files; `older`: the one before. Raises Failure if there is none."""
        if FILE not in files or BOARD_FILE not in files:
            raise Failure("there is no black box in it: {} and {} are wanted", FILE, BOARD_FILE)
        if older and OLD not in files:
            raise Failure("there is no older black box")
        table, board = board_of(files[BOARD_FILE])
        box = read(files[OLD if older else FILE], board)
        box.table = table
        box.settings = files.get("settings.0", b""), files.get("settings.1", b"")
        box.crash = files.get("crash.txt", b"").decode("utf-8", "replace")
        return box

    def start(self):
        """Return the oldest snapshot at which a replay can begin: behind the last homing, its bytes still there, no line half done; None if there is
        none."""
        fit = []
        for before, snapshot in zip([None, *self.snapshots], self.snapshots):
            if before and snapshot.flags & HOMED and not before.flags & HOMED:
                fit = []
            if snapshot.taken >= self.base and not snapshot.flags & WAITS and snapshot.rows >= self.first:
                fit.append(snapshot)
        return next((snapshot for snapshot in fit if self._before_stops(snapshot)), None)

    def _before_stops(self, snapshot):
        """True if the machine passed the position of `snapshot` before its next stop: lines wait in a queue."""
        stop = next((row for row in self.rows_since(snapshot) if row.kind in PLACES), None)
        return stop is None or stop.value >= snapshot.added

    def rows_since(self, snapshot):
        """Return the rows behind a snapshot, and the samples among them, by their time."""
        rows = self.rows[max(snapshot.rows - self.first, 0) :]
        samples = [row for row in self.samples if row.ms >= snapshot.ms and (row.taken > snapshot.taken or row.value >= snapshot.added)]
        return sorted(rows + samples, key=lambda row: (row.ms, row.kind == SAMPLE))

    @cached_property
    def end_ms(self):
        return max([row.ms for row in self.rows + self.samples] + [each.ms for each in self.snapshots])

    def bytes_from(self, taken):
        return self.text[taken - self.base :]


def board_of(text):
    """Return (table, the same checked) of a board file's text. The text is data: nothing of it runs. Raises Failure."""
    try:
        table = boards.parse_table(text, "board.py")
        return table, check(table)
    except (Failure, BoardError) as error:
        raise Failure("the board file beside the black box: {}", error if isinstance(error, Failure) else reason(error)) from error


def file_of(why, numbers, text):
    """Return the bytes of a file blackbox.bin, as a board writes them whose byte order is this computer's."""
    return box_head(why) + numbers + text


def pack_files(files):
    """Pack {name: bytes} into the bytes of one file, a ZIP archive."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0)), files[name])
    return made.getvalue()


def unpack_files(data):
    """Unpack such a file; return {name: bytes}. Raises Failure."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return {item.filename: archive.read(item) for item in archive.infolist() if item.file_size <= _MOST_BYTES}
    except zipfile.BadZipFile as error:
        raise Failure("this is no file that passo blackbox has written: {}", error) from error


def read(data, board):
    """Read a Box. Raises Failure if `data` is none."""
    first, _, rest = data.partition(b"\n")
    numbers = rest[: 4 * BOX_NUMBERS]
    if not first.startswith(_FIRST_LINE) or len(rest) < 4 * BOX_NUMBERS + BOX_TEXT:
        raise Failure("this is no black box, or not a whole one")
    _, _, version, platform, why = first.decode("ascii", "replace").split()
    numbers = struct.unpack(f"<{BOX_NUMBERS}i", numbers)
    if version != "2" or numbers[0] & 0xFFFFFF00 != BOX_MAGIC_0 & 0xFFFFFF00 or numbers[1:3] != (BOX_MAGIC_1, BOX_TEXT):
        raise Failure("this black box is of another version of Passo than these tools")
    added, taken = numbers[BOX_ADDED], numbers[BOX_TAKEN]
    oldest = max(added - BOX_ROWS, 0)
    rows = [_row_of(numbers, BOX_HEAD + count % BOX_ROWS * BOX_ROW, board, platform) for count in range(oldest, added)]
    sampled = numbers[BOX_SAMPLED]
    places = [BOX_ROWS + count % BOX_SAMPLES for count in range(max(sampled - BOX_SAMPLES, 0), sampled)]
    samples = [_row_of(numbers, BOX_HEAD + place * BOX_ROW, board, platform) for place in places]
    snapshots = [_snapshot_of(numbers, BOX_FIRST + count % BOX_SNAPSHOTS * BOX_SNAPSHOT, board) for count in range(max(taken - BOX_SNAPSHOTS, 0), taken)]
    text = rest[4 * BOX_NUMBERS :][: numbers[BOX_END]]
    return Box(why, board, rows, samples, oldest, snapshots, numbers[BOX_BASE], text, numbers[BOX_BASE] + numbers[BOX_AT])


def _row_of(numbers, at, board, platform):
    """Return the Row in BOX_ROW numbers from index `at`: with a position if its kind is of PLACES, override (%) and state of a sample, or the levels
    of inputs."""
    fields = numbers[at : at + BOX_ROW]
    kind = fields[0] & 0xFF
    row = Row(kind, fields[1], fields[2], fields[3], fields[4], list(fields[5 : 5 + len(board["axes"])]) if kind in PLACES else [])
    if kind == SAMPLE:
        row.override, row.state = fields[0] >> 8 & 0xFF, STATES[fields[0] >> 16]
    if kind == INPUTS:
        row.levels = _input_levels(fields[4] | fields[5] << 16, board, platform)
    return row


def _input_levels(bits, board, platform):
    """Return {input: active} of `bits` from port.levels(). On an RP2 bit n is pin n; elsewhere the last input is bit 0, the one before it bit 1, and
    so on. A bit is the level of its pin; on an ESP32 1 is active."""
    inputs = board["inputs"]
    if platform == "rp2":
        return {item["name"]: bits >> item["pin"] & 1 == item["active"] for item in inputs if item["pin"] < 32}
    places = range(len(inputs) - 1, -1, -1)
    return {item["name"]: (bits >> place & 1) == (1 if platform == "esp32" else item["active"]) for item, place in zip(inputs, places)}


def _snapshot_of(numbers, at, board):
    fields = numbers[at : at + BOX_SNAPSHOT]
    return Snapshot(*fields[:5], list(fields[5 : 5 + len(board["axes"])]), list(fields[9:]))

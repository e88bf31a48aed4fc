"""A drawing as the board's journal knows it: points counted through all its objects; and as a file of packets.

    spot = spot_of(record, objects)         # where it goes on
    announce_rest(client, objects, spot)         # what comes next is that drawing
    client.point(False, *spot.start(objects))
"""

import zlib
from typing import NamedTuple, Optional

from host_tools.clients.refusal import Refused
from host_tools.failure import Failure, reason
from host_tools.language import _
from host_tools.programs.job_record import DONE
from passo import errors
from passo.protocols.plotter.host import COMMANDS, PACKET, packet

_REPEATED = 20  # points that a noisy line may have stored twice: the board has counted them


class Spot(NamedTuple):
    """`number`: of the object; `drawn`: points of it; `done`: of all; `position`: amid the line that is to be gone on with, or None."""

    number: int
    drawn: int
    done: int = 0
    position: Optional[tuple] = None

    def start(self, objects):
        """Return the pen's position, (x, y) in steps, at which the drawing goes on. At least one point must be drawn."""
        before = objects[self.number][self.drawn - 1] if self.drawn else objects[self.number - 1][-1]
        return self.position or before[1:]

    def __str__(self):
        return _("in the line to point {}", self.done + 1) if self.position else _("before point {}", self.done + 1)


def packets_of(objects, home=False, speed=None):
    """Return the bytes of the packets that draw `objects`."""
    parts = [packet(COMMANDS["ORIGIN"])] if home else []
    if speed is not None:
        parts.append(packet(COMMANDS["SPEED"], speed))
    for points in objects:
        parts += [packet(COMMANDS["LINE" if down else "MOVE"], x, y) for down, x, y in points]
        parts.append(packet(COMMANDS["END"]))
    return b"".join(parts)


def write_packets(path, objects, home, speed):
    """Write a file of packets. Raises Failure if that cannot be."""
    try:
        path.write_bytes(packets_of(objects, home, speed))
    except OSError as error:
        raise Failure("cannot write {}: {}", path, reason(error)) from error


def objects_of(data):
    """Return (objects, speed or None) of a file's packets, which must be right."""
    objects, speed = [[]], None
    for at in range(0, len(data), PACKET):
        code, x, y = data[at], data[at + 1] << 8 | data[at + 2], data[at + 3] << 8 | data[at + 4]
        if code in (COMMANDS["LINE"], COMMANDS["MOVE"]):
            objects[-1].append((code == COMMANDS["LINE"], x, y))
        elif code == COMMANDS["END"]:
            objects.append([])
        elif code == COMMANDS["SPEED"]:
            speed = x
    return [points for points in objects if points], speed


def number_of(objects):
    """Return the number by which a board's journal knows the drawing: the CRC-32 of its packets."""
    return zlib.crc32(packets_of(objects)) or 1


def numbers_of_stored(objects, speed):
    """Return the numbers by which the journal knows the drawing as a stored job."""
    return [zlib.crc32(packets_of(objects, home, each)) or 1 for home in (False, True) for each in {None, speed}]


def spot_of(record, objects):
    """Find the point at which a drawing goes on, by the board's journal; return a Spot. Raises Failure if the drawing is done, or the position is
    not on its lines."""
    points = [point for each in objects for point in each]
    line, position = record.line, tuple(record.place[:2])
    if record.done and line >= len(points) and (not points or points[-1][1:] == position):
        raise Failure("the drawing was done to its end")
    if not line or not record.done and line == 1:
        return _spot_after(objects, 0, None)
    for done in range(line, max(line - _REPEATED, 0), -1):
        if done > len(points):
            continue
        down, *end = points[done - 1]
        if record.done:
            if tuple(end) == position:
                return _spot_after(objects, done, None)
        elif done > 1 and _is_on_line(points[done - 2][1:], end, position):
            return _spot_after(objects, done - 1, position if down else None)
    raise Failure("the journal's place is not on the drawing's lines: passo draw --continue draws the line again")


def spot_at(objects, number, drawn):
    """Return the Spot before a point of an object."""
    return Spot(number, drawn, sum(len(points) for points in objects[:number]) + drawn)


def _spot_after(objects, done, position):
    """Return the Spot behind the first `done` points of all objects; `position`: amid a line, (x, y) in steps, or None."""
    left = done
    for number, points in enumerate(objects):
        if left < len(points) or number + 1 == len(objects):
            return Spot(number, left, done, position)
        left -= len(points)
    return Spot(0, 0)


def _is_on_line(start, end, position):
    """True if a position is on a line, to a step."""
    length = [to - at for at, to in zip(start, end)]
    way = [to - at for at, to in zip(start, position)]
    if any(part * whole < 0 or abs(part) > abs(whole) for part, whole in zip(way, length)):
        return False
    return abs(way[0] * length[1] - way[1] * length[0]) <= max(abs(length[0]), abs(length[1]))


def announce_rest(client, objects, spot):
    """Tell a board with a journal that the rest of the drawing begins. If anything is drawn, the first point to come leads to `spot.start`."""
    line = f"$JR={number_of(objects):08x},{spot.done + 1 if spot.position else spot.done},{0 if spot.position else DONE},{1 if spot.done else 0}"
    if spot.done:
        line += ",%d,%d" % tuple(spot.start(objects))
    try:
        client.ask(line)
    except Refused as refused:
        if refused.number != errors.STATEMENT:
            raise

"""Finds the line at which a program of G-code was interrupted, by the board's journal, and the way to go on."""

import binascii

from host_tools.failure import Failure
from host_tools.programs.job_record import Record


def number_of(lines):
    """Return the number by which a board's journal knows a program: the CRC-32 of its lines."""
    return binascii.crc32(b"\n".join(line for _, line in lines)) or 1


def resume_point(said, lines, stored=0):
    """Return (line to begin at, place in steps or None, whether the position is known) of an answer to `$JR`. `stored`: the CRC-32 of the same
    program as a stored job. Raises Failure if the journal is of another program, or this one has been done."""
    record = Record.of_job(said)
    line = record.line
    if record.job not in (number_of(lines), stored):
        raise Failure("the board's journal is of another file, or the file has changed; begin at a line with passo stream --from")
    if not line:
        return lines[0][0], None, record.is_known
    if record.done:
        if line >= lines[-1][0]:
            raise Failure("the file was done to its end")
        return line + 1, None, record.is_known
    return line, record.place, record.is_known


def end_position(said):
    """Return the end, in steps, of the line that an answer to `$JR` says is done; before the first line the place where the program began; None amid
    a line."""
    record = Record.of_answer(said)
    return record.place if record.done or not record.line else None


def plan_stages(machine, lines, number, place=None, end=None, sure=True):
    """(stages, rest, dot) as a Replay gives them, of a `machine` as it says it is, for line `number`, or `place` (steps) on its way. `end`: where
    a program that was interrupted had been before that line, steps. `sure`: the position is known, also that of an axis without a sensor.
    Raises Failure."""
    from host_tools.programs import replay
    from host_tools.programs.replay_machine import ENDLESS

    left = place or end
    if left and machine.turns & ENDLESS and not sure:
        raise Failure(
            "A homes at no sensor and counts from where it stood when the board was switched on; the program left it at {:.3f} degrees: turn it back by "
            "as much, switch the board off and on, then give --home --unverified",
            left[-1] / machine.steps_per_mm[-1],
        )
    state = replay.Replay(machine, lines)
    row = _row_left(machine, lines, number, end) if end and place is None else None
    if row:
        number, place = row, end
    if place or end:
        state.check_offsets(number)
        state = state.from_start(number, place or end, place is None)
    stages, rest = state.from_line(number, end) if place is None else state.from_place(number, place)
    return stages, rest, state.dot


def _row_left(machine, lines, number, end):
    """The line before `number` if it is a row of dots and `end` lies on it: a row is gone on with by several lines of its number, and the
    last that is done need not be its end. Else None."""
    from host_tools.programs import replay

    before = [known for known, _ in lines if known < number]
    state = replay.Replay(machine, lines)
    try:
        if before:
            state.from_place(before[-1], end)
    except Failure:
        return None
    return before[-1] if state.dot else None

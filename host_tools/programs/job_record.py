"""The job in a board's journal, and the consequences for the machine's zero."""

import re
from typing import NamedTuple

from host_tools.failure import Failure

DONE, KNOWN, BACK = 1, 2, 4  # flags
_JOURNAL = re.compile(r"\[JOURNAL:([0-9a-f]+)\|(\d+)\|(\d+)\|([-\d,]+)\]")


class Record(NamedTuple):
    """An entry of a board's journal. `place`: steps of each axis."""

    job: int
    line: int
    flags: int
    place: list

    @classmethod
    def of_answer(cls, said):
        """Read the record in the lines that answer `$JR`. Raises Failure if there is none."""
        found = _JOURNAL.search("\n".join(said))
        if not found:
            raise Failure("the board does not say where its job is")
        return cls(int(found[1], 16), int(found[2]), int(found[3]), [int(part) for part in found[4].split(",")])

    @classmethod
    def of_job(cls, said):
        """Read the record in the lines that answer `$JR`. Raises Failure also if the journal is empty."""
        record = cls.of_answer(said)
        if not record.job:
            raise Failure("the board's journal is empty: no program was interrupted")
        return record

    @property
    def done(self):
        return bool(self.flags & DONE)

    @property
    def is_known(self):
        """True if the machine's position is known."""
        return bool(self.flags & KNOWN)


def find_zero(known, home, unverified, homes):
    """Home if it is asked for; go on with a position that is not `known` only if the operator says so. Raises Failure."""
    if home:
        homes()
    elif not known and not unverified:
        raise Failure("where the machine stands is not known since then: give --home; or --unverified, if you have seen that zero is right")

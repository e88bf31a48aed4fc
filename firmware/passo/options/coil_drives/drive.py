"""Motors whose coils are switched by the board itself: a table from phase to pin levels, and an index that goes ±1.

Each motor owns its own bits of a word, so that stepping one never disturbs another. The phase is the motor's position
modulo the table's length: after a stop it is found again from the position alone.

    drive = CoilDrive(axes=2, table=MODES["half"], width=4)              # of options/drive_unipolar
    drive.apply(words, 0, 10)            # ten words in the step form become pin levels
"""

import micropython

from passo.options.coil_drives.drive_viper import apply, tally


class CoilDrive:
    pins = ()  # names of a motor's, lowest bit first: see of_board()

    def __init__(self, axes, table, width, hold=None, reversed_mask=0, off=0):
        """`table`: levels of `width` pins a phase, its length a power of two; `hold`: the same phases at the standstill
        current (default: `table`); `reversed_mask`: axes that run through the tables backwards; `off`: levels without
        current."""
        count = len(table)
        self._last = count - 1
        self.axes = axes
        self.width = width
        self._mask = (1 << width) - 1
        self._table = [self._levels_by_phase(table, reversed_mask >> axis & 1) for axis in range(axes)]
        self._hold = [self._levels_by_phase(hold or table, reversed_mask >> axis & 1) for axis in range(axes)]
        self._live = b"".join(self._table)
        self._off = off
        self._phase = bytearray(axes)
        self.cut_current(0)

    def levels_off(self):
        """Return the levels of all motors without current."""
        levels = 0
        for axis in range(self.axes):
            levels |= self._off << axis * self.width
        return levels

    @staticmethod
    def _levels_by_phase(table, backwards):
        """Return a motor's table as bytes, for one that runs backwards in reverse order."""
        return bytes([table[-phase % len(table)] for phase in range(len(table))]) if backwards else bytes(table)

    @micropython.native
    def apply(self, words, at, count):  # ISR: no allocation
        """Turn words[at : at + count] from the step form into this drive's pin levels; the tool bit and time stay."""
        apply(words, at, count, self.axes, self.width, self._last, self._tables, self._phase)

    def cut_current(self, mask):
        """The axes of `mask` are without current in all that is made from now on; the others have theirs."""
        self._unpowered = mask
        self._tables = b"".join(self._tables_in_force(self._table))

    def _tables_in_force(self, tables):
        """Return the axes' tables, with the levels without current for those of _unpowered."""
        off = bytes([self._off] * (self._last + 1))
        return [off if self._unpowered >> axis & 1 else tables[axis] for axis in range(self.axes)]

    def levels(self):
        """Return the levels that hold all motors where they are, at running current."""
        return self._levels_in(self._table)

    def levels_at_rest(self):
        """Return the levels that hold all motors where they are, at standstill current."""
        return self._levels_in(self._hold)

    def _levels_in(self, tables):
        """Return the levels of all motors at their phases in `tables`."""
        tables = self._tables_in_force(tables)
        levels = 0
        for axis in range(self.axes):
            levels |= tables[axis][self._phase[axis]] << axis * self.width
        return levels

    def seek(self, position):
        """Take the phases that belong to `position`, steps since power-up of each axis."""
        for axis in range(self.axes):
            self._phase[axis] = position[axis] & self._last

    def tally(self, words, mask, word, until, position):
        """Add the steps made by the words of a ring from count `word` to `until` to `position`, where the machine stands
        before them; returns how many of them step."""
        return tally(words, mask, word, until, self.axes, self.width, self._last, self._live, self._off, position)

    def step_between(self, axis, before, after):
        """Return the step of an axis between the levels of two neighbouring words: −1, 0 or +1."""
        shift = axis * self.width
        before = before >> shift & self._mask
        after = after >> shift & self._mask
        if before == after:
            return 0
        table = self._table[axis]
        return 1 if table[(table.find(bytes([before])) + 1) & self._last] == after else -1


def of_board(board, pins, table, off, hold=None):
    """Return the CoilDrive of a checked board's motors. `pins`: names of one motor's, lowest bit first; `table`, `off`, `hold`: as of CoilDrive."""
    backwards = 0
    axes = board["axes"]
    for axis in range(len(axes)):
        backwards |= axes[axis]["reversed"] << axis
    drive = CoilDrive(len(axes), table, len(pins), hold, backwards, off)
    drive.pins = pins
    return drive

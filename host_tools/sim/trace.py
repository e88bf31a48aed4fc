"""The trace: a CSV file of the machine's positions over time, as the plant decoded them from the pins.

    trace = Trace("square.csv", plant)      # or None: keep the rows in memory, for `rows()`
    ...
    trace.rezero(plant.position)            # the machine has homed: this is its origin
    trace.close()

    t_us,x,y,z,a,tool                       a first row with the initial state, then one a word that steps an axis
    0.000,0,0,0,0,0                         and one for each arrival of the tool
    1222.000,1,0,0,0,0

`t_us` is virtual time since the start at the leading edge; x…a are steps from the machine's origin (from the start, if it never
homed), 0 for missing axes; tool is 0…1000. The whole file has one zero: homing rewrites the rows before it. `skip_ticks` leaves
out time.
"""

import os
from operator import sub
from pathlib import Path

HEADER = "t_us,x,y,z,a,tool"
COLUMNS = "xyza"
BATCH_ROWS = 8192


class Trace:
    """Listens to `plant`. Axes named x, y, z, a are in the columns of their names, others in their order."""

    def __init__(self, path, plant):
        self._path = None if path is None else Path(path)
        self._zero = list(plant.position)
        self._rows = []
        self._written = 0
        self._skipped = 0  # ticks left out so far
        names = [carriage.name for carriage in plant.carriages]
        in_order = all(name in COLUMNS for name in names) and names == sorted(names, key=COLUMNS.index)
        self._columns = [COLUMNS.index(name) if in_order else i for i, name in enumerate(names)]
        marks = ["%d" if column in self._columns else "0" for column in range(len(COLUMNS))]
        self._mark = "%d.%02d0," + ",".join(marks) + ",%d\n"
        self._file = None
        if self._path is not None:
            self._file = open(self._path, "w", encoding="ascii", newline="\n")
            self._file.write(HEADER + "\n")
        plant.trace = self
        self.add_row(0, plant.position, plant.tool)

    def add_row(self, tick, position, tool):
        """A step or an arrival of the tool at `tick`; `position` in the plant's steps."""
        rows = self._rows
        rows.append((tick - self._skipped, *position, tool))
        if len(rows) >= BATCH_ROWS and self._file is not None:
            self.flush()

    def skip_ticks(self, ticks):
        """Leave out `ticks` that have passed since the last row and before the next."""
        self._skipped += ticks

    def flush(self):
        """Write buffered rows."""
        if self._file is None:
            return
        self._file.write("".join(self._csv_lines(self._rows)))
        self._file.flush()
        self._written += len(self._rows)
        self._rows.clear()

    def rezero(self, origin):
        """Make the plant's position `origin` the machine's zero, for rows already written too."""
        shift = [old - new for old, new in zip(self._zero, origin)]
        if not any(shift):
            return
        if self._written:
            self.flush()
            self._rewrite_file(shift)
        self._zero = list(origin)

    def rows(self):
        """Return [(t_us, x, y, z, a, tool)] of the rows kept in memory: all of them if there is no file."""
        lines = (line.split(",") for line in self._csv_lines(self._rows))
        return [(float(line[0]), *map(int, line[1:])) for line in lines]

    def close(self):
        """Write the rows that wait, and close the file; a second call does nothing."""
        if self._file is not None:
            self.flush()
            self._file.close()
            self._file = None

    def _csv_lines(self, rows):
        """Yield rows as lines of CSV: µs with two decimals, and steps from zero."""
        mark = self._mark
        zero = (*self._zero, 0)
        for row in rows:
            tens_ns = row[0] * 8  # a tick is 80 ns, so a µs has two decimals
            yield mark % (tens_ns // 100, tens_ns % 100, *map(sub, row[1:], zero))

    def _rewrite_file(self, shift):
        """Shift every row by writing a second file, so that there is a whole file at any moment."""
        self._file.close()
        moved = self._path.with_name(self._path.name + ".part")
        with open(self._path, encoding="ascii") as old, open(moved, "w", encoding="ascii", newline="\n") as new:
            new.write(next(old))
            for line in old:
                fields = line.rstrip().split(",")
                for column, by in zip(self._columns, shift):
                    fields[column + 1] = str(int(fields[column + 1]) + by)
                new.write(",".join(fields) + "\n")
        os.replace(moved, self._path)
        self._file = open(self._path, "a", encoding="ascii", newline="\n")

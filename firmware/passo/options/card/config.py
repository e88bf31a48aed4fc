"""Stored jobs on a memory card. FAT replaces no file at once, so nothing is renamed here: a power cut between two writes could
lose a file, or leave two names for one.

A job is in one of two files, NAME.job or NAME.alt, in the form of jobs/config.py, and one byte more. An upload goes to the one
that is free. It counts once that last byte is there: it is written when the upload has been read back, right and whole. Then the
other file goes. If both count, the power was cut in between: either is whole, and one of them is used. An upload that was cut off is
shorter than its first line says, or has none: it is no job, and is removed by the next list. A file whose first line is wrong is
damaged, and stays. To find a file takes the card's driver some 4 ms for five others in the folder: of the files of a job each is looked
for once.
"""

import os

from micropython import const

from passo.options.jobs.config import HEAD_BYTES, JobStore, parse_first_line

END_MARK = b"\n"
_TORN = const(1)  # an upload that was cut off
_DAMAGED = const(2)  # its first line is wrong: it stays, and the list says so
_COUNTS = const(3)


def _file_state(path):
    """Return (state, parsed first line) of a file. The state is 0 if the path does not exist or is a folder."""
    try:
        with open(path, "rb") as file:
            line = file.readline(HEAD_BYTES)
            size = file.seek(0, 2)
    except OSError:
        return 0, None
    head = parse_first_line(line)
    if head is None:
        return _DAMAGED if size >= HEAD_BYTES or line[-1:] == b"\n" else _TORN, None
    return _TORN if size < len(line) + head[3] + len(END_MARK) else _COUNTS, head


class CardStore(JobStore):
    _is_flash = False
    _ends = (".job", ".alt")

    def _read_first_line(self, name):
        """Return (whether it is a job, its parsed first line or None). Removes an upload that was cut off."""
        _, state, head = self._counting_file(name, True)
        return state != _TORN, head  # a folder counts as damaged, too

    def _counting_file(self, name, tidy=False):
        """Return (path, state, first line) of the file that counts for a job. `tidy`: remove an upload that was cut off."""
        path = self._folder + name + self._ends[1]
        other = self._other_file(path)
        state, head = _file_state(path)
        there, first = _file_state(other)
        for each, found in ((path, state), (other, there)) if tidy else ():
            if found == _TORN and each != self._upload:
                self._remove_file(each)
        return (path, state, head) if state and state >= there else (other, there, first)

    def _job_path(self, name):
        """Return the path of the file that counts."""
        return self._counting_file(name)[0]

    def open(self, name, language=None):
        """Return a JobFile, see JobStore.open(). Raises OSError if there is no whole file of that name."""
        path, state, _ = self._counting_file(name)
        if state == _TORN:
            raise OSError(2)
        return self._open_job(path, language)

    def delete_job(self, name):
        """Remove both files of a job, the one that counts first. Raises OSError."""
        path = self._job_path(name)
        os.remove(path)
        self._remove_file(self._other_file(path))

    def _other_file(self, path):
        """Return the path of a job's second file."""
        return path[:-4] + self._ends[path.endswith(self._ends[0])]

    def _upload_path(self, name):
        """Return the path that an upload goes to: the file that does not count."""
        path, state, _ = self._counting_file(name)
        return self._other_file(path) if state == _COUNTS else path

    def commit_upload(self):
        """Write the byte by which the upload counts, then remove the other file. Raises OSError."""
        path = self._upload
        with open(path, "ab") as file:
            file.write(END_MARK)
        self._upload = ""
        self._remove_file(self._other_file(path))

"""Stored jobs: a file each, in a folder of the board's flash or of a memory card.

    store = JobStore("/jobs")
    store.mount()
    store.begin("PART.NC", "grbl", size, crc, stored)       # an upload
    store.add_data(data)                                    # until it has `stored` bytes
    job = store.open_upload()                               # read it to its end: it raises Damaged if it is not right
    store.commit_upload()                                   # now it is there, in place of an older one of that name
    job = store.open("PART.NC")
    job.readinto(view)
    store.close(job)

A file is one line of text and the job's bytes behind it, deflated (RFC 1951, window of 1 kB):

    job <language> <bytes of the job> <their CRC-32> <bytes behind this line> <CRC-32 of this line so far>\\n

An upload has a name of its own until it has been read back whole: a power cut, a full memory or a wrong byte leaves what
was there before. All functions raise OSError if the memory is full or broken. Writing stops the processor for up to
0.4 s a block: only at a stand. Reading needs three pieces of memory: 1.2 kB for the file, 1.3 kB for the stream, 1 kB for its
window.
"""

import gc
import os
from binascii import crc32

import deflate
from micropython import const

from passo.config.journal import seal_record
from passo.options.jobs.config_names import name_fits
from passo.options.jobs.errors import JOB_DAMAGED, JOB_LANGUAGE, JOB_UPLOAD, NO_CARD
from passo.records import WINDOW_BITS

_MAGIC = b"job "
HEAD_BYTES = const(96)  # at most, of a file's first line
_UPLOAD = "upload.new"
_DIRECTORY = const(0x4000)  # os.ilistdir's
_SPARE = const(2)  # blocks that an upload leaves free
_EINVAL = const(22)  # deflate's, of a stream that is wrong
_LISTED = const(64)  # jobs: each wants its first line read, on a card some 60 ms
_LISTED_BYTES = const(512)  # of free memory, for each


class Damaged(Exception):
    """A file is not whole. `args`: the number of the error."""


def first_line(language, size, crc, stored):
    """Return the first line of a file: of a job of `size` bytes with that CRC-32, in `stored` bytes."""
    return seal_record(_MAGIC + ("%s %d %08x %d" % (language, size, crc, stored)).encode())


def parse_first_line(line):
    """Return (language, bytes, CRC-32, bytes stored) of a file's first line; None if it is no such line, or one of its bytes is wrong."""
    fields = line[len(_MAGIC) :].split()
    if line[: len(_MAGIC)] != _MAGIC or len(fields) != 5 or line != seal_record(line[:-10]):
        return None
    try:
        head = fields[0].decode(), int(fields[1]), int(fields[2], 16), int(fields[3])
    except ValueError:
        return None
    return head if min(head[1:]) >= 0 else None


class JobFile:
    """A job, read from the start of a file. Raises Damaged if its first line is wrong, or says another `language` than the one wanted.

    `lost`: the error if the memory that it lies in does not answer any more."""

    def __init__(self, file, lost, language):
        self._file = file
        self._stream = None
        self._lost = lost
        head = parse_first_line(self._file.readline(HEAD_BYTES))
        if head is None or language and language != head[0]:
            self.close()
            raise Damaged(JOB_LANGUAGE if head else JOB_DAMAGED)
        _, self.size, self.crc, _ = head
        self.done = 0  # bytes read
        self._sum = 0  # their CRC-32
        self._first = first = bytearray(1)  # of the job: reading it makes the stream's window, at a stand
        self._stream = deflate.DeflateIO(self._file, deflate.RAW, WINDOW_BITS)
        try:
            self._first = first[: self._stream.readinto(first)]
        except (OSError, EOFError) as error:
            self.close()
            raise self.damage_of(error)
        except MemoryError:
            self.close()
            raise

    def readinto(self, view):
        """Read bytes of the job into `view`, a memoryview of two or more. Returns how many; 0 at the end. Raises Damaged, also with the last bytes if
        the CRC is wrong."""
        try:
            if self._first:
                view[:1] = self._first
                self._first = b""
                count = 1 + self._stream.readinto(view[1:])
            else:
                count = self._stream.readinto(view)
        except (OSError, EOFError) as error:
            raise self.damage_of(error)
        self.done += count
        self._sum = crc32(view[:count], self._sum)
        if (self.done >= self.size or not count) and (self.done != self.size or self._sum & 0xFFFFFFFF != self.crc):
            raise Damaged(JOB_DAMAGED)
        return count

    def damage_of(self, error):
        """Return a Damaged for an error of reading: the stream is wrong or ends too soon, or its memory does not answer."""
        wrong = not error.args or error.args[0] == _EINVAL
        return Damaged(JOB_DAMAGED if wrong else self._lost)

    def close(self):
        """Close the file, and let go of it and of the stream."""
        self._file.close()
        if self._stream:
            self._stream.close()
        self._file = self._stream = None


def count_folders(path):
    """Return the number of folders below `path`, which ends in "/"."""
    count = 0
    for entry in os.ilistdir(path):
        if entry[1] == _DIRECTORY:
            count += 1 + count_folders(path + entry[0] + "/")
    return count


class JobStore:
    _is_flash = True
    _ends = (".job",)
    root = "/"  # of its file system

    def __init__(self, folder):
        self._folder = folder + "/"
        self._file = None  # an upload
        self._name = ""
        self._upload = ""  # its path
        self._left = 0  # bytes that it still lacks
        self.more = 0  # jobs that the last list has left out

    def close(self, job):
        """Close a job, and collect the garbage of reading it while the machine stands."""
        job.close()
        gc.collect()

    def mount(self):
        """Make the folder, and remove an upload that a power cut has left. Call it once, before anything else."""
        try:
            os.mkdir(self._folder[:-1])
        except OSError:
            pass  # it is there
        self._upload = self._folder + _UPLOAD
        self.abort_upload()

    def _job_path(self, name):
        """Return the path of a job's file."""
        return self._folder + name + self._ends[0]

    def _job_names(self):
        """Return the names of the jobs in the folder, sorted, _LISTED at most; `more` counts those left out."""
        found = []
        self.more = 0
        most = min(_LISTED, gc.mem_free() // _LISTED_BYTES) if hasattr(gc, "mem_free") else _LISTED
        folder = self._folder[:-1]
        # One after the other: a card may have more of them than memory holds. A PC has no ilistdir().
        for name in (entry[0] for entry in os.ilistdir(folder)) if hasattr(os, "ilistdir") else sorted(os.listdir(folder)):
            if name[-4:] in self._ends and name_fits(name[:-4]) and name[:-4] not in found:
                if len(found) < most:
                    found.append(name[:-4])
                else:
                    self.more += 1
        return sorted(found)

    def open(self, name, language=None):
        """Return a JobFile at its start. Only at a stand: it takes 30 ms. Raises OSError, MemoryError, and Damaged if its language is not the one
        wanted."""
        return self._open_job(self._job_path(name), language)

    def _open_job(self, path, language=None):
        """Return the JobFile of a path, its window made. Raises as open()."""
        return JobFile(open(path, "rb"), JOB_DAMAGED if self._is_flash else NO_CARD, language)

    def list_jobs(self):
        """Return [(name, language, bytes, bytes stored, CRC-32)]; the language of a damaged one is "". `more` counts the jobs left out. Raises
        OSError."""
        found = []
        for name in self._job_names():
            there, head = self._read_first_line(name)
            if there:
                language, size, crc, stored = head or ("", 0, 0, 0)
                found.append((name, language, size, stored, crc))
        return found

    def _read_first_line(self, name):
        """Return (True, the parsed first line) of a stored job, (True, None) if it cannot be read, (False, None) if the file is no job."""
        try:
            with open(self._job_path(name), "rb") as file:
                return True, parse_first_line(file.readline(HEAD_BYTES))
        except OSError:
            return True, None

    def delete_job(self, name):
        """Remove a job. Raises OSError."""
        os.remove(self._job_path(name))

    def free_bytes(self):
        """Return the bytes that an upload may have."""
        if not hasattr(os, "statvfs"):
            return 0x3FFFFFFF
        found = os.statvfs(self._folder[:-1])
        blocks = found[4]
        if blocks > found[2]:  # less than nothing
            blocks -= 1 << 32
        if self._is_flash and not found[5] and hasattr(os, "ilistdir"):  # not the file system of a PC
            blocks += 2 * count_folders(self.root)  # MicroPython counts those of littlefs twice
        return max(blocks - _SPARE, 0) * found[0]

    # --- uploads

    def begin(self, name, language, size, crc, stored):
        """Begin an upload of `stored` bytes, in place of one under way. Raises OSError, MemoryError."""
        self.abort_upload()
        self._upload = self._upload_path(name)
        self._file = open(self._upload, "wb")
        self._name = name
        self._left = stored
        self._file.write(first_line(language, size, crc, stored))

    def _upload_path(self, name):
        """Return the path that an upload of this name goes to."""
        return self._folder + _UPLOAD

    def busy(self):
        """Return True while an upload is under way."""
        return self._file is not None

    def add_data(self, data):
        """Add bytes to the upload. Returns 0, or the number of an error. Raises OSError."""
        if self._file is None or len(data) > self._left:
            return JOB_UPLOAD
        self._file.write(data)
        self._left -= len(data)
        return 0

    def open_upload(self):
        """Return the upload as a JobFile, to be read back; None if there is none, or not all of it. Raises MemoryError, Damaged."""
        if self._file is None or self._left:
            return None
        self._file.close()
        self._file = None
        return self._open_job(self._upload)

    def commit_upload(self):
        """Make the upload the job, at once, in place of an older one. Raises OSError."""
        os.rename(self._upload, self._job_path(self._name))
        if hasattr(os, "sync"):
            os.sync()

    def abort_upload(self):
        """Forget the upload, if there is one."""
        file = self._file
        if file is not None:
            self._file = None
            try:
                file.close()
            except OSError:
                pass  # a card that has gone: the bytes written last are lost
        if self._upload:
            self._remove_file(self._upload)
            self._upload = ""

    def _remove_file(self, path):
        """Remove a file, if it is there."""
        try:
            os.remove(path)
        except OSError:
            pass  # there is none

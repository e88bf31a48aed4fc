"""Keeps the progress of a drawing in a small file beside it, so that it can be continued.

The file is replaced as a whole, about once a second and when the drawing is interrupted: it is never half written. It counts
finished objects, and the points drawn of the unfinished one.
"""

import errno
import json
import os
from pathlib import Path

from host_tools.failure import Failure, reason


class Journal:
    def __init__(self, path, digest, most, options=None):
        """`digest`: identifies drawing and position; `most`: points that an object may have; `options`: those of the command."""
        self.path = Path(path)
        self.digest = digest
        self.most = most
        self.options = options or {}
        self.object = 0  # the first object not finished
        self.drawn = 0  # points of it that have been drawn

    @staticmethod
    def path_beside(drawing_path):
        """Return the usual path of the journal: beside the drawing."""
        return Path(str(drawing_path) + ".journal")

    @staticmethod
    def options_of(path):
        """Return the options with which a drawing was begun, by its journal's file; {} if there is none."""
        try:
            return dict(json.loads(Path(path).read_text(encoding="utf-8")).get("options", {}))
        except (OSError, ValueError, AttributeError, TypeError):
            return {}

    def save_progress(self, number, drawn=0):
        """Note that objects before `number` are drawn, and the first `drawn` points of that one. Raises Failure."""
        self.object, self.drawn = number, drawn
        record = {"digest": self.digest, "points_per_object": self.most, "object": number, "drawn": drawn, "options": self.options}
        try:
            os.replace(self._write_new(json.dumps(record) + "\n"), self.path)
        except OSError as error:
            raise self._unwritable(error) from error

    def check_writable(self):
        """Raise Failure if the journal could not be written; an old one stays as it is."""
        try:
            if self.path.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            self._write_new("{}\n").unlink()
        except OSError as error:
            raise self._unwritable(error) from error

    def is_begun(self):
        """True if the file is of this drawing, begun and not finished."""
        try:
            return Journal(self.path, self.digest, self.most)._load_file()
        except Failure:
            return False

    def _write_new(self, text):
        fresh = self.path.with_name(self.path.name + ".new")
        fresh.write_text(text, encoding="utf-8")
        return fresh

    def _unwritable(self, error):
        return Failure("journal {} cannot be written: {}; --journal names another place", self.path, reason(error))

    def resume_from_file(self):
        """Continue from the file. Raises Failure if there is none, it belongs to another drawing, or cannot be written."""
        self._load_file()
        self.check_writable()

    def _load_file(self):
        """Read the file; return True if anything is drawn. Raises Failure."""
        try:
            record = json.loads(self.path.read_text(encoding="utf-8"))
            digest, number, drawn = record["digest"], int(record["object"]), int(record["drawn"])
        except FileNotFoundError as error:
            raise Failure("nothing to continue: there is no journal {}", self.path) from error
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise Failure("journal {} cannot be read: {}", self.path, error) from error
        if digest != self.digest:
            raise Failure(
                "cannot continue: the drawing or its placement is not that of journal {}; use the options of the first run, or "
                "draw it anew without --continue",
                self.path,
            )
        self.object, self.drawn = number, drawn
        return number > 0 or drawn > 0

    def remove_file(self):
        """Remove the file: the drawing is done."""
        self.path.unlink(missing_ok=True)

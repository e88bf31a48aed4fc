"""How far a drawing has come, in a small file beside it, so that it can be continued.

The file is replaced as a whole after every object and when the drawing is broken off: it is never half written. It
counts finished objects, and the points drawn of the one that was not.
"""

import json
import os
from pathlib import Path

from host_tools.failure import Failure


class Journal:
    def __init__(self, path, digest, most):
        """`digest` says what is drawn and where; `most` is the number of points an object may have."""
        self.path = Path(path)
        self.digest = digest
        self.most = most
        self.object = 0  # the first object not finished
        self.drawn = 0  # points of it that have been drawn

    @staticmethod
    def beside(drawing_path):
        """The journal's usual place."""
        return Path(str(drawing_path) + ".journal")

    def save(self, number, drawn=0):
        """Note that objects before `number` are drawn, and the first `drawn` points of that one."""
        self.object, self.drawn = number, drawn
        record = {"digest": self.digest, "points_per_object": self.most, "object": number, "drawn": drawn}
        fresh = self.path.with_name(self.path.name + ".new")
        try:
            fresh.write_text(json.dumps(record) + "\n", encoding="utf-8")
            os.replace(fresh, self.path)
        except OSError as error:
            reason = f"{error.strerror}; --journal names another place"
            raise Failure(f"journal {self.path} cannot be written: {reason}") from error

    def resume(self):
        """Take over where the file says. Raises Failure if there is none or it belongs to something else."""
        try:
            record = json.loads(self.path.read_text(encoding="utf-8"))
            digest, number, drawn = record["digest"], int(record["object"]), int(record["drawn"])
        except FileNotFoundError as error:
            raise Failure(f"nothing to continue: there is no journal {self.path}") from error
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise Failure(f"journal {self.path} cannot be read: {error}") from error
        if digest != self.digest:
            raise Failure(
                f"cannot continue: the drawing or its placement is not that of journal {self.path}; "
                "use the options of the first run, or draw it anew without --continue"
            )
        self.object, self.drawn = number, drawn

    def finish(self):
        """The drawing is done: the journal is not needed any more."""
        self.path.unlink(missing_ok=True)

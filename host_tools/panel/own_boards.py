"""The board files of the user's own, from the page: made like another machine, changed, taken back, removed.

    own = OwnBoards(folder, files, present, tell)       # files: {name: board file} of the machines to choose from
    PanelOrders(machine, store, teach, choose, proving, own)    # {"do": "board", "what": "set", "name": "mine.py", "values": {…}}

`passo machine` writes by the same functions (board_files.py): the firmware's check decides. The board takes it at its next start as that machine.
"""

import os
from pathlib import Path

from host_tools import board_files, boards
from host_tools.failure import Failure
from host_tools.language import LANGUAGES, in_language
from host_tools.panel.machine_form import Form
from passo import errors
from passo.protocols.page.orders import Wrong, text_field

_MOST_VALUES = 200
_LONGEST = 32


class OwnBoards:
    def __init__(self, folder, files, present, tell):
        """`present()`: the name of the machine that the board is; `tell()`: the machines to choose from are others now."""
        self._folder = folder
        self._files = files
        self._present = present
        self._tell = tell
        self._told = set(files)

    def carry_out(self, order):
        """Carry out an order, and return its answer. It touches the disk, so the panel calls it beside its loop; then it calls finish()."""
        try:
            name = text_field(order, "name", 64)
            do = {"get": self._describe_board, "new": self._create_board, "set": self._change_board, "back": self._restore_board, "remove": self._remove_board}.get(order["what"])
            if do is None or name not in self._files:
                raise Wrong("what")
            with in_language(order.get("language") if order.get("language") in LANGUAGES else None):
                try:
                    return do(name, order) or self._describe_board(name, order)
                except Failure as failure:
                    return {"t": "answer", "do": "board", "error": errors.ORDER_FIELD, "text": failure.message().replace(f"{self._folder}{os.sep}", "")}
        except Wrong:
            return errors.ORDER_FIELD

    def finish(self, answer):
        """Return the answer; call `tell` if the list of machines has changed."""
        if set(self._files) != self._told:
            self._told = set(self._files)
            self._tell()
        return answer

    def _own_file(self, name):
        """The file of a machine of the user's own. Raises Failure."""
        file = Path(self._files[name])
        board_files.check_own(file)
        return file

    def _describe_board(self, name, order):
        """The message with the fields of a board file; without fields for a file of Passo's own. Raises Failure."""
        told = {"t": "board", "name": name, "own": name.endswith(".py"), "groups": [], "pins": [], "old": False}
        if told["own"]:
            file = self._own_file(name)
            form = Form(boards.read(file), file)
            told.update(groups=form.groups(), pins=form.pins(), old=board_files.old_of(file).is_file())
        return told

    def _create_board(self, name, order):
        """Make a board file like `name`, called by the order's `as`. Returns its message. Raises Failure or Wrong."""
        made = text_field(order, "as", _LONGEST)
        board_files.check_name(made)
        self._folder.mkdir(parents=True, exist_ok=True)
        file = self._folder / f"{made}.py"
        board_files.create(file, str(self._files[name]), {})
        self._files[file.name] = str(file)
        return self._describe_board(file.name, order)

    def _change_board(self, name, order):
        """Write the changed values of the order into the board file. Raises Failure or Wrong."""
        changes = order.get("values")
        if not isinstance(changes, dict) or len(changes) > _MOST_VALUES:
            raise Wrong("values")
        for key in changes:
            if not isinstance(changes[key], bool):
                text_field(changes, key, _LONGEST)
        file = self._own_file(name)
        board_files.change_values(file, Form(boards.read(file), file).path_values(changes))

    def _restore_board(self, name, order):
        board_files.go_back(self._own_file(name))

    def _remove_board(self, name, order):
        """Remove a board file of the user's own. Returns the answer. Raises Failure if the board is that machine."""
        file = self._own_file(name)
        if name == self._present():
            raise Failure("machine {} is the chosen one: choose another first", name)
        board_files.remove_file(file)
        del self._files[name]
        return {"t": "answer", "do": "board", "error": 0}

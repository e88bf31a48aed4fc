"""The inputs of the board file by name, as the settings have them: limits, probe, safety door, homing's sensors, buttons.

    limit_x …  or whatever homing.sensors names for the axis     probe     door     hold  resume  reset
"""

from passo.config import setting_numbers as table


class Inputs:
    def __init__(self, board, settings, port):
        self._settings = settings
        self._turned = ()  # names of the inputs that the settings of this version turn round:
        self._version = -1
        self.input = port.input  # input(name): as it is at the pin
        self.levels = port.levels  # levels(): of all inputs, as one integer
        names = [item["name"] for item in board["inputs"]]
        self.has_probe = "probe" in names
        self.door = "door" in names  # there is one
        sensors = board["homing"]["sensors"] if board["homing"] else {}
        limits = [(axis["name"].upper(), sensors.get(axis["name"]) or "limit_" + axis["name"]) for axis in board["axes"]]
        self.limits = [limit for limit in limits if limit[1] in names]  # (axis's letter, name)
        self.names = [name for _, name in self.limits]
        limits = getattr(board.get("additions"), "limits", None)
        if limits is not None:  # the port watches them, and the board file alone says when they are active
            self.limits = [(axis[0].upper(), limits[axis]) for axis in sorted(limits)]
            self.names = []

    def read(self, name):
        """Return True while the input is active; the settings can turn limits and probe round."""
        settings = self._settings
        if self._version != settings.version:
            self._version = settings.version
            self._turned = [limit for limit in self.names if limit != "probe"] if settings.mask_change(table.LIMIT_INVERT) else []
            if settings.mask_change(table.PROBE_INVERT):
                self._turned.append("probe")
        return self.input(name) != (name in self._turned)

    def door_open(self):
        """Return True if there is a safety door and it is open."""
        return self.door and self.input("door")

"""Solids on the table of a virtual machine: a tool that touches one closes the probe's circuit.

    stock = Stock(board, PIECE, radius_mm=3.0)
    stock.touches([48000, 32000, -16000])       # steps from the machine's zero

Solids are boxes and round bosses with holes, in mm of the homed machine. The tool is a cylinder with a flat end. A tool that turns
(Plant.tool) touches nothing: its clip is off.
"""

# (least x, y, z, most x, y, z, holes as (x, y, radius)) of a box; (x, y, radius, least z, most z) of a boss. 100 × 80 × 20 mm of aluminium
# with a hole of 30 mm in its middle, a touch plate of 12 mm on it, and a boss of 24 mm beside it.
PIECE = ((100.0, 60.0, -60.0, 200.0, 140.0, -40.0, ((150.0, 100.0, 15.0),)), (170.0, 115.0, -40.0, 190.0, 135.0, -28.0, ()), (240.0, 100.0, 12.0, -60.0, -45.0))
RADIUS_MM = 3.0


def _in_box(solid, x, y, z, radius):
    """Return True if a tool of `radius` mm at x, y, z touches a box, and none of its round holes has room for the tool."""
    x0, y0, z0, x1, y1, z1, holes = solid
    if not z0 <= z <= z1:
        return False
    across, along = max(x0 - x, 0.0, x - x1), max(y0 - y, 0.0, y - y1)
    if across * across + along * along > radius * radius:
        return False
    return not [1 for hx, hy, hole in holes if (x - hx) ** 2 + (y - hy) ** 2 < max(hole - radius, 0.0) ** 2]


def _on_boss(solid, x, y, z, radius):
    bx, by, boss, z0, z1 = solid
    return z0 <= z <= z1 and (x - bx) ** 2 + (y - by) ** 2 <= (boss + radius) ** 2


class Stock:
    def __init__(self, board, solids=PIECE, radius_mm=RADIUS_MM):
        """`board`: of three axes or more, with an input named probe."""
        self.radius_mm = radius_mm
        self._solids = solids
        self._mm = [1000 / axis["steps_per_m"] for axis in board["axes"][:3]]
        self._top = max([solid[5] if len(solid) == 7 else solid[4] for solid in solids])

    @staticmethod
    def can_touch(board):
        """True if a board's machine can touch something."""
        return len(board["axes"]) >= 3 and "probe" in [item["name"] for item in board.get("inputs", ())]

    def touches(self, position):
        """Return True if the tool at a position (steps from machine zero) touches a solid."""
        z = position[2] * self._mm[2]
        if z > self._top:
            return False
        x, y = position[0] * self._mm[0], position[1] * self._mm[1]
        return bool([1 for solid in self._solids if (_in_box if len(solid) == 7 else _on_boss)(solid, x, y, z, self.radius_mm)])

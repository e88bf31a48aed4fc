"""Seams on the page of a torch: the order `weave`.

    seams = Seams(machine)      # a TorchPage, which has the order from here on
    machine.orders["weave"]({"do": "weave", "shape": "zigzag", "to": {"x": 40, "y": 0}, "amplitude": 3, "pitch": 4, "speed": 600})
"""

from micropython import const

from passo import errors
from passo.commands import Motion
from passo.options.weaving.commands import SEAM
from passo.options.weaving.motion import NAMES
from passo.protocols.page.orders import Wrong, number_field, positions_field, text_field
from passo.records import FARTHEST

_MOST_UM_S = const(1_000_000)


def extend(protocol, board):
    """Add the order to a page's protocol."""
    Seams(protocol.machine)


class Seams:
    def __init__(self, machine):
        self._machine = machine
        machine.can = machine.can + ("weave",)
        machine.orders["weave"] = self._weave_seam

    def _weave_seam(self, order):
        """Queue a seam, see seam_of(). Returns 0 or an error. Raises Wrong."""
        machine = self._machine
        spec, to, speed, centre = seam_of(order, machine.scale)
        if max([abs(part) for part in to + centre]) >= FARTHEST:
            return errors.TRAVEL
        command = Motion(SEAM, to)
        command.value = spec
        command.clockwise = bool(order.get("clockwise"))
        command.centre = tuple(centre)
        command.over_half = not to[0] and not to[1]
        command.feed = speed * 1000
        return machine.refusal() or machine.busy_error() or machine.queue_command(command)


def seam_of(order, scale):
    """(spec of a weave, steps to the end from here, µm/s, steps to the centre or (0, 0)) of an order for a seam to (x, y) mm from here; its field
    `centre` makes it an arc about that position. `scale`: steps/mm. Raises Wrong."""
    if text_field(order, "shape", 12) not in NAMES[1:]:
        raise Wrong("shape")
    to = positions_field(order, "to", "xy")
    centre = positions_field(order, "centre", "xy") if "centre" in order else {}
    spec = (
        NAMES.index(order["shape"]), round(number_field(order, "amplitude", 0.001, 100) * 1000), round(number_field(order, "pitch", 0.1, 1000) * 1000),
        int(number_field(order, "left", 0, 60_000, 0)), int(number_field(order, "right", 0, 60_000, 0)), 1 if order.get("along") else 0,
    )  # fmt: skip
    speed = max(1, min(_MOST_UM_S, round(number_field(order, "speed", 0.1, 50_000) * 1000 / 60)))
    ends = [[round(position.get("xy"[axis], 0) * scale[axis]) for axis in range(2)] for position in (to, centre)]
    return spec, ends[0], speed, ends[1]

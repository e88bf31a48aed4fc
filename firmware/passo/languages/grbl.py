"""G-code as grbl takes it on a link; its links share their work offsets."""

from passo.control.board_error import BoardError
from passo.control.settings import HOMING
from passo.protocols.gcode_offsets import Offsets
from passo.protocols.grbl import Grbl


def opened(link, board, controller, shared):
    axes = "".join([axis["name"] for axis in board["axes"]])[:3]
    if axes not in ("x", "xy", "xyz"):
        raise BoardError("link %s: grbl wants axes x, y, z in this order, not %s" % (link["name"], axes))
    if "offsets" not in shared:
        shared["offsets"] = Offsets(len(axes), controller.settings)
    controller.program.accelerates = True
    if controller.settings.value(HOMING):
        controller.links.lock(link["name"])
    return Grbl(axes, shared["offsets"], controller.settings, controller)

"""G-code as grbl takes it on a link; its links share their work offsets."""

from passo.batch import Lines
from passo.control.board_error import BoardError
from passo.control.setting_numbers import HOMING
from passo.protocols.gcode_offsets import Offsets
from passo.protocols.grbl import Grbl
from passo.records import BATCH_ROWS

NEEDS = ("program", "pauses", "tools", "pins")


def check(link, board):
    axes = "".join([axis["name"] for axis in board["axes"]])[:3]
    if axes not in ("x", "xy", "xyz"):
        raise BoardError("link %s: grbl wants axes x, y, z in this order, not %s" % (link["name"], axes))


def guarded(settings):
    """As grbl: with homing ($22) a link moves nothing before the machine is homed or unlocked."""
    return bool(settings.value(HOMING))


def create(link, number, board, controller, shared, most):
    machine = controller.machine
    axes = "".join([axis["name"] for axis in board["axes"]])[:3]
    if "offsets" not in shared:
        shared["offsets"] = Offsets(len(axes), machine.settings)
    program = controller.features["program"]
    batch = Lines(number, program.rows, min(most, BATCH_ROWS), program.slow_tool())
    return Grbl(axes, shared["offsets"], machine, batch, (most + 3) >> 2)  # one that goes as a command costs as much as four

"""G-code as grbl takes it on a link; its links share their work offsets."""

from passo.batch import Lines
from passo.protocols import extend_language
from passo.protocols.gcode.offsets import Offsets
from passo.protocols.grbl.protocol import Grbl

NEEDS = ("program", "pauses", "tools", "pins")
GUARDED = True  # with homing ($22) a link moves nothing before the machine is homed or unlocked


def _axis_names(board):
    """Return the names of the axes that G-code may use, "xyza" or at most three."""
    axes = "".join([axis["name"] for axis in board["axes"]])
    return axes if axes == "xyza" else axes[:3]


def check(board):
    """Return None, or the reason why the board cannot speak grbl."""
    if board["homing"] and board["homing"]["latch"]:
        from passo.protocols.grbl import homing  # noqa: F401
    axes = _axis_names(board)
    return None if axes in ("x", "xy", "xyz", "xyza") else "grbl wants axes x, y, z in this order, not " + axes


def create(link, number, board, controller, shared, most):
    """Return the Grbl of a link. Links share their work offsets by `shared`; `most`: lines of a batch."""
    machine = controller.machine
    axes = _axis_names(board)
    if "offsets" not in shared:
        shared["offsets"] = Offsets(len(axes), machine.settings)
    program = controller.features["program"]
    batch = Lines(number, program.rows, most, program.slow_tool(), program.dots)
    made = Grbl(axes, shared["offsets"], machine, batch, (most + 7) >> 3)  # one that goes as a command costs as much as eight
    made.gcode.turns = controller.queue.turns
    return extend_language(made, board, "grbl")

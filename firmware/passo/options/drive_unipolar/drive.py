"""Unipolar motors by four transistors S1…S4, one bit each, S1 lowest."""

from passo.options.coil_drives.drive import of_board

PINS = ("s1", "s2", "s3", "s4")

MODES = {
    "wave": bytes((0b0001, 0b0010, 0b0100, 0b1000)),  # full step, one coil: S1, S2, S3, S4
    "full": bytes((0b0011, 0b0110, 0b1100, 0b1001)),  # full step, two coils
    "half": bytes((0b0001, 0b0011, 0b0010, 0b0110, 0b0100, 0b1100, 0b1000, 0b1001)),  # one and two coils in turn
}
OFF = 0


def create(board):
    """Return the CoilDrive of a checked board."""
    return of_board(board, PINS, MODES[board["drive"]["mode"]], OFF)

"""Outputs named `p0` … `p9`: M62 to M65 switch them, with a step or at once."""

HEAP_KB = 8  # of a Pico with stock MicroPython
RULES = {}


def check(board):
    """Add the feature, and on an rp2 chip with the PIO player the port's part that shows marks."""
    additions = board["additions"]
    additions.features["digital"] = "passo.options.output_p.control", "DigitalOutputs"
    by_registers = "veto" in additions.parts or "bank" in additions.parts
    if board["chip"][:2] == "rp" and board["player"] == "pio" and not by_registers:
        additions.parts["switching"] = "passo.options.output_p.port_rp2"  # else the main loop changes them

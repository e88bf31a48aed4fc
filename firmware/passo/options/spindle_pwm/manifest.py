"""`spindle.pwm` True: on rp2 chips the PIO player shows the tool's power with the very word that it belongs to; a laser that switches at once burns
rows of dots."""

HEAP_KB = 9  # of a Pico with stock MicroPython
RULES = {}


def check(board):
    """Have the port make this player in place of the PIO player; have the feeder burn dots, and grbl read them."""
    additions = board["additions"]
    if board["chip"][:2] == "rp" and board["player"] == "pio":
        additions.player_module = "passo.options.spindle_pwm.port_rp2"
    if board["spindle"]["laser"] and not (board["tool"]["on_ms"] or board["tool"]["off_ms"]):
        additions.burn = "passo.options.spindle_pwm.steps_viper"
        if "grbl" in [link["protocol"] for link in board["links"]]:
            additions.languages.append("passo.options.spindle_pwm.language_grbl")

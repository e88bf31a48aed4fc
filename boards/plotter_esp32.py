"""The plotter of 2014 on an ESP32 DevKit (30 or 38 pins).

Its steps come from a soft timer: see firmware/passo/ports/esp32/timer_player.py for the limits. Pins 34 … 39 are inputs
without pull-ups; 0, 2, 12 and 15 decide how the chip starts, 6 … 11 are the flash memory's, 1 and 3 the console's.
"""

BOARD = {
    "name": "plotter_esp32",
    "chip": "esp32",
    "drive": {"kind": "unipolar", "mode": "half"},
    "axes": [
        # pins: S1 S2 S3 S4, four transistors a motor.
        {"name": "x", "pins": [16, 17, 18, 19], "steps_per_m": 10000, "travel_steps": 4000},
        {"name": "y", "pins": [21, 22, 23, 25], "steps_per_m": 10000, "travel_steps": 3000},
    ],
    # The pen's solenoid: on presses the pen down. The head waits for it to arrive.
    "tool": {"pin": 26, "on_ms": 60, "off_ms": 60},
    # TCST1103 slotted barriers: an object in the slot makes the collector rise, which is the active state.
    "inputs": [
        # The BOOT button, pressed shortly after a reset: the REPL instead of the machine.
        {"name": "repl", "pin": 0, "active": 0, "pull": "up"},
        {"name": "barrier_x", "pin": 32, "active": 1, "pull": "up"},
        {"name": "barrier_y", "pin": 33, "active": 1, "pull": "up"},
    ],
    "homing": {
        "sensors": {"x": "barrier_x", "y": "barrier_y"},
        "seek_steps_s": 400,
        "locate_steps_s": 50,
        "pull_off_steps": 40,
        "debounce_ms": 5,
    },
    # half_period_us as the table of 2014 behaved: a step of the axis with most steps lasts two half periods and
    # overhead_us, the time of its packet loop. Other machines say "steps_per_s", the speed along the path.
    "speed": {"unit": "half_period_us", "default": 1000, "min": 200, "max": 20000, "overhead_us": 225},
    "jog": {"steps": 10, "up": "y+"},
    "idle_release_ms": 5000,
    "store_points": 3000,
    "links": [
        {"name": "pc", "port": "uart2", "tx": 27, "rx": 14, "baud": 57600, "protocol": "plotter", "idle_gap_ms": 5},
    ],
}

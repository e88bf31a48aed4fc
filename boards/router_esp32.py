"""A small router on an ESP32 DevKit and two 74HC595: see docs/start/wiring.md for the picture. Motors and machine as router_3axis.

The registers' output-enable is pulled up, and low only once the firmware has shifted zeros in: nothing steps while the chip
starts. Pins 34 to 39 are inputs without pull-ups; 0, 2, 12 and 15 decide how the chip starts.
"""

BOARD = {
    "name": "router_esp32",
    "chip": "esp32",
    "psram": True,  # of a WROVER, for instance; it has pins 16 and 17
    "shift": {"clock": 18, "latch": 13, "data": 21, "enable": 19},
    "drive": {"kind": "step_dir", "pulse_us": 4, "setup_us": 8},
    "axes": [
        {"name": "x", "pins": [100, 101], "steps_per_m": 320000, "travel_steps": 96000, "max_mm_min": 5000,
         "accel_mm_s2": 250},
        {"name": "y", "pins": [102, 103], "steps_per_m": 320000, "travel_steps": 64000, "max_mm_min": 5000,
         "accel_mm_s2": 250},
        {"name": "z", "pins": [104, 105], "steps_per_m": 400000, "travel_steps": 32000, "max_mm_min": 1500,
         "accel_mm_s2": 150},
    ],
    # The spindle's relay: QG of the first register.
    "tool": {"pin": 106},
    # Switches to ground that open when hit: a broken wire reads as a hit.
    "inputs": [
        {"name": "limit_x", "pin": 25, "active": 1, "pull": "up"},
        {"name": "limit_y", "pin": 26, "active": 1, "pull": "up"},
        {"name": "limit_z", "pin": 27, "active": 1, "pull": "up"},
        {"name": "probe", "pin": 32, "active": 0, "pull": "up"},
        {"name": "door", "pin": 33, "active": 0, "pull": "up"},
        # The emergency stop's second contact, for the program's sake. The first one cuts the drivers' power: an ESP32 hears of
        # this one after a millisecond, after tens of them while it collects garbage.
        {"name": "stop", "pin": 14, "active": 1, "pull": "up", "halt": True},
        # The BOOT button, pressed shortly after a reset: the REPL instead of the machine.
        {"name": "repl", "pin": 0, "active": 0, "pull": "up"},
    ],
    "outputs": [
        {"name": "enable", "pin": 107, "active": 0},
        {"name": "reverse", "pin": 108},
        {"name": "flood", "pin": 109},
        {"name": "mist", "pin": 110},
    ],
    "homing": {
        "sensors": {"x": "limit_x", "y": "limit_y", "z": "limit_z"},
        "order": "zxy",
        "high_end": "z",
        "seek_steps_s": 8000,
        "locate_steps_s": 400,
        "pull_off_steps": 640,
        "debounce_ms": 5,
    },
    "speed": {"unit": "steps_per_s", "default": 8000, "min": 10, "max": 60000},
    "planning": {"junction_um": 10, "arc_um": 2, "s_curves": True},
    "spindle": {"max_rpm": 24000, "min_rpm": 0, "spin_up_ms": 4000, "coolant_ms": 1000},
    "idle_release_ms": 0,
    "store_points": 1000,
    # A program that asks for the status, and then says nothing for three seconds amid a job, has died: the machine comes to a
    # stand, Z goes up if it has homed, the spindle goes off.
    "links": [{"name": "pc", "port": "usb", "protocol": "grbl", "lost": "retract"}],
}

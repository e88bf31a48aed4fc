"""A router on a Pico whose ball screws have backlash, which is taken up.

Ball screws of 5 mm a turn at 1/8 step: 320 steps/mm. `passo calibrate` finds the backlash; $160 to $162 change it.
"""

BOARD = {
    "name": "router_ballscrew",
    "chip": "rp2040",
    "clock_mhz": 200,
    "drive": {"kind": "step_dir", "pulse_us": 3, "setup_us": 5},
    "axes": [
        {"name": "x", "pins": [2, 5], "steps_per_m": 320000, "travel_steps": 96000, "max_mm_min": 4000, "accel_mm_s2": 250},
        {"name": "y", "pins": [3, 6], "steps_per_m": 320000, "travel_steps": 64000, "max_mm_min": 4000, "accel_mm_s2": 250},
        {"name": "z", "pins": [4, 7], "steps_per_m": 320000, "travel_steps": 25600, "max_mm_min": 2000, "accel_mm_s2": 150},
    ],
    "backlash": {"x": 40, "y": 50, "z": 20},  # µm
    "tool": {"pin": 8},
    # Switches to ground that open when hit: a broken wire reads as a hit.
    "inputs": [
        {"name": "limit_x", "pin": 18, "active": 1, "pull": "up"},
        {"name": "limit_y", "pin": 19, "active": 1, "pull": "up"},
        {"name": "limit_z", "pin": 20, "active": 1, "pull": "up"},
        {"name": "probe", "pin": 21, "active": 0, "pull": "up"},
        {"name": "door", "pin": 22, "active": 0, "pull": "up"},
        # The emergency stop's second contact: steps end within microseconds. The first one cuts the power.
        {"name": "stop", "pin": 27, "active": 1, "pull": "up", "halt": True},
        # Held at the start: the REPL instead of the machine.
        {"name": "repl", "pin": 26, "active": 0, "pull": "up"},
    ],
    "outputs": [
        {"name": "enable", "pin": 11, "active": 0},
        {"name": "flood", "pin": 16},
        {"name": "mist", "pin": 17},
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
    "speed": {"unit": "steps_per_s", "default": 8000, "min": 10, "max": 22000},
    "planning": {"junction_um": 10, "arc_um": 2, "s_curves": True},
    "spindle": {"max_rpm": 24000, "min_rpm": 0, "spin_up_ms": 4000, "coolant_ms": 1000},
    "idle_release_ms": 0,
    "store_points": 1000,
    "journal": {"every_ms": 1000},
    "links": [
        {"name": "usb", "port": "usb", "protocol": "grbl", "lost": "retract"},
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl", "lost": "retract"},
    ],
}

"""A small router on a Pico: three STEP/DIR drivers, limit switches that also home, a spindle's relay, coolant, probe, door
and emergency stop. A Pico W has too little memory for it; a Pico 2 says "chip": "rp2350" and no "clock_mhz".

Ball screws of 5 mm a turn at 1/8 step: 320 steps/mm on X and Y, and 4 mm a turn: 400 steps/mm on Z. X and Y home at
their low ends, Z at the top; machine zero is where it stands then, so Z is zero at the top and negative below it.
"""

BOARD = {
    "name": "router_3axis",
    "chip": "rp2040",
    "clock_mhz": 200,  # of 125, 150 and 200: more lines a second, and answers sooner; leave it out for an rp2350
    "drive": {"kind": "step_dir", "pulse_us": 3, "setup_us": 5},
    "axes": [
        {"name": "x", "pins": [2, 5], "steps_per_m": 320000, "travel_steps": 96000, "max_mm_min": 5000,
         "accel_mm_s2": 250},
        {"name": "y", "pins": [3, 6], "steps_per_m": 320000, "travel_steps": 64000, "max_mm_min": 5000,
         "accel_mm_s2": 250},
        {"name": "z", "pins": [4, 7], "steps_per_m": 400000, "travel_steps": 32000, "max_mm_min": 1500,
         "accel_mm_s2": 150},
    ],
    # The spindle's relay, or the input of its inverter. "on_ms": M3 and M4 wait so long for it.
    "tool": {"pin": 8},
    # Switches to ground that open when hit: a broken wire reads as a hit.
    "inputs": [
        {"name": "limit_x", "pin": 9, "active": 1, "pull": "up"},
        {"name": "limit_y", "pin": 10, "active": 1, "pull": "up"},
        {"name": "limit_z", "pin": 11, "active": 1, "pull": "up"},
        {"name": "probe", "pin": 12, "active": 0, "pull": "up"},
        {"name": "door", "pin": 13, "active": 0, "pull": "up"},
        # The emergency stop's second contact: steps end within microseconds. The first one cuts the power.
        {"name": "stop", "pin": 27, "active": 1, "pull": "up", "halt": True},
        # Held at the start: the REPL instead of the machine.
        {"name": "repl", "pin": 26, "active": 0, "pull": "up"},
    ],
    "outputs": [
        {"name": "enable", "pin": 14, "active": 0},
        {"name": "reverse", "pin": 15},
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
    "speed": {"unit": "steps_per_s", "default": 8000, "min": 10, "max": 26000},
    "planning": {"junction_um": 10, "arc_um": 2, "s_curves": True},
    # After the door, or a spindle stopped in a hold, cutting waits so long for spindle and coolant.
    "spindle": {"max_rpm": 24000, "min_rpm": 0, "spin_up_ms": 4000, "coolant_ms": 1000},
    "idle_release_ms": 0,
    "store_points": 1000,
    # Where a job is, for `passo resume` and the page, after the PC or the power has failed.
    "journal": {"every_ms": 1000},
    # A program that asks for the status, and then says nothing for three seconds amid a job, has died: the machine comes to a
    # stand, Z goes up, the spindle goes off.
    "links": [
        {"name": "pc", "port": "usb", "protocol": "grbl", "lost": "retract"},
        {"name": "serial", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl", "lost": "retract"},
    ],
}

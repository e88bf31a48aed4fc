"""A laser engraver with a focus axis and a rotary, which turns cups and tubes about X. Else as laser_xy.

The rotary: rollers or a chuck, 200 full steps a turn at 1/16 step behind a belt of 1:3, 26.667 steps a degree: 26 667 a thousand degrees.
`travel_steps` counts for nothing, as A homes at no sensor: it turns without an end, and is zero where it stands when the machine is
switched on. A row that goes back to its start does so by the shorter way.

Senders whose rotary stands in for Y (LightBurn) want no A: plug the rotary's motor into Y's driver, and set `$101` to its steps a
millimetre of the work's circumference. Power and air assist: see laser_xy.
"""

BOARD = {
    "name": "laser_rotary",
    "chip": "rp2040",
    "clock_mhz": 200,  # of 125, 150 and 200: more lines a second, and answers sooner; leave it out for an rp2350
    "drive": {"kind": "step_dir", "pulse_us": 3, "setup_us": 5},
    "axes": [
        {"name": "x", "pins": [2, 6], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 12000,
         "accel_mm_s2": 1500},
        {"name": "y", "pins": [3, 7], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 12000,
         "accel_mm_s2": 1500},
        {"name": "z", "pins": [4, 8], "steps_per_m": 400000, "travel_steps": 20000, "max_mm_min": 900,
         "accel_mm_s2": 100},
        {"name": "a", "pins": [5, 9], "steps_per_m": 26667, "travel_steps": 9600, "max_mm_min": 21600,
         "accel_mm_s2": 1500},
    ],
    "rotary": "a",  # mm of it are degrees
    "short_way": True,
    "tool": {"pin": 10},
    "inputs": [
        {"name": "limit_x", "pin": 12, "active": 1, "pull": "up"},
        {"name": "limit_y", "pin": 13, "active": 1, "pull": "up"},
        {"name": "limit_z", "pin": 14, "active": 1, "pull": "up"},
        {"name": "door", "pin": 15, "active": 1, "pull": "up"},
    ],
    "outputs": [
        {"name": "enable", "pin": 16, "active": 0},
        {"name": "flood", "pin": 18},
    ],
    "homing": {
        "sensors": {"x": "limit_x", "y": "limit_y", "z": "limit_z"},
        "order": "zxy",
        "high_end": "z",
        "seek_steps_s": 4000,
        "locate_steps_s": 200,
        "pull_off_steps": 160,
        "debounce_ms": 5,
    },
    "speed": {"unit": "steps_per_s", "default": 8000, "min": 10, "max": 20000},
    "planning": {"junction_um": 10, "arc_um": 2, "s_curves": True},
    "spindle": {"max_rpm": 1000, "min_rpm": 0, "pwm": True, "pin": 11, "pwm_hz": 5000, "laser": True,
                "coolant_ms": 1000},  # after the door: wait so long for the air assist or exhaust
    "idle_release_ms": 0,
    "store_points": 1000,
    # Where a job is, for `passo resume` and the page, after the PC or the power has failed.
    "journal": {"every_ms": 1000},
    # A program that asks for the status, and then says nothing for three seconds amid a job, has died: the machine comes to a
    # stand, the beam off.
    "links": [
        {"name": "pc", "port": "usb", "protocol": "grbl", "lost": "stop"},
        {"name": "serial", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl", "lost": "stop"},
    ],
}

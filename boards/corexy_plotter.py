"""A pen plotter of AxiDraw's size and mechanics on a Pico: one belt, two STEP/DIR drivers that move both axes together (CoreXY), a servo
for the pen, optical barriers at X0 and Y0.

GT2 belt on pulleys of 20 teeth at 1/16 step: 80 steps/mm. "x" and "y" are the pins of motors A and B: A turns as X and Y together, B as X
without Y. If X and Y are exchanged or run backward, exchange the motors or turn them round (`$3`): see docs/use/corexy.md.
"""

BOARD = {
    "name": "corexy_plotter",
    "chip": "rp2040",
    "kinematics": "corexy",
    "drive": {"kind": "step_dir", "pulse_us": 3, "setup_us": 5},
    # The speed and acceleration of X and Y hold for the motors too: a diagonal is the work of one of them.
    "axes": [
        {"name": "x", "pins": [2, 4], "steps_per_m": 80000, "travel_steps": 24000, "max_mm_min": 15000,
         "accel_mm_s2": 2000},
        {"name": "y", "pins": [3, 5], "steps_per_m": 80000, "travel_steps": 17440, "max_mm_min": 15000,
         "accel_mm_s2": 2000},
    ],
    # Shows the pen on a lamp. The pen is up or down so long after M5 and M3.
    "tool": {"pin": 6, "on_ms": 170, "off_ms": 120},
    "servo": {"pin": 7, "up_us": 1800, "down_us": 1200, "up_ms": 100, "down_ms": 150},
    "inputs": [
        {"name": "limit_x", "pin": 9, "active": 1, "pull": "up"},
        {"name": "limit_y", "pin": 10, "active": 1, "pull": "up"},
    ],
    "outputs": [{"name": "enable", "pin": 14, "active": 0}],
    # One axis after the other: each turns both motors.
    "homing": {
        "sensors": {"x": "limit_x", "y": "limit_y"},
        "seek_steps_s": 4000,
        "locate_steps_s": 100,
        "pull_off_steps": 160,
        "debounce_ms": 5,
    },
    "speed": {"unit": "steps_per_s", "default": 8000, "min": 10, "max": 20000},
    "planning": {"junction_um": 10, "arc_um": 2, "s_curves": True},
    "idle_release_ms": 60000,
    "store_points": 1000,
    "journal": {"every_ms": 1000},
    "links": [
        {"name": "usb", "port": "usb", "protocol": "grbl", "lost": "stop"},
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl", "lost": "stop"},
    ],
}

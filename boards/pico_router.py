"""A three-axis router on a Pico: STEP/DIR drivers, 400 steps/mm, a spindle relay, an emergency stop.

PIO wants the drivers' pins in a row: all STEPs, all DIRs, the tool. On a Pico W the same pins are free. A Pico 2 says
"chip": "rp2350".
"""

BOARD = {
    "name": "pico_router",
    "chip": "rp2040",
    "drive": {"kind": "step_dir", "pulse_us": 2, "setup_us": 5},
    "axes": [
        # pins: STEP DIR
        {"name": "x", "pins": [2, 5], "steps_per_m": 400000, "travel_steps": 120000},
        {"name": "y", "pins": [3, 6], "steps_per_m": 400000, "travel_steps": 120000},
        {"name": "z", "pins": [4, 7], "steps_per_m": 400000, "travel_steps": 40000},
    ],
    # The spindle's relay: on_ms is how long it takes to come up to speed.
    "tool": {"pin": 8, "on_ms": 2000, "off_ms": 500},
    "inputs": [
        # A normally closed button to ground with the pull-up: pressed, or its wire broken, it reads high. The steps
        # stop within a microsecond of it.
        {"name": "stop", "pin": 16, "active": 1, "pull": "up", "halt": True},
        {"name": "home_x", "pin": 17, "active": 0, "pull": "up"},
        {"name": "home_y", "pin": 18, "active": 0, "pull": "up"},
        {"name": "home_z", "pin": 19, "active": 0, "pull": "up"},
        # Held at the start: the REPL instead of the machine.
        {"name": "repl", "pin": 22, "active": 0, "pull": "up"},
    ],
    "outputs": [
        {"name": "enable", "pin": 9, "active": 0},
    ],
    "homing": {
        "sensors": {"x": "home_x", "y": "home_y", "z": "home_z"},
        "seek_steps_s": 8000,
        "locate_steps_s": 800,
        "pull_off_steps": 400,
        "debounce_ms": 5,
        "required": True,
    },
    "speed": {"unit": "steps_per_s", "default": 10000, "min": 100, "max": 40000},
    "jog": {"steps": 400, "up": "y+"},
    "idle_release_ms": 0,
    "store_points": 3000,
    "links": [
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "plotter", "idle_gap_ms": 5},
    ],
}

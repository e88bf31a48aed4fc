"""A router on a Pico with three TMC2209 modules, which are set up and watched over one wire: current, microsteps, faults.

GT2 belts of 20 teeth at 1/16 step: 80 steps/mm on X and Y; a screw of 8 mm a turn on Z: 400 steps/mm. MS1 and MS2 of the modules say their
addresses: both to GND is 0, MS1 to 3V3 is 1, MS2 to 3V3 is 2. TX goes by 1 kΩ to the PDN_UART pins of all, RX straight.
"""

BOARD = {
    "name": "router_tmc2209",
    "chip": "rp2040",
    "clock_mhz": 200,
    "drive": {"kind": "step_dir", "pulse_us": 1, "setup_us": 1},
    "axes": [
        {"name": "x", "pins": [2, 5], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 9000, "accel_mm_s2": 600},
        {"name": "y", "pins": [3, 6], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 9000, "accel_mm_s2": 600},
        {"name": "z", "pins": [4, 7], "steps_per_m": 400000, "travel_steps": 40000, "max_mm_min": 1500, "accel_mm_s2": 150},
    ],
    "drivers": {
        "port": "uart1",
        "tx": 20,
        "rx": 21,
        "motors": [
            {"axis": "x", "address": 0, "current_ma": 800},
            {"axis": "y", "address": 1, "current_ma": 800},
            {"axis": "z", "address": 2, "current_ma": 600, "stealth": False},
        ],
    },
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
        {"name": "flood", "pin": 16},
    ],
    "homing": {
        "sensors": {"x": "limit_x", "y": "limit_y", "z": "limit_z"},
        "order": "zxy",
        "high_end": "z",
        "seek_steps_s": 4000,
        "locate_steps_s": 200,
        "pull_off_steps": 240,
        "debounce_ms": 5,
    },
    "speed": {"unit": "steps_per_s", "default": 4000, "min": 10, "max": 20000},
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

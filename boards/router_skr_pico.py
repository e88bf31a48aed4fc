"""A router on a BIGTREETECH SKR Pico V1.0: an RP2040 with four TMC2209 soldered on, which are set up and watched over their wire.

Pins as its maker's own configuration has them. They are not neighbours, so the interrupt's player moves the motors: 36 000 words a second
at most. X and Y home by stall on their DIAG pins, which the board brings to X-STOP and Y-STOP by a jumper beside each driver; Z has a
switch on Z-STOP. GT2 belts of 20 teeth at 1/16 step: 80 steps/mm on X and Y; a screw of 8 mm a turn on Z: 400 steps/mm.
The tool is HE, an output to ground that takes what the terminals give: a relay of 12 or 24 V, not a logic input.
"""

BOARD = {
    "name": "router_skr_pico",
    "chip": "rp2040",
    "clock_mhz": 200,
    "player": "timer",
    "drive": {"kind": "step_dir", "pulse_us": 1, "setup_us": 1},
    "axes": [
        {"name": "x", "pins": [11, 10], "steps_per_m": 80000, "travel_steps": 16000, "max_mm_min": 7200, "accel_mm_s2": 600},
        {"name": "y", "pins": [6, 5], "steps_per_m": 80000, "travel_steps": 16000, "max_mm_min": 7200, "accel_mm_s2": 600},
        {"name": "z", "pins": [19, 28], "steps_per_m": 400000, "travel_steps": 40000, "max_mm_min": 1200, "accel_mm_s2": 150},
    ],
    # Their addresses are the board's: X 0, Z 1, Y 2, E 3.
    "drivers": {
        "port": "uart1",
        "tx": 8,
        "rx": 9,
        "motors": [
            {"axis": "x", "address": 0, "current_ma": 800, "stall": 40, "stall_ma": 400},
            {"axis": "y", "address": 2, "current_ma": 800, "stall": 40, "stall_ma": 400},
            {"axis": "z", "address": 1, "current_ma": 600, "stealth": False},
        ],
    },
    "tool": {"pin": 23},  # HE
    "inputs": [
        {"name": "stall_x", "pin": 4, "active": 1, "pull": "down"},  # X-STOP, with the jumper for DIAG
        {"name": "stall_y", "pin": 3, "active": 1, "pull": "down"},  # Y-STOP
        {"name": "limit_z", "pin": 25, "active": 1, "pull": "up"},  # Z-STOP: a switch to ground that opens when hit
        {"name": "probe", "pin": 22, "active": 0, "pull": "up"},  # Z-PROBE
        # E0-STOP: the emergency stop's second contact; steps end within microseconds. The first one cuts the power.
        {"name": "stop", "pin": 16, "active": 1, "pull": "up", "halt": True},
    ],
    # Each driver has an EN of its own.
    "outputs": [
        {"name": "enable", "pin": 12, "active": 0},
        {"name": "enable_y", "pin": 7, "active": 0},
        {"name": "enable_z", "pin": 2, "active": 0},
        {"name": "flood", "pin": 17},  # FAN1
        {"name": "mist", "pin": 18},  # FAN2
    ],
    "homing": {
        "sensors": {"x": "stall_x", "y": "stall_y", "z": "limit_z"},
        "order": "zxy",
        "high_end": "z",
        "seek_steps_s": 2000,
        "locate_steps_s": 200,
        "pull_off_steps": 400,
        "debounce_ms": 2,
    },
    "speed": {"unit": "steps_per_s", "default": 4000, "min": 10, "max": 10000},
    "planning": {"junction_um": 10, "arc_um": 2, "s_curves": True},
    "spindle": {"max_rpm": 24000, "min_rpm": 0, "spin_up_ms": 4000, "coolant_ms": 1000},
    "idle_release_ms": 0,
    "store_points": 1000,
    "journal": {"every_ms": 1000},
    "links": [
        {"name": "usb", "port": "usb", "protocol": "grbl", "lost": "retract"},
        {"name": "pi", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl", "lost": "retract"},
    ],
}

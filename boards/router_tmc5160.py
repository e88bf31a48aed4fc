"""A router on a Pico with three TMC5160 modules on SPI, a CS each. X and Y home by stall: their motors feel the end, no switches; Z has one.

GT2 belts of 20 teeth at 1/16 step: 80 steps/mm on X and Y; a screw of 8 mm a turn on Z: 400 steps/mm. Modules for STEP and DIR with 0.075 Ω,
as BIGTREETECH TMC5160 Pro: SD_MODE and SPI_MODE high. SCK, SDI and SDO go to all; DIAG1 (or DIAG0) of X and Y to an input each.
`stall`, `stall_ma` and the seek speed are values to begin with: docs/use/drivers.md says how to find yours.
"""

BOARD = {
    "name": "router_tmc5160",
    "chip": "rp2040",
    "clock_mhz": 200,
    "drive": {"kind": "step_dir", "pulse_us": 1, "setup_us": 1},
    "axes": [
        {"name": "x", "pins": [2, 5], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 9000, "accel_mm_s2": 600},
        {"name": "y", "pins": [3, 6], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 9000, "accel_mm_s2": 600},
        {"name": "z", "pins": [4, 7], "steps_per_m": 400000, "travel_steps": 40000, "max_mm_min": 1500, "accel_mm_s2": 150},
    ],
    "spi_drivers": {
        "chip": "tmc5160",
        "sck": 22,
        "tx": 21,
        "rx": 20,
        "sense_mohm": 75,
        "motors": [
            {"axis": "x", "cs": 19, "current_ma": 1500, "stall": 0, "stall_ma": 700},
            {"axis": "y", "cs": 18, "current_ma": 1500, "stall": 0, "stall_ma": 700},
            {"axis": "z", "cs": 17, "current_ma": 1200, "stealth": False},
        ],
    },
    "tool": {"pin": 8},
    "inputs": [
        # DIAG of the drivers, which push and pull: high at a stall.
        {"name": "limit_x", "pin": 9, "active": 1, "pull": "down"},
        {"name": "limit_y", "pin": 10, "active": 1, "pull": "down"},
        # A switch to ground that opens when hit: a broken wire reads as a hit.
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
        # 125 full steps a second, 25 of them back.
        "each": {"x": {"seek_steps_s": 2000, "pull_off_steps": 400}, "y": {"seek_steps_s": 2000, "pull_off_steps": 400}},
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

"""Makerbase MKS DLC32 V2.x: an ESP32 with three drivers and a laser connector, as a laser engraver or a small router.

Its 74HC595 holds STEP and DIR of all drivers, their common enable (its first output) and the buzzer (its last), which is the
tool's bit here: it sounds while the laser, or the spindle, is on. Power goes by PWM on pin 32, within some 2 ms of its step,
later while memory is collected; if the program hangs it stays until the watchdog's reset, a second later. Pins from the
maker's firmware for V2.1, github.com/makerbase-mks/MKS-DLC32; V1.x has the laser on 22 and its SD card where V2 has the
second screen plug: compare the print on the board. Steps, travel and speeds are those of a belt-driven engraver; change them.
"""

BOARD = {
    "name": "mks_dlc32",
    "chip": "esp32",
    "shift": {"clock": 16, "latch": 17, "data": 21},
    "drive": {"kind": "step_dir", "pulse_us": 4, "setup_us": 8},
    "axes": [
        {"name": "x", "pins": [101, 102], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 20000,
         "accel_mm_s2": 1000},
        {"name": "y", "pins": [105, 106], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 20000,
         "accel_mm_s2": 1000},
        {"name": "z", "pins": [103, 104], "steps_per_m": 400000, "travel_steps": 20000, "max_mm_min": 800,
         "accel_mm_s2": 100},
    ],
    "tool": {"pin": 107},
    # The inputs have pull-ups and filters on the board; 34 to 39 have none in the chip. Switches to ground that open when hit.
    "inputs": [
        {"name": "limit_x", "pin": 36, "active": 1, "pull": "none"},
        {"name": "limit_y", "pin": 35, "active": 1, "pull": "none"},
        {"name": "limit_z", "pin": 34, "active": 1, "pull": "none"},
        {"name": "probe", "pin": 22, "active": 0, "pull": "up"},
    ],
    # The drivers' enable is low while they have current: zeros leave it on.
    "outputs": [{"name": "enable", "pin": 100, "active": 0}],
    "homing": {
        "sensors": {"x": "limit_x", "y": "limit_y", "z": "limit_z"},
        "order": "zxy",
        "high_end": "z",
        "seek_steps_s": 4000,
        "locate_steps_s": 400,
        "pull_off_steps": 160,
        "debounce_ms": 5,
    },
    "speed": {"unit": "steps_per_s", "default": 8000, "min": 10, "max": 60000},
    "planning": {"s_curves": True},
    # A router says "laser": False, and max_rpm of its spindle.
    "spindle": {"max_rpm": 1000, "min_rpm": 0, "pwm": True, "pin": 32, "pwm_hz": 5000, "laser": True},
    "idle_release_ms": 0,
    "store_points": 1000,
    # A program that asks for the status, and then says nothing for three seconds amid a job, has died: the machine comes to a
    # stand, the beam is off.
    "links": [{"name": "pc", "port": "usb", "protocol": "grbl", "lost": "stop"}],
}

"""A laser engraver: two STEP/DIR drivers, limit switches that also home, and a diode laser whose power is a PWM signal.

GT2 belts on pulleys of 20 teeth at 1/16 step: 80 steps/mm. $30=1000: S1000 is full power, and M4 has it follow the
speed.

The tool's pin is exact to the step: it is high only while the beam may burn. The power's pin carries the PWM, whose duty
changes with the step too, or within 2 ms of it if steps are slow. A laser with a single input gets both: the tool's pin through
1 kΩ to the input, and from the input a Schottky diode to the power's pin, its cathode at the pin (docs/start/wiring.md).
"""

BOARD = {
    "name": "laser_xy",
    "chip": "rp2040",
    "clock_mhz": 200,  # of 125, 150 and 200: more lines a second, and answers sooner; leave it out for an rp2350
    "drive": {"kind": "step_dir", "pulse_us": 3, "setup_us": 5},
    "axes": [
        {"name": "x", "pins": [2, 4], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 12000,
         "accel_mm_s2": 1500},
        {"name": "y", "pins": [3, 5], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 12000,
         "accel_mm_s2": 1500},
    ],
    "tool": {"pin": 6},
    "inputs": [
        {"name": "limit_x", "pin": 9, "active": 1, "pull": "up"},
        {"name": "limit_y", "pin": 10, "active": 1, "pull": "up"},
        {"name": "door", "pin": 13, "active": 1, "pull": "up"},
    ],
    "outputs": [
        {"name": "enable", "pin": 14, "active": 0},
        {"name": "flood", "pin": 16},
    ],
    "homing": {
        "sensors": {"x": "limit_x", "y": "limit_y"},
        "seek_steps_s": 4000,
        "locate_steps_s": 200,
        "pull_off_steps": 160,
        "debounce_ms": 5,
    },
    "speed": {"unit": "steps_per_s", "default": 8000, "min": 10, "max": 20000},
    "planning": {"junction_um": 10, "arc_um": 2, "s_curves": True},
    "spindle": {"max_rpm": 1000, "min_rpm": 0, "pwm": True, "pin": 7, "pwm_hz": 5000, "laser": True,
                "coolant_ms": 1000},  # after the door: wait so long for the air assist or exhaust
    "idle_release_ms": 0,
    "store_points": 1000,
    # Where a job is, for `passo resume` and the page, after the PC or the power has failed.
    "journal": {"every_ms": 1000},
    # A program that asks for the status, and then says nothing for three seconds amid a job, has died: the machine comes to a
    # stand, the beam off.
    "links": [
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl", "lost": "stop"},
        {"name": "usb", "port": "usb", "protocol": "grbl", "lost": "stop"},
    ],
}

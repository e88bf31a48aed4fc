"""The kit of two stepper motors: eight transistors or a ULN2803A, two motors of four coils, a serial line of 9600 baud.

Each motor turns on its own, in half steps, at its own speed, 250 steps/s at most. It has no sensors and no ends: the
travels are only for the virtual machine.
"""

BOARD = {
    "name": "two_motor_kit",
    "chip": "rp2040",
    "drive": {"kind": "unipolar", "mode": "half"},
    "axes": [
        # pins: the motor's four coils in order. 200 steps a turn are 400 half steps; here 1 mm means a degree.
        {"name": "x", "pins": [2, 3, 4, 5], "steps_per_m": 1111, "travel_steps": 2000000, "max_mm_min": 20000},
        {"name": "y", "pins": [6, 7, 8, 9], "steps_per_m": 1111, "travel_steps": 2000000, "max_mm_min": 20000},
    ],
    # For languages that switch a tool; the kit's own language does not.
    "tool": {"pin": 10},
    "speed": {"unit": "steps_per_s", "default": 250, "min": 1, "max": 1000},
    "idle_release_ms": 1000,
    "store_points": 10,
    "links": [
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 9600, "protocol": "keys"},
    ],
}

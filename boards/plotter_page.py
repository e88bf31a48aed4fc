"""The plotter of 2014 on a Raspberry Pi Pico W that serves its own page: draw from a phone, without a PC. The radio is off until
`passo wifi` has given it a name and a passphrase (docs/use/network.md). GP23, GP24, GP25 and GP29 are the radio's.
"""

BOARD = {
    "name": "plotter_page",
    "chip": "rp2040",
    "drive": {"kind": "unipolar", "mode": "half"},
    "axes": [
        # pins: S1 S2 S3 S4, four transistors a motor.
        {"name": "x", "pins": [2, 3, 4, 5], "steps_per_m": 10000, "travel_steps": 4000},
        {"name": "y", "pins": [6, 7, 8, 9], "steps_per_m": 10000, "travel_steps": 3000},
    ],
    # The pen's solenoid: on presses the pen down. The head waits for it to arrive.
    "tool": {"pin": 10, "on_ms": 60, "off_ms": 60},
    # TCST1103 slotted barriers: an object in the slot makes the collector rise, which is the active state.
    "inputs": [
        {"name": "barrier_x", "pin": 14, "active": 1, "pull": "up"},
        {"name": "barrier_y", "pin": 15, "active": 1, "pull": "up"},
    ],
    "homing": {
        "sensors": {"x": "barrier_x", "y": "barrier_y"},
        "seek_steps_s": 400,
        "locate_steps_s": 50,
        "pull_off_steps": 40,
        "debounce_ms": 5,
    },
    # half_period_us as the table of 2014 behaved: a step of the axis with most steps lasts two half periods and
    # overhead_us, the time of its packet loop. Other machines say "steps_per_s", the speed along the path.
    "speed": {"unit": "half_period_us", "default": 1000, "min": 200, "max": 20000, "overhead_us": 225},
    "jog": {"steps": 10, "up": "y+"},
    "idle_release_ms": 5000,
    # A Pico W has no room for more beside the page; a longer drawing is drawn while it arrives.
    "store_points": 256,
    # Drawings that a phone has uploaded lie in flash, and are drawn from there.
    "jobs": {"language": "plotter"},
    "network": {"host": "passo"},
    "links": [
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 57600, "protocol": "plotter", "idle_gap_ms": 5},
        {"name": "page", "port": "page", "protocol": "plotter"},
    ],
}

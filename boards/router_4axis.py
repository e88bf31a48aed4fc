"""A router on a Pico with a rotary table: three linear axes and A, which turns about X. Else as router_3axis, two pins on from A.

The table: 200 full steps a turn at 1/16 step behind a gear of 1:6, 53.333 steps a degree: 53 333 a thousand degrees. `travel_steps`
counts for nothing, as A homes at no sensor: it turns without an end, and is zero where it stands when the machine is switched on.
"""

BOARD = {
    "like": "router_3axis",
    "name": "router_4axis",
    "axes": [
        {"name": "x", "pins": [2, 6]},
        {"name": "y", "pins": [3, 7]},
        {"name": "z", "pins": [4, 8]},
        {"name": "a", "pins": [5, 9], "steps_per_m": 53333, "travel_steps": 19200, "max_mm_min": 21600,
         "accel_mm_s2": 1000},
    ],
    "rotary": "a",  # mm of it are degrees
    "tool": {"pin": 10},
    "inputs": [
        {"name": "limit_x", "pin": 11},
        {"name": "limit_y", "pin": 12},
        {"name": "limit_z", "pin": 13},
        {"name": "probe", "pin": 14},
        {"name": "door", "pin": 15},
    ],
    "outputs": [
        {"name": "enable", "pin": 16},
        {"name": "reverse", "pin": 17},
        {"name": "flood", "pin": 18},
        {"name": "mist", "pin": 19},
    ],
}

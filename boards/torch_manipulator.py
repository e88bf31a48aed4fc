"""The welding-torch manipulator Tartílope V2F (2020): two STR8 drivers behind relays that choose between two controllers.

48 steps/mm on X, 83 on Y, as its own controller has them. There are no switches: zero is where it was switched on, or
where it is set. The travels are only what the virtual machine needs.
"""

BOARD = {
    "name": "torch_manipulator",
    "chip": "rp2040",
    # The drivers' inputs are switched on their minus side, so a low pin is active. Their EN is left open: enabled, whoever
    # steps them.
    "drive": {"kind": "step_dir", "pulse_us": 5, "setup_us": 20, "step_active": 0},
    "axes": [
        # pins: STEP DIR. A jog is 1 mm at 60 cm/min, until a host configures it.
        {"name": "x", "pins": [2, 4], "steps_per_m": 48000, "travel_steps": 192000, "max_mm_min": 15000,
         "accel_mm_s2": 200, "jog_steps": 48, "jog_steps_s": 480, "reversed": True},
        {"name": "y", "pins": [3, 5], "steps_per_m": 83000, "travel_steps": 166000, "max_mm_min": 15000,
         "accel_mm_s2": 200, "jog_steps": 83, "jog_steps_s": 830, "reversed": True},
    ],
    # The torch's contact, for languages that switch a tool; the torch's own language does not.
    "tool": {"pin": 6},
    "outputs": [
        # Relays of X and Y: without power the original controller's signals reach the drivers. The panel's LED shows who
        # has the motors.
        {"name": "relay_x", "pin": 10, "role": "ours"},
        {"name": "relay_y", "pin": 11, "role": "ours"},
        {"name": "led", "pin": 12, "role": "ours"},
    ],
    # What takes the motors from the original controller. "command": CONNECT or $MOTORS=1, motion is refused before. "motion":
    # the first motion of any language.
    "changeover_by": "command",
    "changeover_ms": 20,
    "speed": {"unit": "steps_per_s", "default": 480, "min": 1, "max": 20000},
    # True: each axis of a move accelerates with accel_mm_s2; False: constant speed, as the original.
    "planning": {"independent_ramps": False, "s_curves": True},
    # Seams from side to side, docs/use/weaving.md; up to 120 cm/min without ramps.
    "weaving": {"steady_mm_min": 1200},
    "idle_release_ms": 0,
    "store_points": 100,
    "links": [
        # tell_end: say FINISHED when a move has ended.
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "torch", "idle_gap_ms": 5,
         "tell_end": False},
    ],
}

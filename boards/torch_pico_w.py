"""The welding-torch manipulator Tartílope V2F (2020) on a Raspberry Pi Pico W: the wiring of torch_manipulator, and the HTTP table
of its ESP32 over Wi-Fi. The radio is off until `passo wifi` has given it a name and a passphrase. GP23, GP24, GP25 and GP29 are
the radio's.
"""

BOARD = {
    "name": "torch_pico_w",
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
    "planning": {"independent_ramps": False},
    "idle_release_ms": 0,
    "store_points": 100,
    # The program of 2020 sends no key. True: from the board's own access point it may move the machine for as many minutes as
    # somebody at the machine gives it, by the button or by `passo torch admit`.
    "network": {"host": "passo", "legacy_http": False, "button": "admit", "minutes": 10},
    "inputs": [
        {"name": "admit", "pin": 14, "active": 0, "pull": "up"},
    ],
    "links": [
        # tell_end: say FINISHED when a move has ended.
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "torch", "idle_gap_ms": 5,
         "tell_end": False},
        {"name": "wifi", "port": "http", "protocol": "torch"},
    ],
}

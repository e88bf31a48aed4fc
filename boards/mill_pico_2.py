"""The XYZ milling table of 2004 on a Pico 2: mill_2004.py with limits and tool on pins of their own, and encoders for the gantry's
motors only.

What the CPLD did is the interlock below, equation by equation, signals by their names of then: h step pulse, s direction,
b?a and b?b the two limits of an axis, d drive good, urg emergency stop, pal tool sensor, sel source (1: this board, 0: the
parallel port), ending in c from the controller, in p from or to the parallel port. The parallel port's own pulses reach the
drivers through an external multiplexer that sel switches: they do not pass through this board.

Every pin of the Pico is in use. Steps, limits, emergency stop and the encoders of the gantry's two motors have pins of their own;
the rest lies behind a 74HC165 and a 74HC595 (pins from 100 on). The encoders of Y and Z find no pins beside the inverter's
serial line and the registers; nor does a second link. Pitch and travels are not in the document: ball screws of 5 mm a turn.
"""

BOARD = {
    "name": "mill_pico_2",
    "chip": "rp2350",
    "drive": {"kind": "step_dir", "pulse_us": 10, "setup_us": 10},
    "axes": [
        {"name": "x", "pins": [2, 6], "steps_per_m": 80000, "travel_steps": 48000, "max_mm_min": 3000, "accel_mm_s2": 150},
        {"name": "y", "pins": [3, 7], "steps_per_m": 80000, "travel_steps": 32000, "max_mm_min": 3000, "accel_mm_s2": 150},
        {"name": "z", "pins": [4, 8], "steps_per_m": 80000, "travel_steps": 12000, "max_mm_min": 1500, "accel_mm_s2": 100},
    ],
    # X2, the second motor of the gantry, and the encoders of both.
    "gantry": {"axis": "x", "pins": [5, 9], "wait_steps": 4, "limit_steps": 20},
    "encoders": [
        {"motor": "x", "pins": [18, 19], "pulses": 500, "steps": 400, "limit_steps": 40},
        {"motor": "x2", "pins": [20, 21], "pulses": 500, "steps": 400, "limit_steps": 40},
    ],
    # s_tvt: enable of the spindle's inverter, which is told direction and speed over its own line.
    "tool": {"pin": 10},
    "inverter": {"make": "teco", "port": "uart0", "tx": 0, "rx": 1, "baud": 9600},
    "registers": {"clock": 22, "latch": 26, "in": 27, "out": 28, "inputs": 1, "outputs": 1},
    "inputs": [
        # Contactors that open when hit: a broken wire reads as a hit.
        {"name": "bxa", "pin": 11, "active": 1, "pull": "up", "filter_us": 100},
        {"name": "bxb", "pin": 12, "active": 1, "pull": "up", "filter_us": 100},
        {"name": "bya", "pin": 13, "active": 1, "pull": "up", "filter_us": 100},
        {"name": "byb", "pin": 14, "active": 1, "pull": "up", "filter_us": 100},
        {"name": "bza", "pin": 15, "active": 1, "pull": "up", "filter_us": 100},
        {"name": "bzb", "pin": 16, "active": 1, "pull": "up", "filter_us": 100},
        # Behind the register, with pull-down resistors (sel: pull-up). A good drive reads 1; a broken wire reads as a fault.
        {"name": "dx1", "pin": 100, "active": 1, "filter_us": 100},
        {"name": "dx2", "pin": 101, "active": 1, "filter_us": 100},
        {"name": "dy", "pin": 102, "active": 1, "filter_us": 100},
        {"name": "dz", "pin": 103, "active": 1, "filter_us": 100},
        # urg: not filtered, but by 1 kΩ and 10 nF at the pin. It ends the steps within microseconds.
        {"name": "stop", "pin": 17, "active": 1, "pull": "up", "halt": True},
        # pal, the tool sensor: it also probes. Read every 3 ms, as all behind the register.
        {"name": "probe", "pin": 104, "active": 1},
        {"name": "sel", "pin": 105, "active": 1, "filter_us": 1000},
    ],
    "outputs": [
        {"name": "enable", "pin": 100, "active": 1},  # enm
        {"name": "vacuum", "pin": 101, "active": 1},  # s_asp
        {"name": "flood", "pin": 102, "active": 1},
        {"name": "mist", "pin": 103, "active": 1},
    ],
    "interlock": {
        "rows": {
            "hx": "!bxb & dx1 & dx2 & hxc & sel & sxc | !bxb & dx1 & dx2 & hxp & !sel & sxp"
            " | !bxa & dx1 & dx2 & hxc & sel & !sxc | !bxa & dx1 & dx2 & hxp & !sel & !sxp",
            "hx2": "!bxb & dx1 & dx2 & hx2c & sel & sx2c | !bxa & dx1 & dx2 & hx2c & sel & !sx2c",
            "hy": "!byb & dy & hyc & sel & syc | !byb & dy & hyp & !sel & syp"
            " | !bya & dy & hyc & sel & !syc | !bya & dy & hyp & !sel & !syp",
            # The other way round: up is blocked by bza, down by bzb and the tool sensor.
            "hz": "!bzb & dz & hzc & !pal & sel & !szc | !bzb & dz & hzp & !pal & !sel & !szp"
            " | !bza & dz & hzc & sel & szc | !bza & dz & hzp & !sel & szp",
            "sx": "sel & sxc | !sel & sxp",
            "sx2": "sel & sx2c",
            "sy": "sel & syc | !sel & syp",
            "sz": "sel & szc | !sel & szp",
            "enm": "rc0 & !urg | !sel & !urg",
            "s_tvt": "rc1 & !urg | !sel & !urg",
            "s_asp": "rc2 & sel | asp & !sel",
            # To the parallel port.
            "bxp": "bxb & !sel | bxa & !sel",
            "byp": "byb & !sel | bya & !sel",
            "bzp": "bzb & !sel | bza & !sel",
            "dfp": "!sel & urg",
            "pap": "pal & !sel",
            # The status multiplexer: address ra0 ra1 ra2.
            "ra3": "!dy & !ra0 & !ra1 & ra2 | ra0 & ra1 & !ra2 & syn | bzb & ra0 & !ra1 & !ra2 | bya & !ra0 & !ra1 & !ra2",
            "ra4": "!dninosx2 & ra0 & !ra1 & ra2 | !dx2 & !ra0 & !ra1 & ra2 | ra0 & ra1 & !ra2 & tvt"
            " | bza & ra0 & !ra1 & !ra2 | bxb & !ra0 & !ra1 & !ra2",
            "ra5": "!dz & ra0 & !ra1 & ra2 | !dx1 & !ra0 & !ra1 & ra2 | ra0 & ra1 & !ra2 & urg"
            " | pal & !ra0 & ra1 & !ra2 | byb & ra0 & !ra1 & !ra2 | bxa & !ra0 & !ra1 & !ra2",
        },
        "signals": {
            "hxc": "x.step", "sxc": "x.dir", "hx2c": "x.step", "sx2c": "x.dir",
            "hyc": "y.step", "syc": "y.dir", "hzc": "z.step", "szc": "z.dir",
            "rc0": "enable", "rc1": "tool", "rc2": "vacuum", "urg": "stop", "pal": "probe",
        },
        "elsewhere": "hxp sxp hyp syp hzp szp asp syn tvt dninosx2 ra0 ra1 ra2",
        "limits": {"x-": "bxa", "x+": "bxb", "y-": "bya", "y+": "byb", "z-": "bzb", "z+": "bza"},
        # With the selector at "parallel port" the drives are enabled, as then, once all has been at rest for so long.
        "unasked_ms": 500,
    },
    "homing": {
        "sensors": {"x": "bxa", "y": "bya", "z": "bza"},
        "order": "zxy",
        "high_end": "z",
        "seek_steps_s": 2000,
        "locate_steps_s": 200,
        "pull_off_steps": 160,
        "debounce_ms": 5,
    },
    "speed": {"unit": "steps_per_s", "default": 2000, "min": 10, "max": 4000},
    "planning": {"junction_um": 10, "arc_um": 2, "s_curves": True},
    "spindle": {"max_rpm": 18000, "min_rpm": 0, "spin_up_ms": 0, "coolant_ms": 0},
    "idle_release_ms": 0,
    "store_points": 500,
    # Where a job is, for `passo resume` and the page, after the PC or the power has failed.
    "journal": {"every_ms": 1000},
    # A program that asks for the status, and then says nothing for three seconds amid a job, has died: the machine comes to a
    # stand, Z goes up, the spindle goes off.
    "links": [
        {"name": "pc", "port": "usb", "protocol": "grbl", "lost": "retract"},
    ],
}

"""Meanings of the keys of a board file: the texts of docs/reference/board-file.md. reference.py puts them beside types and bounds.

    MEANINGS["axes.pins"]       # the dotted path of a key; [] of lists left out

Types, bounds and defaults are not repeated here: they come from the firmware's own table, config/boardfile.py.
"""

# Title and first sentence of each section, in the order of the page.
SECTIONS = {
    "": ("The board file", "The keys of `BOARD` itself. Sections of their own follow."),
    "drive": ("drive", "How the motors are driven; one kind for all axes."),
    "axes": ("axes", "A list, one entry an axis, in the order X, Y, Z, A."),
    "tool": ("tool", "The one output that is switched exact to the step: pen, spindle relay, laser, torch contact."),
    "inputs": ("inputs", "A list of switches and sensors. The effect of each depends on its [name](#names-with-a-meaning)."),
    "outputs": ("outputs", "A list of outputs. The effect of each depends on its [name](#names-with-a-meaning) or role."),
    "homing": ("homing", "Sensors to find zero with, and how."),
    "speed": ("speed", "Speeds of the plotter's and the torch's languages, in steps. G-code uses `max_mm_min`."),
    "planning": ("planning", "How paths are joined."),
    "spindle": ("spindle", "Range and analogue power of the tool, for G-code's S."),
    "jog": ("jog", "Jogs of the plotter's and the torch's languages."),
    "links": ("links", "A list of the board's serial lines, one entry a line. See [README](languages/README.md)."),
}

MEANINGS = {
    "name": "Name of the machine.",
    "chip": "The board's chip. Decides which pins exist and what `passo build` compiles for.",
    "clock_mhz": "Processor clock. RP2040: 125, 150 or 200; RP2350: 150; 0: the first of these. Leave it out on an ESP32.",
    "psram": "ESP32: True says that the module has PSRAM, as WROVER has, and S3 modules whose name ends in R2 or R8; on a plain ESP32 it takes "
    "pins 16 and 17. With False `passo build` refuses a board file that asks for more memory than the chip has. See [wiring](../start/wiring.md#esp32).",
    "player": "RP2040 and RP2350: `pio` steps without the processor and needs neighbouring pins; `timer` takes any pins and "
    "an interrupt for each step.",
    "changeover_by": "If outputs have roles: a command or the first motion takes the motors from the other controller.",
    "changeover_ms": "Between releasing the relays of one controller and closing the other's, ms.",
    "idle_release_ms": "Motors lose their current after this time at rest, ms; 0: never. `$1` overrides it.",
    "store_points": "Points of a stored drawing, if memory allows. Five bytes a point.",
    "commands": "Name of the link that may command at the start; empty: the first.",
    "drive.kind": "`step_dir`: drivers with STEP and DIR inputs. `unipolar`: four transistors a motor. `pbl3770a`: two such "
    "chips a motor.",
    "drive.mode": "Coil drives: `half` steps, `full` steps, `wave` (full steps, one coil at a time; `unipolar` only), `quarter` or `eighth` "
    "(of a full step, by the windings' currents; `pbl3770a` only).",
    "drive.pulse_us": "STEP/DIR: length of a step pulse and least pause behind it, µs. `$0` overrides it.",
    "drive.setup_us": "STEP/DIR: from a change of DIR to the next step, µs.",
    "drive.step_active": "STEP/DIR: level of a step pulse. 0: the pin is high at rest.",
    "drive.hold_ms": "From the last step to standstill current, ms.",
    "axes.name": "One letter. G-code wants `x`, `y`, `z` in this order.",
    "axes.pins": "STEP/DIR: `[STEP, DIR]`. Unipolar: the four transistors in the order of the coils. PBL3770A: `[PH, I0, I1]` "
    "of winding A, then of B.",
    "axes.steps_per_m": "Steps a metre: steps/mm × 1000. `$100` … override it.",
    "axes.travel_steps": "Length of the axis in steps. `$130` … override it.",
    "axes.reversed": "Turn the axis's direction round.",
    "axes.max_mm_min": "Highest speed, mm/min. `$110` … override it.",
    "axes.accel_mm_s2": "Acceleration, mm/s². `$120` … override it.",
    "axes.jog_steps": "Torch: steps of a jog; 0: `jog.steps`.",
    "axes.jog_steps_s": "Torch: speed of a jog, steps/s; 0: `speed.default`.",
    "tool.pin": "Its pin. With the player `pio` the neighbour of the last motor pin.",
    "tool.active": "Level that switches the tool on.",
    "tool.on_ms": "Wait after switching on, ms: the pen falls, the spindle spins up.",
    "tool.off_ms": "Wait after switching off, ms.",
    "inputs.name": "Its name.",
    "inputs.pin": "Its pin.",
    "inputs.filter_us": "Input of the interlock, or a limit without one (0: 50): a shorter change is a glitch, and only counted, µs. A true one "
    "acts that much later.",
    "inputs.active": "Level at which the input counts as active. 1 with a switch that opens when hit: a broken wire reads as a hit.",
    "inputs.pull": "The chip's own pull resistor. Not `down` on an rp2350: its erratum E9 ([silicon](../inside/silicon.md#rp2350)).",
    "inputs.halt": "Becoming active stops the steps in an interrupt, within microseconds (ESP32: milliseconds), and raises "
    "alarm 201. Active at the start: nothing moves.",
    "outputs.name": "Its name.",
    "outputs.pin": "Its pin.",
    "outputs.active": "Level that switches the output on.",
    "outputs.role": "`ours`: on while this board has the motors. `theirs`: on while the other controller has them. Both: relays "
    "or lamps of a change-over.",
    "homing.sensors": "Axis name → input name, for each axis that homes: `{\"x\": \"limit_x\"}`.",
    "homing.seek_steps_s": "Speed of the first search, steps/s. `$25` overrides it.",
    "homing.locate_steps_s": "Speed of the second, exact search, steps/s. `$24` overrides it.",
    "homing.pull_off_steps": "From the sensor's edge to the origin, steps. `$27` overrides it.",
    "homing.debounce_ms": "Longest bouncing of a switch, ms. `$26` overrides it.",
    "homing.required": "Plotter, torch, pulses, keys: refuse motion before homing. G-code asks for it by `$22`.",
    "homing.each": "By axis what differs from the keys above: `{\"y\": {\"pull_off_steps\": 100}}`; also `locate_steps_s`, `seek_steps_s`, and "
    "`distance_steps`: how far the search goes. `$24`, `$25` and `$27` override them for all axes.",
    "homing.latch": "`$HR=10` tells how well homing repeats. Takes about 1 kB of memory.",
    "homing.order": "Order of the axes, `\"zxy\"`; empty: as in `axes`. With a blank, those between two blanks home at once: `\"z xy\"`.",
    "homing.high_end": "Axes that home at the positive end of their travel, `\"z\"`. `$23` overrides it.",
    "speed.unit": "`steps_per_s`: along the path. `half_period_us`: half the time of a step of the axis with most steps, as the "
    "plotter of 2014 had it.",
    "speed.default": "Speed until a language sets another, in `unit`.",
    "speed.min": "Smallest value that is accepted, in `unit`.",
    "speed.max": "Largest value that is accepted, in `unit`.",
    "speed.overhead_us": "`half_period_us` only: added to each step, µs.",
    "planning.junction_um": "Junction deviation in µm: how fast corners are taken; 0: a stop at each. `$11` overrides it.",
    "planning.arc_um": "Kept for senders as `$12`; changes nothing.",
    "planning.independent_ramps": "Torch: axes accelerate with their `accel_mm_s2`, instead of running at one speed.",
    "spindle.max_rpm": "S at full power. `$30` overrides it.",
    "spindle.min_rpm": "Lowest S that turns. `$31` overrides it.",
    "spindle.pwm": "The tool has analogue power: a PWM signal on `pin`.",
    "spindle.pin": "Pin of the PWM; needed if `pwm` is True.",
    "spindle.pwm_hz": "Frequency of the PWM, Hz.",
    "spindle.laser": "Laser mode from the start. `$32` overrides it.",
    "spindle.spin_up_ms": "After door or hold: wait for the spindle before cutting goes on, ms. Not for lasers.",
    "spindle.coolant_ms": "After door or hold: wait for the coolant, ms.",
    "jog.steps": "Steps of a jog.",
    "jog.up": "Which way UP goes; DOWN is the opposite, LEFT and RIGHT the other axis.",
    "jog.ahead_ms": "A jog that is repeated asks for this much motion in advance, ms: the longest time that the axis runs on after "
    "the button is released.",
    "links.name": "Its name: `passo board --link NAME=PATH`, the log.",
    "links.port": "`usb`, or `uart0` …; with a [network](#network) also `http`, `page` and `tcp`. See the pins a UART may use in [wiring](../start/wiring.md#serial-lines).",
    "links.tx": "UART: the pin that sends.",
    "links.rx": "UART: the pin that receives.",
    "links.baud": "UART: bits a second.",
    "links.protocol": "The language: `plotter`, `grbl`, `torch`, `pulses` or `keys`.",
    "links.idle_gap_ms": "Plotter and torch: a silence of this many ms ends a torn packet.",
    "links.frames": "A program may ask for frames that prove themselves, see [frames](languages/frames.md).",
    "links.lost": "If the host is [lost](#a-lost-host) while its job is under way: `pause` holds, `stop` drops the job, `retract` takes Z up, too.",
    "links.lost_ms": "The host is lost if it says nothing for this time, ms.",
    "links.tell_end": "Torch: say FINISHED when a move has ended.",
}

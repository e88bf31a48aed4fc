"""How each key of a board file is changed: by a setting, on the page's card Settings or by `passo settings`, or in the file only, and the reason.

    setting_of("axes.steps_per_m")      # 100: of the first axis
    reason_of("inputs.pin")             # "wiring": a row of docs/reference/board-file.md
"""

# Key: the number of its setting; of an axis that of X.
SETTINGS = {
    "drive.pulse_us": 0, "idle_release_ms": 1, "planning.junction_um": 11, "planning.arc_um": 12, "homing.high_end": 23, "homing.locate_steps_s": 24,
    "homing.seek_steps_s": 25, "homing.debounce_ms": 26, "homing.pull_off_steps": 27, "spindle.max_rpm": 30, "spindle.min_rpm": 31, "spindle.laser": 32,
    "axes.steps_per_m": 100, "axes.max_mm_min": 110, "axes.accel_mm_s2": 120, "axes.travel_steps": 130, "axes.jog_steps": 150, "axes.jog_steps_s": 170,
    "speed.default": 180, "step_program.interval_us": 181, "step_program.default_mm_min": 182, "backlash": 160,
    "parking.axis": 42, "parking.target_mm": 58, "parking.mm_min": 59, "parking.pull_out_mm": 56, "parking.pull_out_mm_min": 57, "parking.at_end": 142,
    "tool_change.distance_mm": 342, "tool_change.locate_mm_min": 343, "tool_change.seek_mm_min": 344,
}  # fmt: skip
# Reason: the beginnings of the keys that are changed in the file for it. A key has the longest beginning that fits.
REASONS = {
    "wiring": (
        "axes.pins", "axes.name", "axes.reversed", "card", "chip", "drive", "drivers", "encoders", "gantry", "inputs", "outputs", "inverter", "registers", "servo",
        "shift", "spi_drivers", "spindle", "tachometer", "tool", "homing.sensors", "kinematics", "rotary", "player", "changeover_ms", "step_program.port_bits",
        "step_program.port_invert",
    ),
    "start": (
        "links", "network", "name", "commands", "clock_mhz", "psram", "store_points", "blackbox", "jobs", "journal", "step_program.cells", "speed.unit",
        "planning.s_curves",
    ),
    "safety": (
        "interlock", "changeover_by", "homing", "links.lost", "links.lost_ms", "encoders.limit_steps", "encoders.correct", "gantry.limit_steps", "inputs.halt",
        "inputs.filter_us", "network.presence", "network.legacy_http",
    ),
    "behaviour": (
        "planning.independent_ramps", "speed", "jog", "short_way", "weaving", "tool_change", "step_program", "spindle.coolant_ms", "spindle.spin_up_ms", "tool.on_ms",
        "tool.off_ms",
    ),
}  # fmt: skip


def setting_of(key):
    """The number of the setting that has the value on a running board; None: the board file alone has it."""
    return SETTINGS.get(key)


def reason_of(key):
    """Why a key is changed in the file only. Raises KeyError if no reason is given."""
    fitting = [(len(start), reason) for reason, starts in REASONS.items() for start in starts if f"{key}.".startswith(f"{start}.")]
    if not fitting:
        raise KeyError(key)
    return max(fitting)[1]

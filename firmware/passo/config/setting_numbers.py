"""The settings by number, grbl's if it has them: names, bounds and defaults, made from a checked board file once. A board forgets it when
that is done: it has better uses for the memory, and a build has numbers for these names.

    rules = setting_numbers.make(board)     # {number: (name, decimals, default, least, most)}
"""

from micropython import const

from passo.records import (
    SETTING_INCHES as INCHES, SETTING_LASER as LASER, SETTING_MAX_RPM as MAX_RPM, SETTING_REPORT as REPORT,
)  # fmt: skip
from passo.steps.ring import fastest
from passo.steps.word import TICKS_PER_S, us_to_ticks

PULSE_US = const(0)
IDLE_DELAY = const(1)
STEP_INVERT = const(2)
DIRECTION_INVERT = const(3)
ENABLE_INVERT = const(4)
LIMIT_INVERT = const(5)
PROBE_INVERT = const(6)
JUNCTION = const(11)
ARC = const(12)
SOFT_LIMITS = const(20)
HARD_LIMITS = const(21)
HOMING = const(22)
HOMING_DIRECTION = const(23)
HOMING_LOCATE = const(24)
HOMING_SEEK = const(25)
HOMING_DEBOUNCE = const(26)
HOMING_PULL_OFF = const(27)
MIN_RPM = const(31)
STEPS = const(100)
SPEED = const(110)
ACCELERATION = const(120)
TRAVEL = const(130)
START = const(140)  # Passo's own, and the next
JERK = const(141)  # of an option
JOG = const(150)  # languages that jog by steps have these, see their settings()
JOG_SPEED = const(170)
DRAWING_SPEED = const(180)
INTERVAL = const(181)
PROGRAM_SPEED = const(182)


def _active_level(items, names):
    """Return the active level of the first of `items` that has one of these names; 0 if there is none."""
    for item in items:
        if item["name"] in names:
            return item["active"]
    return 0


def longest_pulse_us(board):
    """Return the longest STEP pulse in µs, 100 at most, with which the board can make its board file's highest speed. A pulse and the low level
    behind it take the same time. With a longer pulse a board does not start. Drives without STEP pulses: 100."""
    if board["drive"]["kind"] != "step_dir":
        return 100
    steps_s = fastest(board["speed"], ())
    pulse_us = 500_000 // steps_s
    return min(pulse_us - (2 * us_to_ticks(pulse_us) * steps_s > TICKS_PER_S), 100)


def make(board):
    """Return {number: (name, decimals, default, least, most)}; lengths in mm, speeds in mm/min, jerk in mm/s³. Masks as grbl has them: steps whose
    pulse is low, directions where high is positive, drivers enabled by high, limits and a probe active when high, axes that home at their
    low end."""
    axes = board["axes"]
    mask = (1 << len(axes)) - 1
    homing = board["homing"]
    spindle = board["spindle"]
    steps_per_m = axes[0]["steps_per_m"]
    release_ms = board["idle_release_ms"]
    seek, locate, pull_off = 500_000, 25_000, 1_000
    if homing:
        seek = homing["seek_steps_s"] * 60_000_000 // steps_per_m
        locate = homing["locate_steps_s"] * 60_000_000 // steps_per_m
        pull_off = homing["pull_off_steps"] * 1_000_000 // steps_per_m
    directions = ends = 0
    limits = []  # names of the inputs
    table = {}
    for number, axis in enumerate(axes):
        name = axis["name"]
        sensor = homing["sensors"].get(name) if homing else None
        limits.append(sensor or "limit_" + name)
        directions |= (not axis["reversed"]) << number
        ends |= bool(sensor and name not in homing["high_end"]) << number
        travel_um = -(-axis["travel_steps"] * 1_000_000 // axis["steps_per_m"])
        table[STEPS + number] = (name + "_steps_mm", 3, axis["steps_per_m"], 1, 100_000_000)
        table[SPEED + number] = (name + "_max", 3, axis["max_mm_min"] * 1000, 1, 999_999_999)
        table[ACCELERATION + number] = (name + "_acceleration", 3, axis["accel_mm_s2"] * 1000, 1, 999_999_999)
        table[TRAVEL + number] = (name + "_travel", 3, travel_um, 1, 999_999_999)
    table.update({
        PULSE_US: ("step_pulse_us", 0, board["drive"]["pulse_us"], 3, longest_pulse_us(board)),
        IDLE_DELAY: ("idle_delay_ms", 0, min(release_ms, 254) if release_ms else 255, 0, 255),
        STEP_INVERT: ("step_invert", 0, 0 if board["drive"]["step_active"] else mask, 0, mask),
        DIRECTION_INVERT: ("direction_invert", 0, directions, 0, mask),
        ENABLE_INVERT: ("enable_invert", 0, _active_level(board["outputs"], ("enable",)), 0, 1),
        LIMIT_INVERT: ("limit_invert", 0, _active_level(board["inputs"], limits), 0, 1),
        PROBE_INVERT: ("probe_invert", 0, _active_level(board["inputs"], ("probe",)), 0, 1),
        REPORT: ("report_mask", 0, 3, 0, 255),
        JUNCTION: ("junction_deviation", 3, board["planning"]["junction_um"], 0, 10_000),
        ARC: ("arc_tolerance", 3, board["planning"]["arc_um"], 0, 10_000),
        INCHES: ("report_inches", 0, 0, 0, 1),
        SOFT_LIMITS: ("soft_limits", 0, 1 if homing else 0, 0, 1),
        HARD_LIMITS: ("hard_limits", 0, 0, 0, 1),
        HOMING: ("homing", 0, 1 if homing else 0, 0, 1 if homing else 0),
        HOMING_DIRECTION: ("homing_direction", 0, ends, 0, mask),
        HOMING_LOCATE: ("homing_locate", 3, locate, 1, 999_999_999),
        HOMING_SEEK: ("homing_seek", 3, seek, 1, 999_999_999),
        HOMING_DEBOUNCE: ("homing_debounce_ms", 0, homing["debounce_ms"] if homing else 5, 0, 1000),
        HOMING_PULL_OFF: ("homing_pull_off", 3, pull_off, 1, 1_000_000),
        MAX_RPM: ("spindle_max", 3, spindle["max_rpm"] * 1000, 1, 999_999_999),
        MIN_RPM: ("spindle_min", 3, spindle["min_rpm"] * 1000, 0, 999_999_999),
        LASER: ("laser", 0, 1 if spindle["laser"] else 0, 0, 1),
        START: ("start_speed", 3, 0, 0, 999_999_999),
    })  # fmt: skip
    return table

"""The three-axis router that LPTControl drove from a parallel port (2009), on a Pico: three STEP/DIR drivers, a tool.

Screws of 5 mm a turn and 400 steps/turn: 80 steps/mm. The drivers want 312 µs between pulses: 12.5 µm / 312 µs are
2403 mm/min, the fastest speed.
"""

BOARD = {
    "name": "lpt_router",
    "chip": "rp2040",
    # A pulse must be high, and low, for 10 µs.
    "drive": {"kind": "step_dir", "pulse_us": 10, "setup_us": 10},
    "axes": [
        # pins: STEP DIR
        {"name": "x", "pins": [2, 5], "steps_per_m": 80000, "travel_steps": 32000},
        {"name": "y", "pins": [3, 6], "steps_per_m": 80000, "travel_steps": 32000},
        {"name": "z", "pins": [4, 7], "steps_per_m": 80000, "travel_steps": 8000},
    ],
    "tool": {"pin": 8},
    "inputs": [
        # A normally closed button to ground: pressed, or its wire broken, it reads high.
        {"name": "stop", "pin": 16, "active": 1, "pull": "up", "halt": True},
        # Held at the start: the REPL instead of the machine.
        {"name": "repl", "pin": 22, "active": 0, "pull": "up"},
    ],
    "outputs": [
        {"name": "enable", "pin": 9, "active": 0},
    ],
    "speed": {"unit": "steps_per_s", "default": 1600, "min": 1, "max": 3200},
    "step_program": {
        "interval_us": 312,  # the drivers' pulse duration interval: it makes the fastest speed
        "default_mm_min": 1200,
        "cells": 4096,
        "dry_run": False,
        "port_bits": "76543210",
        "port_invert": 0x00,
    },
    "spindle": {"spin_up_ms": 4000},  # if a door is added: cutting waits so long for the spindle
    "idle_release_ms": 0,
    "store_points": 10,
    "links": [
        {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "pulses"},
    ],
}

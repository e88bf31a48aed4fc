"""The texts on the key `step_program` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "step_program": ("step_program", "Needed by the language `pulses`: paths written down step by step."),
}
MEANINGS = {
    "step_program.interval_us": "Least time between two pulses, µs: makes the fastest speed, `$`.",
    "step_program.default_mm_min": "Speed until the file sets one, mm/min, and of moves by hand.",
    "step_program.cells": "Memory for the file, four bytes each: one for a run of equal steps.",
    "step_program.accel_mm_s2": "`passo pulses ramps` writes speeds into a file that accelerate so, mm/s², and slow down at corners; 0: none.",
    "step_program.dry_run": "The tool stays off.",
    "step_program.port_bits": "At which bit of the image of the parallel port, and with `port_pins` on which line, drives, Z pulse, Z dir, Y pulse, Y dir, "
    "X pulse, X dir and tool appear; `-`: nowhere.",
    "step_program.port_invert": "Mask of the bits that appear inverted.",
}

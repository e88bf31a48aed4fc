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
PORTUGUESE = {
    "axis {}: a step program wants 100 steps/m or more": "axis {}: um programa de pulsos precisa de 100 passos/m ou mais",
    "step_program.interval_us: a pulse of {} µs, and as long without it, take more than {} µs": "step_program.interval_us: um pulso de {} µs, e o mesmo tempo sem ele, levam mais de {} µs",
    "step_program.port_bits: each of 0 … 7 once at most, and - for none, not {}": "step_program.port_bits: cada um de 0 … 7 no máximo uma vez, e - para nenhum, e não {}",
    "step_program.port_invert: {} is not within 0 … 255": "step_program.port_invert: {} não está dentro de 0 … 255",
    "{}a bit is disabled on an RP2040 or RP2350 only": "{}um bit só pode ser desativado em um RP2040 ou RP2350",
    "{}a parallel port has bits for one motor of each of three axes": "{}uma porta paralela tem bits para um motor de cada um de três eixos",
    "{}eight different GPIOs are wanted, those of D0 to D7": "{}são esperados oito GPIOs diferentes, os de D0 a D7",
    "{}the bits are those of STEP/DIR drivers": "{}os bits são os de acionamentos STEP/DIR",
    "{}the tool and the axes have to be there, but for their pins": "{}a ferramenta e os eixos têm de estar lá, exceto seus pinos",
}

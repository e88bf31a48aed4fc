"""The texts on the key `encoders` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "encoders": ("encoders", "A list, one entry a motor. See [encoders](../use/encoders.md)."),
}
MEANINGS = {
    "encoders.motor": "The motor that it is on: the name of its axis, or of a gantry's second motor.",
    "encoders.pins": "`[A, B]`, pulled up by the chip. On a Pico B is the pin next to A.",
    "encoders.pulses": "Pulses a turn of one of its wires: four counts each.",
    "encoders.steps": "Steps of the motor a turn, microsteps included.",
    "encoders.reversed": "It counts down as the axis steps forward.",
    "encoders.limit_steps": "A following error beyond it stops the machine at once: alarm 230. At least the two full steps that a rotor may "
    "lag under load.",
    "encoders.correct": "Steps that are missing at the end of a move are made up for.",
    "encoders.index": "Name of the input of its index pulse, if it has one: log entry 143 if the encoder itself loses counts.",
    "encoders.settle_ms": "Time from the last step until a motor is at rest, and its error exact, ms. The largest counts for all.",
}
PORTUGUESE = {
    "encoder {}: encoders want a step_dir drive": "encoder {}: encoders precisam de um acionamento step_dir",
    "encoder {}: its PIO program wants B on the pin next to A, [{}, {}]": "encoder {}: seu programa PIO precisa de B no pino ao lado de A, [{}, {}]",
    "encoders: {} has to be one of {}, each once": "encoders: {} tem de ser um de {}, cada um uma vez",
}

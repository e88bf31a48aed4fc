"""The texts on the key `tachometer` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "tachometer": (
        "tachometer",
        "The spindle's speed by pulses: no cut begins before it is reached, and none goes on without. See [spindle](../use/spindle.md#tachometer).",
    ),
}
MEANINGS = {
    "tachometer.input": "The input of its pulses, on a pin of its own.",
    "tachometer.pulses": "Pulses a turn; 5000 a second at most.",
    "tachometer.at_speed_percent": "At this distance from the speed asked for it is at speed.",
    "tachometer.spin_up_ms": "If it is not at speed by then, ms: alarm 244.",
}
PORTUGUESE = {
    "tachometer.input: {} needs a pin of its own, and no other use": "tachometer.input: {} precisa de pino próprio, sem outro uso",
    "tachometer.pulses: no more than 5000 a second: {} a turn": "tachometer.pulses: no máximo 5000 por segundo: {} por volta",
    "tachometer: the inverter says the speed itself; a laser has none": "tachometer: o próprio inversor diz a velocidade; um laser não tem nenhuma",
}

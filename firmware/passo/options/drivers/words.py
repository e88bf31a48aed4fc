"""The texts on the key `drivers` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "drivers": (
        "drivers",
        "TMC2209 or TMC2226 drivers, set up and watched over one UART wire. See [drivers](../use/drivers.md). Without it the drivers' own pins say "
        "current and microsteps.",
    ),
    "drivers.motors": ("drivers.motors", "A list, one entry a driver; an axis without one has a driver that its own pins set up."),
}
MEANINGS = {
    "drivers.port": "`uart0` or `uart1`, that no link has.",
    "drivers.tx": "TX pin, by 1 kΩ to the wire.",
    "drivers.rx": "RX pin, on the wire.",
    "drivers.baud": "Bits a second; a driver takes 9600 to 500 000 and finds out by itself.",
    "drivers.sense_mohm": "The resistors beside each driver, mΩ: 110 on most modules.",
    "drivers.motors.axis": "Name of its axis.",
    "drivers.motors.address": "As its pins MS1 and MS2 say: MS1 + 2 · MS2.",
    "drivers.motors.current_ma": "Current of a coil, RMS.",
    "drivers.motors.hold_percent": "Part of it at rest.",
    "drivers.motors.microsteps": "Microsteps a full step: 1, 2, 4 … 256, interpolated to 256.",
    "drivers.motors.stealth": "stealthChop, quiet; `False`: spreadCycle, more torque at speed.",
    "drivers.motors.stall": "Its axis homes by stall, on the driver's DIAG pin: half the SG_RESULT below which the motor has stalled. 0: it does not. See [drivers](../use/drivers.md#homing-by-stall).",
    "drivers.motors.stall_ma": "Current meanwhile. 0: `current_ma`.",
}
STATUS = {"Dr": "drivers"}
PORTUGUESE = {
    "drivers": "drivers",
    "drivers.motors: every {} once, not {}": "drivers.motors: cada {} uma vez, e não {}",
    "drivers.motors: stall: x and y share two motors: both or none": "drivers.motors: stall: x e y dividem dois motores: os dois ou nenhum",
    "drivers: they want a step_dir drive": "drivers: eles precisam de um acionamento step_dir",
    "drivers: {} belongs to {}; take another": "drivers: {} pertence a {}; use outra",
    "{}: homing.order: it homes alone, not with {}": "{}: homing.order: busca a origem sozinho, e não com {}",
    "{}: homing.sensors must name the input that its DIAG pin goes to": "{}: homing.sensors tem de nomear a entrada à qual vai o pino DIAG",
    "{}: its pull_off_steps are {} at least, 16 full steps, not {}": "{}: pull_off_steps é no mínimo {}, 16 passos inteiros, e não {}",
    "{}: microsteps are 1, 2, 4 … 256, not {}": "{}: micropassos são 1, 2, 4 … 256, e não {}",
    "{}: not with an interlock, and not of a gantry": "{}: não com intertravamento, nem de um pórtico",
    "{}: there is no such axis": "{}: não há esse eixo",
    "{}: {} mA are too much for {} mΩ": "{}: {} mA são demais para {} mΩ",
}

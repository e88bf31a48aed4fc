"""The texts on the key `gantry` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "gantry": ("gantry", "One axis with a motor at each side. See [encoders](../use/encoders.md#gantries)."),
}
MEANINGS = {
    "gantry.axis": "Name of the axis. Its second motor is called by that name and `2`: `x2`.",
    "gantry.pins": "`[STEP, DIR]` of the second motor: STEP behind the STEPs of the axes, DIR behind the DIRs.",
    "gantry.opposite": "The second motor turns the other way round.",
    "gantry.wait_steps": "With encoders: from this lag on a move waits until the lag is gone; 0: it never waits. Above what rotors lag under load.",
    "gantry.limit_steps": "With encoders: a lag beyond it stops the machine at once, alarm 231, and no larger one is squared.",
    "gantry.sensor": "Homing's sensor of the second side; that of the first is in `homing.sensors`. Empty: homing does not square.",
    "gantry.offset_steps": "How much farther from its sensor's edge the second side stands than the first when the gantry is square.",
    "gantry.rack_steps": "How far homing may move one side alone.",
}
PORTUGUESE = {
    "encoders: those of a gantry have the same pulses and steps": "encoders: os de um pórtico têm os mesmos pulsos e passos",
    "gantry.axis: there is no axis {}": "gantry.axis: não há eixo {}",
    "gantry.offset_steps: no more than rack_steps": "gantry.offset_steps: no máximo rack_steps",
    "gantry.sensor: axis {} has none of its own in homing.sensors": "gantry.sensor: o eixo {} não tem um próprio em homing.sensors",
    "gantry: two motors on one axis want a step_dir drive, pins [STEP, DIR]": "gantry: dois motores em um eixo precisam de um acionamento step_dir, pins [STEP, DIR]",
}

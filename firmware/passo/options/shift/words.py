"""The texts on the key `shift` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "shift": (
        "shift",
        "ESP32 and S3, STEP/DIR: motors and tool, and outputs as needed, are on 74HC595 shift registers. Their pins are 100 … 114: "
        "QA … QH of the first register, then of the second. See [wiring](../start/wiring.md#motors-on-shift-registers). Needs MicroPython 1.26.",
    ),
}
MEANINGS = {
    "shift.clock": "The pin at SRCLK (SH_CP) of all registers.",
    "shift.latch": "The pin at RCLK (ST_CP) of all registers. Frames are counted on it.",
    "shift.data": "The pin at SER (DS) of the first register.",
    "shift.enable": "The pin at OE of all registers; -1: OE is wired to ground.",
}
PORTUGUESE = {
    "drive.step_active: a frame of zeros would step; it has to be 1 with shift": "drive.step_active: um quadro de zeros daria um passo; com shift tem de ser 1",
    "shift: a frame of zeros would drop the coils; drive.kind has to be 'step_dir'": "shift: um quadro de zeros soltaria as bobinas; drive.kind tem de ser 'step_dir'",
    "shift: an {} cannot; {} can": "shift: um {} não consegue; conseguem: {}",
    "shift: no gantry; squaring it steps faster than frames follow": "shift: sem pórtico; esquadrá-lo dá passos mais rápido do que os quadros acompanham",
    "shift: no registers beside it; its own have outputs to spare": "shift: sem registers ao lado; os próprios têm saídas de sobra",
    "shift: no {} yet; frames already on their way would not obey it": "shift: ainda sem {}; quadros já a caminho não obedeceriam",
    "tool.active: a frame of zeros would switch the tool on; it has to be 1 with shift": "tool.active: um quadro de zeros ligaria a ferramenta; com shift tem de ser 1",
    "{}: with shift it is on an output of the register, {} … {}, not {}": "{}: com shift fica em uma saída do registrador, {} … {}, e não {}",
}

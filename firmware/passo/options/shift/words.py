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

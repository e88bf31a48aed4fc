"""The texts on the key `registers` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "registers": (
        "registers",
        "74HC165 and 74HC595 on four pins. An input with pin 100 is input A of the first 74HC165, an output with pin 100 is "
        "output QA of the first 74HC595. See [wiring](../start/wiring.md#shift-registers).",
    ),
    "registers.edges": ("registers.edges", "A list of pins at whose edges the inputs behind registers are read at once."),
}
MEANINGS = {
    "registers.clock": "CLK of the 74HC165, SRCLK of the 74HC595.",
    "registers.latch": "SH/LD of the 74HC165, RCLK of the 74HC595.",
    "registers.in": "QH of the first 74HC165.",
    "registers.out": "SER of the first 74HC595.",
    "registers.inputs": "Chips 74HC165: eight inputs each.",
    "registers.outputs": "Chips 74HC595: eight outputs each.",
    "registers.edges.pin": "The pin, at 1 while one of the inputs is.",
    "registers.edges.inputs": "Names of inputs behind 74HC165, with blanks between them.",
    "registers.tool": "The output, 100 … 123, that follows the tool's pin: within 3 ms, at once in a halt; -1: none.",
}

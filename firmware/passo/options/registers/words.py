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
PORTUGUESE = {
    "bit {} of the {} is claimed by {} and by {}": "o bit {} do {} é pedido por {} e por {}",
    "input {}: beside registers it cannot be on pin 23, 24 or 25": "input {}: ao lado de registradores não pode ficar no pino 23, 24 ou 25",
    "input {}: one that halts needs a pin of its own": "input {}: uma que para a máquina precisa de pino próprio",
    "input {}: {} needs a pin of its own, or one of registers.edges": "input {}: {} precisa de pino próprio, ou de um de registers.edges",
    "output {}: a relay of the change-over needs a pin of its own": "output {}: um relé da comutação precisa de pino próprio",
    "registers.edges: none can be on pin 23, 24 or 25": "registers.edges: nenhuma pode ficar no pino 23, 24 ou 25",
    "registers.edges: {} is no input behind a 74HC165": "registers.edges: {} não é entrada atrás de um 74HC165",
    "registers.tool: {} is no bit of the 74HC595": "registers.tool: {} não é um bit do 74HC595",
    "{} {}: registers.{} has {} bits, pins {} … {}, not {}": "{} {}: registers.{} tem {} bits, pinos {} … {}, e não {}",
}

"""The texts on the key `card` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "card": ("card", "A memory card (SD, FAT) on SPI, on which stored jobs are kept. See [jobs](../use/jobs.md#memory-card)."),
}
MEANINGS = {
    "card.spi": "RP2040, RP2350: 0 or 1; ESP32: 1 or 2.",
    "card.sck": "Pin at the card's CLK.",
    "card.mosi": "Pin at the card's DI.",
    "card.miso": "Pin at the card's DO, with a pull-up resistor of 10 kΩ.",
    "card.cs": "Pin at the card's CS.",
}
PORTUGUESE = {
    "card.{} of SPI {} is on pin {}, not {}": "card.{} do SPI {} fica no pino {}, e não {}",
    "card: it is for stored jobs, and there is no key jobs": "card: é para trabalhos guardados, e não há chave jobs",
}

"""The texts on the key `journal` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "journal": ("journal", "Keeps the state of a job in flash. See [jobs](../use/jobs.md#after-a-power-cut)."),
}
MEANINGS = {
    "journal.every_ms": "While the machine moves, age of the last record at most, ms; older once half the slots are used.",
    "journal.power": "Name of the input that is active when the power fails: the machine stops, and writes where it is.",
}
PORTUGUESE = {
    "journal: links speak grbl, or plotter or pulses, and not both": "journal: as ligações falam grbl, ou plotter ou pulses, e não ambos",
    "journal: raw pages of flash are for the RP2040 and RP2350": "journal: páginas cruas de flash são para o RP2040 e o RP2350",
}

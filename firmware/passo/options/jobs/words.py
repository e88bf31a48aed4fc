"""The texts on the key `jobs` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "jobs": ("jobs", "Programs kept on the board, and run without a PC. See [jobs](../use/jobs.md)."),
}
MEANINGS = {
    "jobs.language": "The language of stored jobs: that of one of the links.",
    "jobs.folder": "The folder that keeps them, in the board's flash; with `card`, of the card.",
    "jobs.button": "Name of the job that the input `job` runs.",
    "jobs.start": "Name of the job that runs when the board is switched on. With homing its first line is `$H`.",
}
PORTUGUESE = {
    "jobs.language: no link speaks {}": "jobs.language: nenhuma ligação fala {}",
    "jobs.{}: capitals, digits, '.', '_' and '-', not {}": "jobs.{}: maiúsculas, algarismos, '.', '_' e '-', e não {}",
    "links: {} is the link of stored jobs; take another name": "links: {} é a ligação dos trabalhos guardados; use outro nome",
}

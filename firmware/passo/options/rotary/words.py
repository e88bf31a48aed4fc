"""The texts on the key `rotary` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {}
MEANINGS = {
    "rotary": "The axis that turns, `a`; without the key none does. See [A rotary axis](../use/rotary.md).",
    "short_way": "An absolute word turns the axis of `rotary` by half a turn at most.",
}
PORTUGUESE = {
    "rotary: a link that speaks grbl is wanted": "rotary: é preciso uma ligação que fale grbl",
    "rotary: axes x, y, z, a are wanted": "rotary: são precisos os eixos x, y, z, a",
}

"""The texts on the key `rotary` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {}
MEANINGS = {
    "rotary": "The axis that turns, `a`; without the key none does. See [A rotary axis](../use/rotary.md).",
    "short_way": "An absolute word turns the axis of `rotary` by half a turn at most.",
}

"""The texts on the key `backlash` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {}
MEANINGS = {
    "backlash": "Lost motion of each axis in µm, `{\"x\": 40, \"y\": 50}`: the first values of `$160` to `$163`. See [backlash](../use/backlash.md). Without the key there are no such settings.",
}
PAGE = "../use/backlash.md"
AXIS_SETTINGS = {
    160: ("backlash, taken up where it turns", "mm", 0, 2),
}
PORTUGUESE = {
    "backlash, taken up where it turns": "folga, compensada onde o eixo volta",
}

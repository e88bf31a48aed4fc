"""The texts on the key `weaving` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "weaving": ("weaving", "Seams walked from side to side. See [weaving](../use/weaving.md)."),
}
MEANINGS = {
    "weaving.steady_mm_min": "Speed up to which the path has no ramps, as with `$140`: a seam is woven at constant speed, corners included.",
}

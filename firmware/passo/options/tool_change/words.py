"""What the key `tool_change` means: texts of docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "tool_change": (
        "tool_change",
        "M6 at a place of its own, and the new tool's length, in the way that `$341` says. See [spindle](../use/spindle.md#tool-change). Without it M6 is a pause where "
        "the head stands.",
    ),
}
MEANINGS = {
    "tool_change.at": "The place where tools are changed: machine coordinates of X and Y, whole mm.",
    "tool_change.sensor": "The place of the tool sensor, which is the input `probe`.",
    "tool_change.distance_mm": "Search for the sensor down to this distance below the top of Z, mm, `$342`; then alarm 205.",
    "tool_change.seek_mm_min": "Speed down to the sensor, mm/min, `$344`.",
    "tool_change.locate_mm_min": "Speed up from it, which finds the edge, mm/min, `$343`.",
}

"""The texts on the key `tool_change` for docs/reference/board-file.md. No board has this file."""

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
PAGE = "../use/spindle.md#tool-change"
SETTINGS = {
    341: ("M6: 0 pause, 1 touch plate, 2 and 3 sensor, 4 nothing", "", 0, 4),
    342: ("M6: how far down from the top to probe", "mm", 1, 1000),
    343: ("M6: speed up, to find the edge", "mm/min", 1, 1000),
    344: ("M6: speed down, to touch", "mm/min", 1, 10_000),
}
PORTUGUESE = {
    "M6: 0 pause, 1 touch plate, 2 and 3 sensor, 4 nothing": "M6: 0 pausa, 1 placa de toque, 2 e 3 sensor, 4 nada",
    "M6: how far down from the top to probe": "M6: até onde sondar, a partir do alto",
    "M6: speed up, to find the edge": "M6: velocidade de subida, para achar a borda",
    "M6: speed down, to touch": "M6: velocidade de descida, até tocar",
    "tool_change.{}: whole mm within {} … {} on {}": "tool_change.{}: mm inteiros dentro de {} … {} em {}",
    "tool_change: it wants axes x, y, z that home": "tool_change: precisa dos eixos x, y, z com busca da origem",
}

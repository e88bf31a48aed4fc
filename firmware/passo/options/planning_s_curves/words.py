"""The texts on the key `planning.s_curves` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {}
MEANINGS = {
    "planning.s_curves": "The jerk of ramps can be limited, by `$141`. See [S-curves](gcode.md#s-curves).",
}
KEY = "planning.s_curves"
PAGE = "gcode.md#s-curves"
SETTINGS = {
    141: ("jerk limit along the path: S-curves; 0: none", "mm/s³", 0, 999_999.999),
}
PORTUGUESE = {
    "jerk limit along the path: S-curves; 0: none": "limite de jerk na trajetória: curvas S; 0: nenhum",
}

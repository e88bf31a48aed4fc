"""The texts on the key `kinematics` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {}
MEANINGS = {
    "kinematics": "How motors move axes: `corexy`, two of them on one belt, see [CoreXY](../use/corexy.md); else each its own.",
}

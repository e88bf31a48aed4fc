"""The texts on the key `kinematics` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {}
MEANINGS = {
    "kinematics": "How motors move axes: `corexy`, two of them on one belt, see [CoreXY](../use/corexy.md); else each its own.",
}
PORTUGUESE = {
    "kinematics: a link that speaks grbl is wanted": "kinematics: é preciso uma ligação que fale grbl",
    "kinematics: remove {}: it wants a motor for each axis": "kinematics: remova {}: quer um motor para cada eixo",
    "kinematics: the language {} moves one axis by one motor": "kinematics: a linguagem {} move um eixo por um motor",
    "kinematics: two axes with the same steps_per_m are wanted": "kinematics: são precisos dois eixos com os mesmos steps_per_m",
}

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
    "backlash.{}: {} is not within 0 … {}": "backlash.{}: {} não está em 0 … {}",
    "backlash: a link that speaks grbl is wanted": "backlash: precisa de uma ligação que fale grbl",
    "backlash: remove kinematics: backlash is taken up where each motor moves its own axis": "backlash: remova kinematics: a folga é compensada onde cada motor move o próprio eixo",
    "backlash: remove rotary: a feed counts for all axes where backlash is taken up": "backlash: remova rotary: onde a folga é compensada, o avanço vale para todos os eixos",
    "backlash: remove {}: it reckons with motors that have none": "backlash: remova {}: ele conta com motores sem folga",
    "backlash: the language {} moves by single steps, which take up none": "backlash: a linguagem {} move por passos isolados, que não compensam folga",
    "backlash: there is no axis {}": "backlash: não há eixo {}",
}

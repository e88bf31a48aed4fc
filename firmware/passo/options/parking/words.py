"""The texts on the key `parking` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "parking": (
        "parking",
        "While the door is open, an axis goes up from the work, and comes back. See [parking](../use/parking.md). Without it the tool goes off where it stands.",
    ),
}
MEANINGS = {
    "parking.axis": "The axis, `$42`. It homes.",
    "parking.target_mm": "Machine coordinate that it goes up to, mm, `$58`.",
    "parking.mm_min": "Speed to the target and back, mm/min, `$59`.",
    "parking.pull_out_mm": "How far it goes first, while the spindle still turns, mm, `$56`.",
    "parking.pull_out_mm_min": "Speed of that, and of the way back into the work, mm/min, `$57`.",
    "parking.at_end": "True: M2 and M30 go up to the target, too, `$142`.",
}
PAGE = "../use/parking.md"
SETTINGS = {
    41: ("parking while the door is open", "", 0, 1),
    42: ("parking: axis, 0 is X", "", 0, 2),
    56: ("parking: how far the tool is pulled out", "mm", 0, 500),
    57: ("parking: speed out of the work and back", "mm/min", 0.001, 100_000),
    58: ("parking: target, machine coordinate", "mm", -2000, 2000),
    59: ("parking: speed to the target and back", "mm/min", 0.001, 100_000),
    142: ("parking at a program's end", "", 0, 1),
}
PORTUGUESE = {
    "parking while the door is open": "estacionamento enquanto a porta está aberta",
    "parking: axis, 0 is X": "estacionamento: eixo, 0 é X",
    "parking: how far the tool is pulled out": "estacionamento: quanto a ferramenta sai da peça",
    "parking: speed out of the work and back": "estacionamento: velocidade ao sair da peça e ao voltar",
    "parking: target, machine coordinate": "estacionamento: alvo, coordenada de máquina",
    "parking: speed to the target and back": "estacionamento: velocidade até o alvo e de volta",
    "parking at a program's end": "estacionamento no fim do programa",
    "parking: it wants an axis {} that homes": "parking: precisa de um eixo {} que faça referência",
    "parking: links that speak grbl, and no other, are wanted": "parking: precisa de ligações que falem grbl, e só delas",
    "parking: remove {}: it parks one axis, by its own motor": "parking: remova {}: um eixo sobe pelo próprio motor",
}

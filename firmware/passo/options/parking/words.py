"""What the key `parking` means: texts of docs/reference/board-file.md. No board has this file."""

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

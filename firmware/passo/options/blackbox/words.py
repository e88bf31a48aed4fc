"""The texts on the key `blackbox` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {}
MEANINGS = {
    "blackbox": "True: keep the last seconds before an alarm, a crash or a reset. See [black box](../use/blackbox.md).",
}

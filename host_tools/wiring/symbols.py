"""Symbols of parts, as SVG paths in a field of 9 × 6 mm, drawn from its middle: x from -4.5 to 4.5, y from -3 to 3.

    symbol_of("switch", "open")     # what stands inside of <g transform="translate(x y)">
"""

_MOTOR = '<circle r="2.6" cx="1"/><path d="M-.1 1.2V-1.2L1 .4 2.1-1.2V1.2M-4.4-1.2H-1.2M-4.4 1.2H-1.2"/>'
_COIL = '<path d="M-4.4-1.8H-3M-4.4 1.8H-3M-3-1.8C-1.4-1.8-1.4-.6-3-.6-1.4-.6-1.4.6-3 .6-1.4.6-1.4 1.8-3 1.8"/>'
_GROUND = '<path d="M4 0V1.6M2.9 1.6H5.1M3.4 2.2H4.6"/>'
_RELAY = '<path d="M-4-1.8H-.6V1.8H-4ZM-3.2 1-1.4-1M.4 0H1.4L4.4-1.8M3.6 0H4.4"/>'

SYMBOLS = {
    "driver": _MOTOR,
    "coils": _COIL + '<circle r="2.2" cx="2"/><path d="M1.1 1V-1L2 .3 2.9-1V1"/>',
    "coil": _COIL + '<path d="M-.6-2V2M.2-2V2"/>',
    "switch opens": '<path d="M-4.4 0H-2.4L2 .1M1.4 0V-1.4M2 0H4"/>' + _GROUND,
    "switch closes": '<path d="M-4.4 0H-2.4L1.6-1.7M2 0H4"/>' + _GROUND,
    "stop": '<path d="M-4.4 1H-2.4L2 1.1M1.4 1V-.2M2 1H4V1.8M2.9 1.8H5.1M3.4 2.4H4.6M-.4 1V-1.4M-2-1.4H1.2A1.6 1.3 0 0 0-2-1.4Z"/>',
    "barrier": '<path d="M-3.4-1.4 -1.4 0-3.4 1.4ZM-1.4-1.4V1.4M-.6-.9 .6-.9M-.6 .9 .6 .9M1.6-1.8V1.8M1.6-.7 3.6-2M1.6 .7 3.6 2"/>',
    "probe": '<path d="M-1.2-2.8H1.2V-.2L0 1.2-1.2-.2ZM-3.6 2H3.6V2.8H-3.6Z"/>',
    "signal": '<path d="M-4.2 1.4H-2V-1.4H.6V1.4H2.8V-1.4H4.2"/>',
    "relay": _RELAY,
    "contact": _RELAY,
    "lamp": '<circle r="2.2"/><path d="M-1.55-1.55 1.55 1.55M-1.55 1.55 1.55-1.55"/>',
    "laser": '<path d="M-4 -1.4H.4V1.4H-4ZM.4 0H4.4M2-1.8 2.9-.9M2 1.8 2.9 .9M3.6-1.2V1.2"/>',
    "spindle": '<path d="M-1.6-2.8H1.6V.4H-1.6ZM-.7 .4H.7V1.4H-.7ZM-.5 1.4 0 2.9 .5 1.4M-3.4-1.6A3.4 1.4 0 0 0-2.4 .4"/>',
    "encoder": '<circle r="2.6"/><circle r=".5"/><path d="M0-2.6V-1.7M0 2.6V1.7M-2.6 0H-1.7M2.6 0H1.7M-1.8-1.8-1.2-1.2M1.8 1.8 1.2 1.2M-1.8 1.8-1.2 1.2M1.8-1.8 1.2-1.2"/>',
    "serial": '<path d="M-4 .8H4M2.9-.1 4 .8 2.9 1.7M4-1H-4M-2.9-1.9-4-1-2.9-.1"/>',
    "diodes": '<path d="M-4 0H-1.4M-1.4-1.6V1.6L1.4 0ZM1.4-1.6V1.6M1.4 0H4"/>',
    "registers": "",
    "none": '<path d="M-1.6-1.6 1.6 1.6M-1.6 1.6 1.6-1.6"/>',
}
# Wires and frames by the kind of part. Dark enough on white for print: contrast 4.5 at least.
COLOURS = {
    "driver": "#0b57c4", "coils": "#0b57c4", "switch": "#1b7a2f", "probe": "#1b7a2f", "barrier": "#1b7a2f", "signal": "#1b7a2f",
    "stop": "#c81010", "relay": "#8a4b08", "lamp": "#8a4b08", "coil": "#b4390b", "contact": "#b4390b", "laser": "#b4390b", "spindle": "#b4390b",
    "encoder": "#7a1fa2", "serial": "#44546a", "registers": "#00707a", "diodes": "#1b7a2f", "none": "#6b6b6b",
}  # fmt: skip
# The second, fourth … terminal of a part with many wires: a lighter wire, so that neighbours differ.
LIGHTER = {"driver": "#2d86d9", "coils": "#2d86d9", "encoder": "#b04bd0"}
# Symbols that show the ground themselves.
GROUNDED = ("switch", "stop", "probe")


def symbol_of(kind, opens):
    """Return the symbol of a kind of part; `opens`: of a switch, that it opens when hit. Raises KeyError for an unknown kind."""
    return SYMBOLS[f"switch {'opens' if opens else 'closes'}" if kind == "switch" else kind]

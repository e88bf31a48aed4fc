"""The small router of router_3axis on a Raspberry Pi Pico W that serves its own page: the Pico's pins, and Passo's UF2 for the Pico W
(docs/inside/build.md), because the modules as files do not fit into its memory. GP23, GP24, GP25 and GP29 are the radio's, which is off until
`passo wifi` has given it a name and a passphrase (docs/use/network.md).
"""

BOARD = {
    "like": "router_3axis",
    "name": "router_pico_w",
    # Programs that the page has uploaded lie in flash, and run from there.
    "jobs": {"language": "grbl"},
    "network": {"host": "passo"},
    "links": {
        "serial": None,  # the page takes its place
        "page": {"port": "page", "protocol": "grbl"},
    },
}

"""The plotter of 2014 on a Raspberry Pi Pico W that serves its own page: draw from a phone, without a PC. The radio is off until
`passo wifi` has given it a name and a passphrase (docs/use/network.md). GP23, GP24, GP25 and GP29 are the radio's.
"""

BOARD = {
    "like": "plotter_2014",
    "name": "plotter_page",
    # A Pico W has no room for more beside the page; a longer drawing is drawn while it arrives.
    "store_points": 256,
    # Drawings that a phone has uploaded lie in flash, and are drawn from there.
    "jobs": {"language": "plotter"},
    "network": {"host": "passo"},
    "links": [
        {"name": "page", "port": "page", "protocol": "plotter"},
    ],
}

"""The welding-torch manipulator Tartílope V2F (2020) on a Raspberry Pi Pico W: the wiring of torch_manipulator, and the HTTP table
of its ESP32 over Wi-Fi. The radio is off until `passo wifi` has given it a name and a passphrase. GP23, GP24, GP25 and GP29 are
the radio's.
"""

BOARD = {
    "like": "torch_manipulator",
    "name": "torch_pico_w",
    "weaving": None,
    # The program of 2020 sends no key. True: from the board's own access point it may move the machine for as many minutes as
    # somebody at the machine gives it, by the button or by `passo torch admit`.
    "network": {"host": "passo", "legacy_http": False, "button": "admit", "minutes": 10},
    "inputs": [
        {"name": "admit", "pin": 14, "active": 0, "pull": "up"},
    ],
    "links": [
        {"name": "wifi", "port": "http", "protocol": "torch"},
    ],
}

"""The texts on the key `network` for docs/reference/board-file.md. No board has this file."""

SECTIONS = {
    "network": (
        "network",
        "Wi-Fi of a Pico W or an ESP32: links with the port `http` (torch), `page` (the page) or `tcp` (grbl). The radio is off until `passo wifi` has given it a name and a "
        "passphrase. See [network](../use/network.md).",
    ),
}
MEANINGS = {
    "network.host": "The board's name in the network: `http://passo.local/`.",
    "network.http_port": "TCP port of the links with the ports `http` and `page`.",
    "network.tcp_port": "TCP port of the links with the port `tcp`.",
    "network.legacy_http": "Torch: a program without the key may move the machine, from the board's own access point only, and only for the minutes "
    "that somebody at the machine gives.",
    "network.button": "Name of the input of the button that gives `minutes`; empty: there is none, only `passo torch admit`.",
    "network.presence": "Name of an input: over the network the spindle goes on, and a hold ends, only while it is active. Empty: always.",
    "network.minutes": "Minutes that the button gives.",
    "network.broker": "An MQTT broker that the board tells its state, and from which STOP comes: `192.168.1.5` or `192.168.1.5:1884`, without TLS; its topics are "
    "`passo/HOST/…`, see [network](../use/network.md#a-broker). Wants a link on `page`, and umqtt. Empty: none.",
    "network.broker_user": "The broker's user for this board; empty: none.",
    "network.broker_password": "That user's password.",
}
PORTUGUESE = {
    "link {}: frames and lost are for cables": "link {}: frames e lost são para cabos",
    "link {}: http is for the protocol torch": "link {}: http é para o protocolo torch",
    "link {}: tcp is for the protocol grbl": "link {}: tcp é para o protocolo grbl",
    "network.broker: an address such as 192.168.1.5, or 192.168.1.5:1884, not {}": "network.broker: um endereço como 192.168.1.5, ou 192.168.1.5:1884, e não {}",
    "network.broker: the broker is told what pages are: a link on page is wanted": "network.broker: ao broker se diz o que se diz às páginas: é preciso uma ligação em page",
    "network.broker: umqtt is not on this board: mpremote mip install umqtt.simple": "network.broker: umqtt não está nesta placa: mpremote mip install umqtt.simple",
    "network.host: small letters, digits and - only, not {}": "network.host: só letras minúsculas, algarismos e -, e não {}",
    "network: one link on http, one on page, and one on tcp, at most": "network: no máximo uma ligação em http, uma em page e uma em tcp",
    "network: the first link is a cable": "network: a primeira ligação é um cabo",
    "network: there is no page for {} on this board": "network: não há página para {} nesta placa",
}

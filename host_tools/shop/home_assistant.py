"""Home Assistant's MQTT discovery of a machine: a retained message for each thing that it shows.

    for topic, text in discovery_messages("homeassistant", "passo/", "plotter-3").items(): …

https://www.home-assistant.io/integrations/mqtt/#mqtt-discovery
"""

import json

from host_tools.language import N_, _
from host_tools.resources import version
from host_tools.shop.state_topics import GONE

_OR_NONE = {"value_template": "{{ value or 'None' }}"}  # Home Assistant leaves a number as it was if "" comes, behind a job's end
# (kind, object, name, what else)
_SHOWN = (
    ("sensor", "state", N_("state"), {"icon": "mdi:state-machine"}),
    ("sensor", "job", N_("job"), {"icon": "mdi:file-outline"}),
    ("sensor", "progress", N_("progress"), {"unit_of_measurement": "%", "state_class": "measurement", **_OR_NONE}),
    ("sensor", "left", N_("time left"), {"unit_of_measurement": "s", "device_class": "duration", **_OR_NONE}),
    ("sensor", "alarm", N_("alarm"), {"icon": "mdi:alert", "value_template": "{{ value[:255] }}"}),
    ("button", "stop", N_("STOP"), {"icon": "mdi:stop-circle", "payload_press": "Home Assistant", "qos": 1, "retain": False}),
)


def discovery_messages(prefix, root, name):
    """The discovery messages of a machine, {topic: JSON}. `prefix`: Home Assistant's own; the machine's topics begin with `root` and `name`."""
    own = f"{root}{name}/"
    identity = "passo_" + "".join(letter if letter.isalnum() or letter in "_-" else "_" for letter in name)
    common = {
        "availability_topic": own + "state",
        "availability_template": "{{ 'offline' if value == '%s' else 'online' }}" % GONE,
        "device": {"identifiers": [identity], "name": name, "manufacturer": "Passo", "model": "Passo", "sw_version": version()},
        "origin": {"name": "Passo", "sw_version": version()},
    }
    found = {}
    for kind, item, text, more in _SHOWN:
        topic = {"command_topic" if kind == "button" else "state_topic": own + item}
        config = {"name": _(text), "unique_id": f"{identity}_{item}", "default_entity_id": f"{kind}.{identity}_{item}", **topic, **more, **common}
        found[f"{prefix}/{kind}/{identity}/{item}/config"] = json.dumps(config, ensure_ascii=False)
    return found

"""STOP for all, to the last step: machines that draw in real time, agents, a Mosquitto, and a message to passo/stop.

    python tests_host/sims/shop_stop.py MACHINES TIMES

Prints, of all machines and times, how many milliseconds after the message a machine made its last step, by the PC's clock: the boards look at it
behind each cycle of their main loop.
"""

import json
import shutil
import sys
import tempfile
import time
from pathlib import Path

import paho.mqtt.client as mqtt
import shop_load
from paho.mqtt.enums import CallbackAPIVersion

_LINES, _FEED = 400, 1500  # 40 mm each, at 25 mm/s
_READY_S = 600
_DRAW_S = 3.0
_STILL_S = 6.0  # then each board has written when it moved last


def program(number):
    lines = ["G21 G90", "M3 S1000"]
    for line in range(_LINES):
        lines.append(f"G1 X{45 if line % 2 else 5} Y{5 + line % 40} F{_FEED}")
    return "\n".join([*lines, "M5", ""]).encode()


def all_draw(load):
    """Wait until all have drawn for a while: a machine on its way back to its job's place draws for a moment only."""
    limit = time.monotonic() + _READY_S
    since = None
    while True:
        load.people(len(load.names))
        if len(load.drawing) < len(load.names):
            since = None
        elif time.monotonic() - (since or time.monotonic()) > _DRAW_S:
            return
        else:
            since = since or time.monotonic()
        assert time.monotonic() < limit, f"{len(load.drawing)} of {len(load.names)} draw"
        time.sleep(0.5)


def stop(load, client):
    """[milliseconds from the message to the last step] of all machines."""
    said = time.time()
    client.publish("passo/stop", "", 1).wait_for_publish(10)
    time.sleep(_STILL_S)
    moved = {name: float((load.folder / name / "moved").read_text()) for name in load.names}
    assert time.time() - max(moved.values()) > _STILL_S / 2, "a machine goes on"
    assert time.time() - min(moved.values()) < _STILL_S + 2, "a machine stood before"
    return [max(0.0, 1000 * (each - said)) for each in moved.values()]


def measure(folder, machines, times):
    load = shop_load.Load(folder, machines, machines, mode="real", make=program)
    client = mqtt.Client(CallbackAPIVersion.VERSION2, "stop-button", protocol=mqtt.MQTTv5)
    try:
        client.connect("127.0.0.1", load.broker_port)
        client.loop_start()
        found = []
        for _time in range(times):
            all_draw(load)
            found += stop(load, client)
        return sorted(found)
    finally:
        client.loop_stop()
        load.close()


def main():
    machines, times = map(int, sys.argv[1:])
    folder = Path(tempfile.mkdtemp(prefix="shop-"))
    try:
        found = measure(folder, machines, times)
        print(json.dumps({"machines": machines, "stops": times, "median ms": round(found[len(found) // 2]), "p99 ms": round(found[int(0.99 * (len(found) - 1))]), "worst ms": round(found[-1])}))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()

"""Shift registers: the chains' model edge by edge, the bits that the generic code puts on the wires, and the values of a board file."""

import sys
import time
import types
from random import Random

import pytest

from host_tools import boards
from host_tools.emulator.shift_registers import Chains
from host_tools.sim.machine import VirtualMachine
from passo.config.boardfile import BoardError, check

pytestmark = pytest.mark.quick

PINS = {"clock": 17, "latch": 18, "in": 19, "out": 20, "tool": -1}


class Pads:
    """A Pico of four pins: the chains read the firmware's levels, and the other way round."""

    def __init__(self):
        self.levels = {}
        self.heard = {}
        self.pads = self

    def add_listener(self, pin, heard):
        self.heard[pin] = heard

    def state_of(self, pin):
        return self.levels.get(pin, 2)

    def drive_pin(self, pin, level):
        self.levels[pin] = level

    def write(self, pin, level):
        before = self.levels.get(pin)
        self.levels[pin] = level
        if level != before and pin in self.heard:
            self.heard[pin](pin, level)


@pytest.fixture
def shifted(monkeypatch):
    """passo.options.registers.port on these pads."""
    pico = Pads()

    class Pin:
        IN, OUT, IRQ_RISING, IRQ_FALLING = 0, 1, 4, 8

        def __init__(self, number, mode=None, value=None):
            self.number = number
            if value is not None:
                pico.write(number, value)

        def value(self, level=None):
            if level is None:
                return pico.levels.get(self.number, 0)
            pico.write(self.number, level)

    machine = types.SimpleNamespace(Pin=Pin, disable_irq=lambda: 1, enable_irq=lambda state: None)
    monkeypatch.setitem(sys.modules, "machine", machine)
    monkeypatch.setattr(time, "ticks_us", lambda: time.perf_counter_ns() // 1000, raising=False)
    monkeypatch.setattr(time, "ticks_diff", lambda end, begin: end - begin, raising=False)
    monkeypatch.delitem(sys.modules, "passo.options.registers.port", raising=False)
    import passo.options.registers.port as module

    yield pico, module
    sys.modules.pop("passo.options.registers.port", None)


@pytest.mark.parametrize("chips", [(1, 1), (2, 1), (1, 3), (3, 2), (0, 1), (2, 0)])
def test_every_bit_arrives(shifted, chips):
    pico, module = shifted
    config = {**PINS, "inputs": chips[0], "outputs": chips[1]}
    changed = []
    chains = Chains(pico, config, lambda bit, level: changed.append((bit, level)))
    registers = module.ShiftRegisters(config, 0)
    random = Random(1)
    for _ in range(50):
        wanted_in = [random.randint(0, 1) for _ in range(8 * chips[0])]
        for bit, level in enumerate(wanted_in):
            chains.set_input(bit, level)
        registers.outputs = random.getrandbits(8 * chips[1]) if chips[1] else 0
        changed.clear()
        before = list(chains.outputs)
        registers.exchange()
        assert [registers.inputs >> bit & 1 for bit in range(len(wanted_in))] == wanted_in
        assert chains.outputs == [registers.outputs >> bit & 1 for bit in range(8 * chips[1])]
        assert sorted(changed) == [(bit, now) for bit, now in enumerate(chains.outputs) if now != before[bit]], "each once"


def test_an_output_and_an_input(shifted):
    pico, module = shifted
    config = {**PINS, "inputs": 1, "outputs": 1}
    chains = Chains(pico, config, lambda bit, level: None)
    registers = module.ShiftRegisters(config, module.first_levels({"outputs": [{"pin": 103, "active": 0}, {"pin": 102, "active": 1}], "registers": config}))
    registers.exchange()
    assert chains.outputs == [0, 0, 0, 1, 0, 0, 0, 0]
    module.RegisterOutput({"pin": 105}, registers).value(1)
    assert chains.outputs[5] == 1 and chains.outputs[3] == 1
    door = module.RegisterInput({"name": "door", "pin": 101, "active": 0}, registers)
    assert door.active()
    chains.set_input(1, 1)
    before = registers.changes
    registers.exchange()
    assert not door.active() and registers.changes == before + 1


def router(**keys):
    board = boards.load("router_3axis")
    board["registers"] = {**PINS, "inputs": 1, "outputs": 1}
    board["outputs"] = [{"name": "flood", "pin": 100}]
    board.update(keys)
    return board


def refused(text, **keys):
    with pytest.raises(BoardError, match=text):
        check(router(**keys))


def test_what_a_board_file_may_say():
    assert check(router())["registers"]["inputs"] == 1
    refused("registers.outputs has 8 bits, pins 100 … 107, not 108", outputs=[{"name": "flood", "pin": 108}])
    refused("claimed by flood and by mist", outputs=[{"name": "flood", "pin": 101}, {"name": "mist", "pin": 101}])
    refused("there is none", registers=None)
    refused("pin 17 is claimed", outputs=[{"name": "flood", "pin": 17}])
    inputs = boards.load("router_3axis")["inputs"]
    for name, why in (("limit_x", "homing's sensor needs a pin of its own, or one of registers.edges"), ("stop", "one that halts needs a pin of its own")):
        refused(why, inputs=[{**item, "pin": 100} if item["name"] == name else item for item in inputs])
    refused("pin 23, 24 or 25", inputs=[{**item, "pin": 24} if item["name"] == "door" else item for item in inputs])


def test_an_edge_has_the_inputs_read_at_once(shifted):
    """A limit behind a register, with a filter of two readings; its pin of registers.edges calls edge()."""
    pico, module = shifted
    config = {**PINS, "inputs": 1, "outputs": 1}
    chains = Chains(pico, config, lambda bit, level: None)
    registers = module.ShiftRegisters(config, 0)
    limit = module.RegisterInput({"name": "limit", "pin": 101, "active": 1}, registers)
    told = []
    interlock = types.SimpleNamespace(
        items=[limit], watched=1, rise=1, fall=0, states=0, filters_us=[100], glitches=[0], take_change=lambda *change: told.append(change)
    )
    watch = module.RegisterWatch(interlock, registers)
    watched = []
    port = types.SimpleNamespace(watch=lambda pin, handler, edge: watched.append((pin.number, handler)))
    watch.watch_edges(port, [{"pin": 7, "inputs": "limit"}], [{"name": "limit", "filter_us": 100}])
    assert watched == [(7, watch.on_edge)]
    chains.set_input(1, 1)
    watch.on_edge(None)
    assert told == [(0, 1)], "it has lasted for two readings"
    interlock.states = 1
    watch.on_edge(None)
    assert told == [(0, 1)]
    interlock.states = 0
    chains.set_input(1, 0)
    watch.on_edge(None)
    chains.set_input(1, 1)
    registers.exchange()
    watch.look()  # the feeder's
    chains.set_input(1, 0)
    watch.on_edge(None)
    assert told == [(0, 1)] and interlock.glitches == [1], "it was over at the second reading"


def test_an_output_shows_the_tool(shifted):
    pico, module = shifted
    config = {**PINS, "inputs": 0, "outputs": 1, "tool": 106}
    chains = Chains(pico, config, lambda bit, level: None)
    registers = module.ShiftRegisters(config, module.first_levels({"outputs": [], "registers": config, "tool": {"active": 1}}))
    registers.exchange()
    registers.show_tool(23)
    for level in (1, 0, 1):
        pico.write(23, level)
        registers.exchange()
        assert chains.outputs[6] == level


def test_limits_behind_registers_want_an_edge():
    inputs = [{**item, "pin": 100} if item["name"] == "limit_x" else item for item in boards.load("router_3axis")["inputs"]]
    edges = [{"pin": 22, "inputs": "limit_x"}]
    registers = {**PINS, "inputs": 1, "outputs": 1}
    assert check(router(inputs=inputs, registers={**registers, "edges": edges}))
    refused("no input behind a 74HC165", registers={**registers, "edges": edges})
    refused("pin 23, 24 or 25", inputs=inputs, registers={**registers, "edges": [{"pin": 24, "inputs": "limit_x"}]})
    refused("pin 17 is claimed", inputs=inputs, registers={**registers, "edges": [{"pin": 17, "inputs": "limit_x"}]})
    refused("claimed by tool and by flood", registers={**registers, "tool": 100})
    refused("no bit of the 74HC595", registers={**registers, "tool": 108})


# --- the whole mill


def test_the_tables_of_both_mills_are_the_same():
    small, large = boards.load("mill_2004"), boards.load("mill_pico_2")
    for key in ("interlock", "homing", "speed"):
        assert small[key] == large[key]


@pytest.mark.parametrize("name", ["mill_2004", "mill_pico_2"])
def test_the_whole_mill_cuts(name):
    """Gantry, encoders, registers and inverter at once, on the virtual port."""
    machine = VirtualMachine(name, start=(800, 800, -800), trace=None)
    machine.run_ms(100)
    machine.send(b"$X\nM3 S9000\nG91 G1 X10 Y5 F1200\nM5\nG4 P0.1\n")
    machine.run_until(lambda: machine.replies_so_far().count(b"ok") >= 5, 20_000)
    machine.settle()
    assert machine.plant.position == [1600, 1200, -800] and machine.plant.second.position == 1600
    assert machine.plant.errors == [] and not machine.app.controller.machine.alarm
    assert machine.inverter.way == 0 and machine.inverter.asked_hz == 150

"""Every wait in ports/ has an end: if a chip's register never answers, the wait gives up and reports it."""

import ast
import itertools
import sys
import types

import pytest
from parsed import parse

from host_tools.build.tree import FIRMWARE
from passo.ports.rp2.fields import (
    PIO_A, PIO_ABORT, PIO_ADDRESSES, PIO_B, PIO_BITS, PIO_BLOCK, PIO_BUSY, PIO_C, PIO_CHANNELS, PIO_COUNTS, PIO_D,
    PIO_FIRST, PIO_MACHINE, PIO_MASK, PIO_PLAYING, PIO_STUCK, PIO_WORDS,
)  # fmt: skip

pytestmark = [pytest.mark.quick, pytest.mark.xdist_group("sources")]
PORTS = FIRMWARE / "passo" / "ports"
ABORT, BUSY = 0x50000444, 1 << 24
CHANNELS = 0b111


class Registers:
    """A chip whose registers keep what is written to them; those in `odd` answer by a function instead."""

    def __init__(self, odd=()):
        self.kept = {}
        self.odd = dict(odd)

    def pointer(self, address):
        return address if isinstance(address, list) else Pointer(self, address)


class Pointer:
    def __init__(self, registers, address):
        self._registers, self._address = registers, address

    def __getitem__(self, index):
        address = self._address + 4 * index
        odd = self._registers.odd
        return odd[address]() if address in odd else self._registers.kept.get(address, 0)

    def __setitem__(self, index, value):
        self._registers.kept[self._address + 4 * index] = value


@pytest.fixture
def player(monkeypatch):
    """player(odd): pio_player's names, whose viper functions see Registers(odd); a state that plays."""
    fakes = {name: types.ModuleType(name) for name in ("rp2", "uctypes", "passo.ports.rp2.chip", "passo.ports.rp2.programs")}
    for name, fake in fakes.items():
        monkeypatch.setitem(sys.modules, name, fake)

    def make(odd=()):
        names = {"__name__": "pio_player", "ptr32": Registers(odd).pointer}
        source = (PORTS / "rp2" / "pio_player.py").read_text(encoding="utf-8")
        exec(source, names)
        state = [0] * 32
        for field, value in {
            PIO_BLOCK: 0x50200000, PIO_MACHINE: 0x502000C8, PIO_A: 0x50000000, PIO_B: 0x50000040, PIO_C: 0x50000080,
            PIO_D: 0x50000000, PIO_COUNTS: 0x20001000, PIO_ADDRESSES: 0x20001100, PIO_WORDS: 0x20002000, PIO_ABORT: ABORT,
            PIO_MASK: 4095, PIO_CHANNELS: CHANNELS, PIO_BUSY: BUSY, PIO_BITS: 9, PIO_FIRST: 20, PIO_PLAYING: 1,
        }.items():  # fmt: skip
            state[field] = value
        return types.SimpleNamespace(**names), state

    return make


NEVER_STOPS = {ABORT: lambda: CHANNELS}
NEVER_THE_SAME = {0x50000000: itertools.count(0x20002000, 4).__next__}


def test_channels_that_stop_are_waited_for(player):
    looks = iter([CHANNELS, CHANNELS, 0b100] + [0] * 100)
    module, state = player({ABORT: looks.__next__})
    module._still(state)
    assert next(looks) == 0 and not state[PIO_STUCK]


@pytest.mark.parametrize("name", ["_still", "_quiet", "_halt", "_stop"])
def test_channels_that_never_stop_are_given_up(player, name):
    module, state = player(NEVER_STOPS)
    getattr(module, name)(state)
    assert state[PIO_STUCK]


@pytest.mark.parametrize("name, more", [("_count", ()), ("_words_played", ()), ("_halt", ()), ("_stop", ()), ("_busy", (5,)),
                                        ("_rest", (0,))])  # fmt: skip
def test_a_place_that_never_settles_is_given_up(player, name, more):
    module, state = player({**NEVER_THE_SAME, ABORT: lambda: 0})
    getattr(module, name)(state, *more)
    assert state[PIO_STUCK]


def test_a_player_that_is_stuck_plays_nothing_and_says_so(player):
    module, state = player(NEVER_STOPS)
    module._halt(state)
    registers = module._halt.__globals__["ptr32"].__self__
    before = dict(registers.kept)
    stuck = module.PioPlayer.__new__(module.PioPlayer)
    stuck._state, stuck._ring = state, types.SimpleNamespace(head=5)
    with pytest.raises(RuntimeError, match="does not answer"):
        stuck.start()
    assert registers.kept == before


def loops():
    for path in sorted(PORTS.rglob("*.py")):
        for node in ast.walk(parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.While):
                yield pytest.param(node, id=f"{path.relative_to(PORTS).as_posix()}:{node.lineno}")


@pytest.mark.parametrize("loop", list(loops()))
def test_who_only_waits_looks_at_the_clock(loop):
    """A loop that does nothing but ask again ends by the clock, or by a count."""
    if all(isinstance(statement, (ast.Pass, ast.Continue)) for statement in loop.body):
        assert "ticks_diff(" in ast.unparse(loop.test), "a wait without an end"

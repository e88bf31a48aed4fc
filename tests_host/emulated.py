"""What tests on the emulated Pico share. Import the fixtures by name:

    from emulated import pico, uf2  # noqa: F401

Where there is no MicroPython UF2, or no emulator, each of these tests skips and says why.
"""

import sys

import pytest

from host_tools.emulator.binary import Unavailable, find_uf2, load_emulator
from host_tools.emulator.machine import EmulatedMachine
from host_tools.emulator.pico import EmulatedPico


@pytest.fixture(scope="session")
def uf2():
    """The MicroPython binary. The test skips, loudly, where it cannot run."""
    try:
        load_emulator()
        return find_uf2()
    except Unavailable as reason:
        print(f"\nNOT TESTED ON THE EMULATED PICO: {reason}", file=sys.__stderr__)
        pytest.skip(f"NOT TESTED ON THE EMULATED PICO: {reason}")


@pytest.fixture
def pico(uf2):
    """A blank Pico, booted."""
    return EmulatedPico(uf2=uf2).boot()


@pytest.fixture
def make_machine(uf2):
    """`make_machine(board, **options)`: an EmulatedMachine, booted, and closed at the end of the test."""
    machines = []

    def make(*arguments, **options):
        machine = EmulatedMachine(*arguments, uf2=uf2, **options)
        machines.append(machine)
        return machine.boot()

    yield make
    for machine in machines:
        machine.close()

"""The fixtures of tests on the emulated Pico. Import the fixtures by name:

    from emulated import pico, uf2  # noqa: F401

A firmware that is up is made once a session. Tests that use it are marked `on_a_copy`: each gets it as it was. Those of
one machine belong to one `xdist_group`, so that it is made by one worker only.

Without a MicroPython UF2, or an emulator, each of these tests skips and says why.
"""

import sys
from functools import lru_cache

import pytest

from host_tools.emulator import sender
from host_tools.emulator.binary import Unavailable, find_uf2, load_emulator
from host_tools.emulator.halting import INPUTS
from host_tools.emulator.machine import EmulatedMachine
from host_tools.emulator.pico import EmulatedPico
from host_tools.emulator.rig import Rig, router_board

# In main.py before RUN, READY has the board print "ready" when its main loop begins.
READY = b"    def settle(self, app, real=Start.settle):\n        real(self, app)\n        print('ready')\n    Start.settle = settle\n"
RUN = b"    main(Start, STAMP)\n"


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


PWM_PIN = 20
SPINDLE = {"max_rpm": 1000, "pwm": True, "pin": PWM_PIN, "pwm_hz": 5000}


@lru_cache
def _rig(uf2, player, pwm=False):  # a fixture imported into two modules is two fixtures
    return Rig(router_board(3, player=player, inputs=INPUTS, **({"spindle": SPINDLE} if pwm else {})), uf2)


@pytest.fixture(scope="session")
def rig(uf2):
    """A Rig of three STEP/DIR axes with two halting inputs. Only for tests marked `on_a_copy`."""
    return _rig(uf2, "pio")


@pytest.fixture(scope="session")
def timer_rig(uf2):
    """The same, its pins driven by the timer player."""
    return _rig(uf2, "timer")


@pytest.fixture(scope="session")
def pwm_rig(uf2):
    """The same as `rig`, with a PWM output."""
    return _rig(uf2, "pio", True)


@lru_cache
def _usb_rig(uf2):
    return sender.usb_rig(uf2)


@pytest.fixture(scope="session")
def usb_rig(uf2):
    """The same on USB, without inputs. Only for tests marked `on_a_copy`."""
    return _usb_rig(uf2)

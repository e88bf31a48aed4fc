"""Whatever settings a board takes, it starts with them after the power has been off."""

import pytest

from host_tools import boards
from host_tools.sim.machine import VirtualMachine


def _values(rule, how):
    """Values of a setting to try, the boldest first."""
    _, _, default, least, most = rule
    if how == "least":
        return least, default
    return [most, *sorted({least + (most - least) // 2**halving for halving in range(1, 20)}, reverse=True)]


@pytest.mark.parametrize("how", ["least", "most"])
@pytest.mark.parametrize("name", boards.names())
def test_no_setting_keeps_a_board_from_starting(tmp_path, name, how):
    machine = VirtualMachine(name, trace=None, flash=tmp_path)
    state = machine.app.controller.machine
    machine.run_ms(20)
    kept = {}
    for number in state.settings.numbers:
        for value in _values(state.settings._table[number], how):
            if state.change_setting(number, value) == 0:
                kept[number] = value
                break
    assert len(kept) > 10
    machine.close()
    again = VirtualMachine(name, trace=None, flash=tmp_path)
    again.run_ms(20)
    settings = again.app.controller.machine.settings
    kept = {number: state.settings.value(number) for number in kept}  # one may change another
    assert {number: settings.value(number) for number in kept} == kept
    again.close()

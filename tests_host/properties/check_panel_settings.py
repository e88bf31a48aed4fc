"""The settings of boards of all languages on the page of a machine on a cable: read when a page asks, set and kept, and counted with."""

from boards.lpt_router import BOARD as LPT
from boards.plotter_2014 import BOARD as PLOTTER
from boards.torch_manipulator import BOARD as TORCH
from boards.two_motor_kit import BOARD as KIT
from language_desk import LanguageDesk
from passo import errors
from host_tools.page.keys_machine import KeysMachine
from host_tools.page.plotter_machine import PlotterMachine
from host_tools.page.pulses_machine import PulsesMachine
from host_tools.page.torch_machine import TorchMachine

_READ_MS = 20_000  # the longest that all of them may take, at 9600 baud


def kit(write, tell, board):
    machine = KeysMachine(write, tell, board)
    machine.note_port(True)
    return machine


MACHINES = ((TORCH, TorchMachine), (PLOTTER, PlotterMachine), (LPT, PulsesMachine), (KIT, kit))


def read(desk):
    """Ask for the settings, and return those that the page gets."""
    desk.told.clear()
    answer = desk.api.answer_order({"do": "settings"}, True)
    assert answer["t"] == "settings", answer
    return told(desk)


def told(desk):
    begun = desk.port.now
    while not [event for event in desk.told if event.get("t") == "settings"]:
        desk.run_ms(10)
        assert desk.port.now - begun < _READ_MS * 12_500, desk.machine.settings
    return [event for event in desk.told if event.get("t") == "settings"][-1]["settings"]


def check_they_are_those_of_the_board():
    for board, machine_of in MACHINES:
        desk = LanguageDesk(board, machine_of)
        assert "settings" in desk.machine.can
        settings = desk.app.controller.machine.settings
        found = read(desk)
        assert sorted(found) == sorted(settings.numbers), (board["name"], found)
        for number, value in found.items():
            assert float(value) * (1000 if settings.places(number) else 1) == settings.value(number), (board["name"], number, value)
        assert desk.machine.state["link"] and not [event for event in desk.told if event.get("t") == "log"], desk.told


def check_one_is_set_and_refused():
    for board, machine_of in MACHINES:
        desk = LanguageDesk(board, machine_of)
        read(desk)
        settings = desk.app.controller.machine.settings
        desk.told.clear()
        assert desk.order("set", number=100, value=49.218) == 0
        assert told(desk)[100] == "49.218" and settings.value(100) == 49218 and desk.machine.scale[0] == 49.218
        assert desk.order("set", number=100, value=900_000) == 0  # the board refuses it, and the page gets its error once
        desk.run_ms(3000)
        assert desk.machine.log() == [errors.SETTING_RANGE], (board["name"], desk.machine.log())
        assert settings.value(100) == 49218 and desk.machine.state["link"]
        assert desk.order("set", number=150 if 150 in settings.numbers else 11, value=0.5) == 0
        desk.run_ms(3000)
        assert desk.machine.log() == [errors.SETTING_RANGE]


def check_moves_count_in_the_steps_of_the_board():
    """Not in those of the board file of this computer."""
    desk = LanguageDesk(TORCH, TorchMachine)
    desk.order("output", name="motors_on")
    desk.settle()
    read(desk)
    assert desk.order("set", number=100, value=60) == 0
    desk.run_ms(3000)
    assert desk.order("step", by={"x": 1}, speed=600) == 0
    desk.settle()
    assert desk.place() == [60, 0] and desk.machine.state["m"] == [1.0, 0.0]


def check_a_stop_overtakes_the_questions():
    for board, machine_of in MACHINES:
        desk = LanguageDesk(board, machine_of)
        desk.api.answer_order({"do": "settings"}, True)
        desk.run_ms(60)
        assert desk.api.answer_order({"do": "stop"}, False)["error"] == 0
        desk.run_ms(300)
        assert desk.machine.state["state"] in ("Idle", "Alarm"), (board["name"], desk.machine.state)
        read(desk)


def check_they_are_read_again_behind_a_silence():
    desk = LanguageDesk(TORCH, TorchMachine)
    read(desk)
    desk.machine.note_silence()
    desk.told.clear()
    desk.run_ms(100)
    assert told(desk)

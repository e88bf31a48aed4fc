"""A black box on the emulated Pico: the lines before an alarm, a crash or a reset are in its flash afterwards, and the virtual board repeats the path of the
pins, to the step.
"""

import copy

import pytest
from emulated import uf2  # noqa: F401
from pico_on_a_port import on_a_port
from test_pico_firmware import TURN, with_fault

from host_tools import boards
from host_tools.cli.blackbox import files_of
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.machine import EmulatedMachine
from host_tools.programs.blackbox import Box, pack_files, unpack_files
from host_tools.sim.blackbox import Replay

START = 1500, 1200, -900
BOARD = {**copy.deepcopy(boards.load("router_3axis")), "blackbox": True}


@pytest.fixture(scope="module")
def router(uf2):
    machine = EmulatedMachine(BOARD, uf2=uf2, start=START).boot()
    machine.pico.console.expect(b"Grbl")
    machine.run_ms(300)
    machine.take()
    return machine


def stream(machine, lines, amid_ms):
    """Send lines as they are answered, 127 bytes under way, for `amid_ms`; or all of them, if that is sooner."""
    waiting, sizes, heard = list(lines), [], 0
    end = machine.now_ms() + amid_ms
    machine.take()
    while machine.now_ms() < end and (waiting or sizes):
        while waiting and sum(sizes) + len(waiting[0]) <= 127:
            sizes.append(len(waiting[0]))
            machine.send(waiting.pop(0))
        machine.run_ms(2)
        answered = machine.replies_so_far().count(b"ok")
        del sizes[: answered - heard]
        heard = answered


def job():
    yield b"$X\nG21G91F3000\n"
    for number in range(400):
        yield b"G1X%.3fY%.3fZ%.3f\n" % ((0.31, 0.12, -0.01) if number % 3 else (-0.4, 0.15, 0.02)) if number % 17 else b"G2X1I0.5\n"


def path_of(machine):
    """All positions since the power came, in steps of the machine's zero."""
    path = []
    for _, *place in machine.trace._rows:
        place = [at - start for at, start in zip(place, START)]
        if not path or path[-1] != place:
            path.append(place)
    return path


def boxed(machine):
    files = {name: bytes(data) for name, data in machine.pico.files().items() if name in ("blackbox.bin", "settings.0", "settings.1")}
    return Box.from_files({**files, "board.py": f"BOARD = {BOARD!r}\n".encode()})


def seen(machine):
    """(why, whether the pins' way ends as the virtual board's does, whether it is a beginning of that, numbers of errors, the replay)."""
    box = boxed(machine)
    replay = Replay(box, box.settings).run()
    path, played = path_of(machine), replay.path
    same = path[-len(played) :] == played
    begins = [at for at, place in enumerate(path) if place == played[0] and path[at:] == played[: len(path) - at]]
    return box.why, same, bool(begins), [row.value for row in box.rows if row.kind == 6], replay.faults, len(played)


def limit(machine):
    machine.send(b"$X\n$21=1\n")
    machine.run_ms(60)
    stream(machine, job(), 700)
    machine.plant.inject_noise("limit_x", [machine.pico.cycle // 10 + 5000, machine.pico.cycle // 10 + 12_500_000])
    machine.run_ms(1500)


def stop(machine):
    stream(machine, job(), 900)
    machine.plant.set_input(machine.pico.cycle // 10, "stop", True)
    machine.run_ms(1500)


def reset_amid_an_arc(machine):
    stream(machine, job(), 500)
    machine.send(b"G3X0Y0I5F1500\n")
    machine.run_ms(3000)
    machine.send(b"\x18")
    machine.run_ms(1500)


def door_and_reset(machine):
    stream(machine, job(), 600)
    machine.plant.set_input(machine.pico.cycle // 10, "door", True)
    machine.run_ms(500)
    machine.plant.set_input(machine.pico.cycle // 10, "door", False)
    machine.send(b"~")
    machine.run_ms(700)
    machine.send(b"\x18")
    machine.run_ms(1500)


def hold_and_reset(machine):
    stream(machine, job(), 700)
    machine.send(b"!")
    machine.run_ms(500)
    machine.send(b"~")
    machine.run_ms(300)
    machine.send(b"\x18")
    machine.run_ms(1500)


@pytest.mark.slow
@pytest.mark.parametrize("cause, numbers", [(limit, [201]), (stop, [201]), (reset_amid_an_arc, [203]), (door_and_reset, [203]), (hold_and_reset, [203])])
def test_the_virtual_board_goes_the_same_way(router, cause, numbers, show):
    def run():
        cause(router)
        return seen(router)

    why, same, _, told, faults, steps = on_a_copy(run)
    show(f"black box, {cause.__name__}", f"{steps - 1} steps")
    assert (why, faults, same) == ("alarm", [], True) and steps > 500
    assert set(numbers) <= set(told)


@pytest.mark.slow
def test_a_hang_ends_in_the_watchdog_and_leaves_the_box(uf2, show):
    """The main loop hangs amid a job: interrupts bring the machine to a stand, the watchdog resets the chip."""
    fault = "        if self.controller.machine.log.count and self.controller.machine.log.newest()[1] == 33:\n            while True:\n                pass\n"
    machine = EmulatedMachine(BOARD, with_fault("passo/app.py", TURN, fault, BOARD), uf2=uf2, start=START).boot()
    machine.pico.console.expect(b"Grbl")
    machine.run_ms(2300)  # the watchdog begins after the time of grace
    stream(machine, job(), 900)
    machine.send(b"G2X1Y5I0.2\n")  # no such arc
    machine.pico.await_reset(3_000_000)
    machine.run_ms(3500)
    why, _, begins, told, faults, steps = seen(machine)
    show("black box, watchdog", f"{steps - 1} steps are played")
    assert (why, begins, faults) == ("reset", True, []) and steps > 500


@pytest.mark.slow
def test_a_reset_button_amid_a_job_leaves_the_box(router, show):
    """Memory stays, and the next start writes it down; the place is not known, the way is."""

    def run():
        stream(router, job(), 1500)
        router.pico.chip.watchdog.write_uint32(0, 0)  # RUN stops a chip's watchdog, too; the emulator's goes on
        router.pico.hard_reset()
        router.run_ms(3500)
        return seen(router)

    why, _, begins, _, faults, steps = on_a_copy(run)
    show("black box, reset button", f"{steps - 1} steps are played")
    assert (why, begins, faults) == ("reset", True, []) and steps > 500


@pytest.mark.slow
def test_it_is_read_off_the_port(router, tmp_path):
    """As `passo blackbox --port` does: the firmware ends for it, and the box written at the alarm stays."""

    def run():
        stop(router)
        with on_a_port(router.pico, tmp_path / "port") as board:
            board.restart_interpreter()
            files = files_of(board)
        return {name: bytes(data) for name, data in files.items()}

    files = on_a_copy(run)
    assert set(files) >= {"blackbox.bin", "board.py"} and "blackbox.old" not in files
    box = Box.from_files(unpack_files(pack_files(files)))
    assert box.why == "alarm" and box.board["name"] == "router_3axis" and Replay(box, box.settings).run().faults == []

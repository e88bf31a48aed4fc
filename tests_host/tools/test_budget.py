"""The report of `passo build` on a board's pins and PIO state machines."""

import pytest
import typer
from typer.testing import CliRunner

from host_tools import boards
from host_tools.build.budget import PICO_PINS, budget_rows, check_module, memory_text
from host_tools.cli.build import build, print_budget
from host_tools.cli.flash import flash
from host_tools.failure import Failure
from passo.config.boardfile import check, pin_claims

pytestmark = pytest.mark.quick


def of(name, **changes):
    return dict(budget_rows(check({**boards.load(name), **changes})))


def test_the_mill_fills_a_pico():
    rows = of("mill_2004")
    assert rows["pins"] == "26 of 26 of a Pico; not brought out: 23; none free"
    assert rows["PIO"].startswith("5 of 8 state machines: player 1 in block 0; encoders 4 in block 1")
    assert rows["shift registers"] == "12 of 16 inputs, 5 of 8 outputs"
    assert rows["serial lines"] == "uart0: inverter"


def test_an_esp32_without_psram_holds_no_machine_as_files():
    assert of("plotter_esp32")["memory"] == "180 kB wanted, 175 there without PSRAM" and of("router_esp32")["memory"] == "in the module's PSRAM"
    assert of("mks_dlc32")["memory"] == "381 kB wanted, 175 there without PSRAM"
    assert "not counted" in memory_text({**check(boards.load("plotter_esp32")), "chip": "esp32s3"})
    for name, kb in (("router_3axis", 172), ("router_tmc2209", 178), ("router_ballscrew", 181), ("corexy_plotter", 175)):
        assert of(name)["memory"] == f"some {kb} kB of 246 on stock MicroPython", name
    assert of("router_3axis")["memory"] == "some 172 kB of 246 on stock MicroPython" and "memory" not in of("mill_pico_2")


def loaded(name, **more):
    return check({**boards.load(name), **more})


def with_network(name, port, protocol):
    board = check(boards.load(name))
    links = [dict(board["links"][0], protocol=protocol), {"name": "other", "port": port, "protocol": protocol, "frames": False}]
    return {**board, "psram": False, "network": {"host": "passo"}, "links": links}


# Boards are loaded by their test: it goes with its board.
@pytest.mark.parametrize("board, wanted, frozen", [
    (lambda: loaded("router_esp32", psram=False), 361, 123), (lambda: loaded("mks_dlc32"), 381, 127),
    (lambda: with_network("plotter_esp32", "page", "plotter"), 279, 121), (lambda: with_network("plotter_esp32", "http", "torch"), 268, 112),
    (lambda: with_network("router_esp32", "tcp", "grbl"), 437, 175), (lambda: with_network("router_esp32", "page", "grbl"), 462, 183),
    (lambda: loaded("plotter_esp32"), 180, 64),
])  # fmt: skip
def test_a_board_file_that_asks_for_more_than_its_module_has_is_refused(board, wanted, frozen):
    board = board()
    with pytest.raises(Failure, match=rf"mine: {wanted} kB of memory wanted, 175 there: it does not start.*psram.*takes {frozen} kB"):
        check_module(board, "mine")
    check_module({**board, "psram": True, "shift": None, "axes": [{**axis, "pins": []} for axis in board["axes"]]}, "mine")


def test_what_fits_is_not_refused():
    for name in boards.names():
        if name not in ("mks_dlc32", "plotter_esp32", *ONLY_FROZEN):  # their modules have no PSRAM
            check_module(check(boards.load(name)), name)
    with pytest.raises(Failure, match="plotter_esp32: pin 16 of a module with PSRAM is the PSRAM's"):
        check_module(check({**boards.load("plotter_esp32"), "psram": True}), "plotter_esp32")


STORED = {"jobs": {"language": "grbl"}}
ONLY_FROZEN = ("laser_pico_w", "plotter_page", "router_pico_w")


@pytest.mark.parametrize("board, counted, there", [
    (lambda: loaded("mill_2004", **STORED), None, 246), (lambda: loaded("router_3axis", **STORED), None, 246), (lambda: loaded("mill_2004"), None, 246),
    (lambda: loaded("router_pico_w"), 237, 205), (lambda: with_network("router_3axis", "tcp", "grbl"), 201, 205),
    (lambda: with_network("plotter_pico_w", "page", "plotter"), None, 205), (lambda: loaded("plotter_page"), 189, 205),
])  # fmt: skip
def test_what_leaves_too_little_of_a_pico_wants_the_uf2(board, counted, there):
    board = board()
    if counted is None:
        check_module(board, "mine")
        return
    with pytest.raises(Failure, match=rf"^mine wants Passo's UF2 .* some {counted} kB of memory, there are {there}, and 20 have to stay free$"):
        check_module(board, "mine")


@pytest.mark.parametrize("command", ["build", "flash"])
def test_the_commands_refuse_it(command, tmp_path):
    app = typer.Typer()
    app.command()({"build": build, "flash": flash}[command])
    options = ["--out", str(tmp_path)] if command == "build" else ["--dry-run"]
    result = CliRunner().invoke(app, ["--board", "mks_dlc32", *options])
    assert isinstance(result.exception, Failure) and "mks_dlc32: 381 kB of memory wanted" in str(result.exception)


def test_what_is_free_is_claimed_by_nobody():
    for name in boards.names():
        board = check(boards.load(name))
        rows = dict(budget_rows(board))
        used = {pin for pin, _ in pin_claims(board)}
        spi = board.get("spi_drivers")
        if spi:
            used |= {spi["sck"], *(motor["cs"] for motor in spi["motors"])}
        if not board["chip"].startswith("rp2"):
            assert "PIO" not in rows and rows["pins"].startswith(f"{len(used)} in use")
            continue
        count = int(rows["pins"].split()[0])
        assert count == len(used & set(PICO_PINS)) <= 26
        free = rows["pins"].partition("free: ")[2]
        assert {int(pin) for pin in free.split(", ") if pin} == set(PICO_PINS) - used


def test_it_is_printed_and_a_wrong_board_file_fails(tmp_path, capsys):
    print_budget("router_3axis")
    assert "1 of 8 state machines: player 1 in block 0; free: 3 in block 0, 4 in block 1" in capsys.readouterr().out
    file = tmp_path / "wrong.py"
    file.write_text("BOARD = {'name': 'wrong'}\n")
    with pytest.raises(Failure, match="missing"):
        print_budget(str(file))

"""What `passo build` says of a board's pins and PIO state machines."""

import pytest
import typer
from typer.testing import CliRunner

from host_tools import boards
from host_tools.build.budget import PICO_PINS, budget, memory
from host_tools.cli.build import build, print_budget
from host_tools.failure import Failure
from passo.config.boardfile import check, claimed_pins

pytestmark = pytest.mark.quick


def of(name, **changes):
    return dict(budget(check({**boards.load(name), **changes})))


def test_the_mill_fills_a_pico():
    rows = of("mill_2004")
    assert rows["pins"] == "26 of 26 of a Pico; not brought out: 23; none free"
    assert rows["PIO"].startswith("5 of 8 state machines: player 1 in block 0; encoders 4 in block 1")
    assert rows["shift registers"] == "12 of 16 inputs, 5 of 8 outputs"
    assert rows["serial lines"] == "uart0: inverter"


def test_an_esp32_without_psram_holds_a_plotter_and_no_more():
    assert of("plotter_esp32")["memory"] == "155 kB wanted, 209 there without PSRAM"
    for name in ("router_esp32", "mks_dlc32"):
        assert of(name)["memory"].startswith("317 kB wanted, 209 there without PSRAM: it does not fit; take a module with PSRAM")
    network = {"host": "passo"}
    page = {"name": "page", "port": "page", "protocol": "page"}
    for protocol, wanted in (("plotter", "276 kB"), ("grbl", "418 kB")):
        board = check(boards.load("plotter_esp32"))
        links = [dict(board["links"][0], protocol=protocol), page]
        assert memory({**board, "network": network, "links": links}).startswith(wanted)
    assert "not counted" in memory({**board, "chip": "esp32s3"}) and "memory" not in of("router_3axis")


def test_what_is_free_is_claimed_by_nobody():
    for name in boards.names():
        board = check(boards.load(name))
        rows = dict(budget(board))
        used = {pin for pin, _ in claimed_pins(board)}
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


@pytest.mark.unmeasured
def test_build_says_it(tmp_path):
    app = typer.Typer()
    app.command()(build)
    said = CliRunner().invoke(app, ["--board", "plotter_2014", "--out", str(tmp_path)])
    assert said.exit_code == 0 and "free: " in said.output.splitlines()[-3]

"""The machine chooser of a board on a cable: the port is handed to who copies the firmware, and taken again with the new machine."""

import asyncio
import shutil
import threading
import time

import pytest

from board_on_a_cable import CTRL_C, MICROPYTHON, BoardOnACable
from host_tools import boards
from host_tools.clients.serial_port import LinkError, open_exclusively
from host_tools.failure import Failure
from host_tools.panel.board import Port
from host_tools.panel.cable import Cable
from host_tools.panel.panel import Panel
from panel_process import PageClient, PanelProcess
from passo import errors
from test_panel_page import Browser, driver, pytestmark as of_pages  # noqa: F401

pytestmark = [
    pytest.mark.unmeasured,
    pytest.mark.xdist_group("panel"),
    pytest.mark.skipif(not MICROPYTHON.exists(), reason=f"there is no {MICROPYTHON}"),
]
COPY_S = 600
SPEAKING = ("grbl", "pulses", "torch", "plotter", "keys")
PULSES = {"name": "pc", "port": "usb", "protocol": "pulses"}


@pytest.fixture
def cable(tmp_path):
    """A router on a cable, and a folder with one board file of pulses on USB and one that is broken."""
    for name in ("fs", "own", "jobs"):
        (tmp_path / name).mkdir()
    shutil.copy(boards.path("router_3axis"), tmp_path / "fs" / "board.py")
    (tmp_path / "own" / "cutter.py").write_text(f"BOARD = {({**boards.load('lpt_router'), 'links': [PULSES]})!r}\n")
    (tmp_path / "own" / "broken.py").write_text("BOARD = {")
    with BoardOnACable(tmp_path / "fs") as board:
        yield board


def beside(panel, visit):
    """Run a panel, and visit(page) beside it, which ends it."""
    failed = []

    def go(number):
        try:
            visit(PageClient(f"127.0.0.1:{number}", panel.key).ready())
        except BaseException as error:
            failed.append(error)
        finally:
            loop.call_soon_threadsafe(panel.end)

    async def run():
        nonlocal loop
        loop = asyncio.get_running_loop()
        await panel.run("127.0.0.1", 0, lambda number: threading.Thread(target=go, args=(number,)).start())

    loop = None
    asyncio.run(run())
    if failed:
        raise failed[0]


def test_names_of_machines(cable):
    own = cable.folder.parent / "own"
    known = Cable(cable.port, cable.port, "router_3axis", own, SPEAKING, None)
    names = known.machine_names()
    assert names[0] == "router_3axis" and {"mill_2004", "plotter_2014", "cutter.py"} <= set(names)
    assert not {"router_esp32", "mill_pico_2", "broken.py"} & set(names), "another chip, or no board file"
    assert [what.split(":")[0] for what in known.wrong] == ["broken.py"]
    assert "router_esp32" in Cable(cable.port, cable.port, "", own, SPEAKING, None).machine_names()
    assert "cutter.py" not in Cable(cable.port, cable.port, "", own, ("grbl",), None).machine_names()
    with pytest.raises(Failure, match="speaks on uart0, not on USB: start the panel with that cable's --port, and --prompt"):
        known.change_machine("plotter_2014")
    two = Cable("/dev/ttyUSB0", cable.port, "plotter_2014", own, SPEAKING, lambda *became: done.append(became))
    done = []
    assert two.change_machine("lpt_router")[0] == "/dev/ttyUSB0" and two.change_machine("mill_2004")[0] == cable.port
    assert done == [("lpt_router", cable.port), ("mill_2004", cable.port)] and two.machine_names()[0] == "mill_2004"


def test_the_port_is_handed_over_and_taken_again(cable):
    fails = []

    def become(board, port):
        """Use the port as mpremote does."""
        with open_exclusively(port, 115_200, 1) as opened:
            if fails:
                raise Failure(fails.pop())
            opened.write(CTRL_C)
            opened.read(1)
            (cable.folder / "board.py").write_bytes(boards.board_py(board))
            (cable.folder / ".reset").touch()

    def visit(page):
        with pytest.raises(LinkError, match="in use"):
            open_exclusively(cable.port, 115_200, 0)
        for name in ("", "../fs/board.py", "broken.py", "router_esp32", "x" * 65):
            assert page.order("machine", name=name)["error"] == errors.ORDER_FIELD
        assert page.order("step", by={"x": 5}, speed=600)["error"] == 0
        page.order("machine", name="cutter.py")  # whether the move has been reported yet or not
        page.until(lambda state: state["state"] == "Jog")
        assert page.order("machine", name="cutter.py")["error"] == errors.BUSY
        page.until(lambda state: state["state"] == "Idle" and state["m"][0] == 5)
        assert page.state["link"] and cable.starts == 1
        fails.append("no MicroPython board answers")
        assert page.order("machine", name="cutter.py")["error"] == 0
        assert page.order("machine", name="cutter.py")["error"] == errors.BUSY
        assert page.said("refused")["text"] == "no MicroPython board answers"
        page.until(lambda state: state["link"] and state["state"] == "Idle" and state["m"][0] == 5)
        assert page.order("machine", name="cutter.py")["error"] == 0
        assert page.said("changing")["name"] == "cutter.py"
        now = page.said("machine")
        assert now["language"] == "pulses" and now["machines"][:2] == ["cutter.py", "router_3axis"]
        page.until(lambda state: state["link"] and state["state"] == "Idle")
        assert cable.starts == 2 and page.order("step", by={"y": 1}, speed=600)["error"] == 0
        page.until(lambda state: state["m"][1] == 1)

    own = cable.folder.parent / "own"
    choice = Cable(cable.port, cable.port, "router_3axis", own, SPEAKING, become)
    panel = Panel(
        lambda changed: Port(cable.port, 115_200, changed), own.parent / "jobs", None, "127.0.0.1", "grbl", boards.load("router_3axis"),
        choice.machine_names(), choice.change_machine,
    )  # fmt: skip
    beside(panel, visit)


@pytest.mark.slow
@of_pages[-1]
def test_the_page_chooses_with_the_real_mpremote(cable, driver, tmp_path):  # noqa: F811
    """Built, copied by mpremote, chosen and restarted; the settings of the old machine are put away."""
    (cable.folder / "settings.0").write_bytes(b"of the router")
    with PanelProcess(tmp_path, "--port", cable.port, "--board", "router_3axis", "--boards", str(tmp_path / "own")) as panel:
        browser = Browser(panel, driver)
        browser.choose("machines", "cutter.py")
        browser.click("machine")
        browser.answer(False)
        browser.click("machine")
        browser.answer()
        browser.until(lambda: "The board becomes cutter.py" in browser.text("message"))
        browser.shot("machine-changing")
        deadline = time.monotonic() + COPY_S
        while browser.find("machines").get_attribute("value") != "cutter.py" or browser.text("state") != "Ready":
            assert time.monotonic() < deadline, browser.text("message")
            time.sleep(0.2)
        browser.until(lambda: browser.find("card-program").is_displayed() and browser.find("card-settings").is_displayed())
        browser.shot("machine-changed")
        browser.choose("machines", "plotter_2014")
        browser.click("machine")
        browser.answer()
        browser.until(lambda: "--prompt" in browser.text("message") and browser.text("state") == "Ready")
    assert (cable.folder / "machines" / "before" / "settings.0").read_bytes() == b"of the router"
    assert "pulses" in (cable.folder / "board.py").read_text() and (cable.folder / "machines" / "chosen").read_text() == "cutter\nbefore"
    assert cable.starts == 2

"""The card that has the board prove itself: `passo prove` beside the panel, on an emulated Pico behind the page, and by a port that the panel lends. PASSO_SHOTS=FOLDER keeps pictures."""

import asyncio
import json
import shutil
import time

import pytest
from board_on_a_cable import MICROPYTHON, BoardOnACable
from test_panel_cable import beside
from test_panel_page import Browser, axe, driver, faults_found, pytestmark as of_pages, within_two_screens  # noqa: F401

from host_tools import boards
from host_tools.panel.board import Port
from host_tools.panel.panel import Panel
from host_tools.panel.prove_process import ProveProcess
from panel_process import PanelProcess
from passo import errors

pytestmark = [pytest.mark.unmeasured, pytest.mark.xdist_group("panel")]
BOARD = "router_3axis"
PROOF_S = 400
ROWS = "return document.getElementById('prove-rows').children.length"
TOLD = "return document.getElementById('prove-told').textContent"
CARD = "return document.getElementById('card-prove').innerText"


def panel_on(name, tmp_path, proved):
    return Panel(lambda changed: Port(str(name), 115_200, changed), tmp_path / "jobs", None, "127.0.0.1", "grbl", boards.load(BOARD), proved=proved)


def proof(page, **order):
    return page.order("prove", what="begin", language="en", **order)


def until_told(page, wanted, limit_s=60):
    """Wait until the page's report of the proof is as wanted, and return it."""
    deadline = time.monotonic() + limit_s
    while True:
        told = page.said("prove")
        if wanted(told):
            return told
        assert time.monotonic() < deadline, told


@pytest.mark.slow
@pytest.mark.parametrize("look", of_pages[2:], ids=["browser"])
def test_every_row_on_the_page(tmp_path, driver, axe, look):  # noqa: F811
    if look.args[0]:
        pytest.skip(look.kwargs["reason"])
    with PanelProcess(tmp_path) as panel, Browser(panel, driver, (1366, 768), "lang=pt&theme=light") as browser:
        run = browser.driver.execute_script
        browser.until(lambda: browser.driver.find_elements("id", "prove"))
        browser.tap("#card-panel > details > summary")
        browser.tap("#card-prove summary")
        assert not faults_found(browser, axe)
        run("document.getElementById('prove-pins').click()")
        browser.click("prove")
        browser.answer()
        browser.until(lambda: run(ROWS) > 3)
        assert "Passo" in run(TOLD) and run(TOLD).endswith("…") and not browser.find("prove").is_displayed()
        browser.shot("prove-runs")
        later = panel.page()  # a page that comes later asks
        assert len(later.order("prove", what="get")["rows"]) > 3
        later.socket.close()
        deadline = time.monotonic() + PROOF_S
        while not browser.find("prove").is_displayed():
            assert time.monotonic() < deadline, run(CARD)
            time.sleep(0.2)
        said = run(CARD)
        assert "0 pior" in said and run(ROWS) > 25 and "três eixos" in said, said
        assert not faults_found(browser, axe)
        browser.bring(browser.find("prove-told"))
        browser.shot("prove-done")
        run("navigator.clipboard.writeText = async (text) => { window.copied = text; }")
        browser.tap("#card-prove button:not([hidden]):not(.go):not(.danger)")
        browser.until(lambda: run("return window.copied || ''"))
        assert "três eixos" in run("return window.copied") and "copiado" in run(TOLD)
        browser.until(lambda: browser.text("state") in ("Alarme", "Pronta", "Pronto"))
        with Browser(panel, None, (360, 640), "lang=en&theme=dark") as phone:
            phone.until(lambda: phone.driver.find_elements("id", "prove") and phone.driver.execute_script(ROWS) > 25)
            phone.bring(phone.find("card-prove"))
            phone.tap("#card-prove summary")
            assert not faults_found(phone, axe)
            assert phone.driver.execute_script("return document.documentElement.scrollWidth") <= 500
            phone.bring(phone.find("prove-told"))
            phone.shot("prove-phone")
        assert not [row for row in browser.driver.get_log("browser") if "Error" in row["message"]]


@pytest.mark.skipif(not MICROPYTHON.exists(), reason=f"there is no {MICROPYTHON}")
def test_who_may_not_begin(tmp_path):
    """Moving, without the key, unknown fields: refused, and the port stays the panel's."""
    (tmp_path / "fs").mkdir()
    shutil.copy(boards.path(BOARD), tmp_path / "fs" / "board.py")

    def visit(page):
        assert page.hello["can"].count("prove") == 1
        page.socket.send('{"do":"prove","what":"begin","language":"en","id":7}')
        assert page._find(lambda message: message.get("id") == 7)["error"] == errors.NO_SESSION
        for wrong in ({"what": "begin", "language": "xx"}, {"what": 1}, {"what": "begin", "language": 3}):
            assert page.order("prove", **wrong)["error"] == errors.ORDER_FIELD
        assert page.order("prove", what="more")["error"] == errors.UNKNOWN_COMMAND
        assert page.order("step", by={"x": 5}, speed=600)["error"] == 0
        proof(page)  # whether the move has been reported yet or not
        page.until(lambda state: state["state"] == "Jog")
        assert proof(page)["error"] == errors.BUSY
        page.until(lambda state: state["state"] == "Idle" and state["m"][0] == 5)
        page.order("prove", what="get")
        assert page.state["link"] and not [told for told in page.told if told.get("rows")]

    with BoardOnACable(tmp_path / "fs") as board:
        beside(panel_on(board.port, tmp_path, lambda: ["--port", str(tmp_path / "none")]), visit)


@pytest.mark.skipif(not MICROPYTHON.exists(), reason=f"there is no {MICROPYTHON}")
def test_a_proof_that_fails_gives_the_port_back(tmp_path):
    (tmp_path / "fs").mkdir()
    shutil.copy(boards.path(BOARD), tmp_path / "fs" / "board.py")

    def visit(page):
        assert proof(page)["error"] == 0
        assert proof(page)["error"] == errors.BUSY
        told = until_told(page, lambda told: told["how"] == "failed")
        assert str(tmp_path / "none") in told["said"] and not told["rows"]
        page.until(lambda state: state["link"] and state["state"] == "Idle")

    with BoardOnACable(tmp_path / "fs") as board:
        beside(panel_on(board.port, tmp_path, lambda: ["--port", str(tmp_path / "none")]), visit)


@pytest.mark.skipif(not MICROPYTHON.exists(), reason=f"there is no {MICROPYTHON}")
def test_a_board_on_a_port(tmp_path):
    """The panel lends the port: `passo prove` opens it, has the machine end and MicroPython's prompt answer, and says what that lacks."""
    (tmp_path / "fs").mkdir()
    shutil.copy(boards.path(BOARD), tmp_path / "fs" / "board.py")

    def visit(page):
        assert proof(page)["error"] == 0
        told = until_told(page, lambda told: told["how"] == "failed", 120)
        assert f"{board.port} does not take code" in told["said"], told["said"]
        (board.folder / ".reset").touch()
        page.until(lambda state: state["link"] and state["state"])

    with BoardOnACable(tmp_path / "fs") as board:
        beside(panel_on(board.port, tmp_path, lambda: ["--port", board.port]), visit)


def test_lines_for_programs(tmp_path):
    """The panel reads the process's lines; a line that is no JSON is a sentence."""
    told = []
    proving = ProveProcess(lambda: ["--port", str(tmp_path / "none")], lambda: 0, told.append)
    assert proving.carry_out({"what": "get"}) == {"t": "prove", "how": ""}
    assert proving.carry_out({"what": "begin", "language": "pt", "pins": True}) == 0
    for line in ('{"header": "Passo on a board"}', '{"part": "link", "number": 3, "of": 8, "said": ""}',
                 json.dumps({"key": "ask_ms", "what": "asked", "found": "1 ms", "promised": "", "verdict": "better", "advice": "", "figures": {"ask_ms": 1}}),
                 "press reset"):  # fmt: skip
        proving._take_row(line)
    assert told[-1]["said"] == "press reset" and told[-1]["number"] == 3 and told[-1]["how"] == "runs"
    assert told[-1]["rows"] == [{"key": "ask_ms", "what": "asked", "found": "1 ms", "promised": "", "verdict": "better", "advice": ""}]
    proving.end()
    asyncio.run(proving.run())
    assert told[-1]["how"] == "ended"

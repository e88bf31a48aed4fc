"""STOP while a dialog is open, in Chromium and Firefox, on a phone and a desktop: the first Esc stops, and so do two clicks where STOP always is.

Esc and STOP on the other pages, too: the one at the machine, and the shop's.
"""

import asyncio
import threading
import time
from types import SimpleNamespace

import pytest
from marionette import FIREFOX, firefox
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from test_board_page import Served
from test_panel_page import CHROMIUM, DRIVER, Browser, chromium
from test_site import package  # noqa: F401
from test_site_page import address  # noqa: F401

from host_tools.shop import shop_server
from host_tools.shop.job_table import JobTable
from host_tools.shop.local_page import serve
from panel_process import PanelProcess
from passo import errors

pytestmark = [pytest.mark.slow, pytest.mark.unmeasured, pytest.mark.xdist_group("panel")]
KEY = "ABCDEFGHJKLMNPQR"
BROWSERS = {"chromium": bool(CHROMIUM and DRIVER), "firefox": bool(FIREFOX)}
SIZES = {"phone": (360, 640), "low": (640, 500), "desktop": (1366, 768)}
SPOT = "const {left, top, width, height} = document.getElementById('stop').getBoundingClientRect(); return [left + width / 2, top + height / 2, width, height]"
IN_REACH = """
const stop = document.getElementById("stop"), {left, top, width, height} = stop.getBoundingClientRect();
return [0.1, 0.5, 0.9].every((part) => stop.contains(document.elementFromPoint(left + part * width, top + part * height)));
"""
COVERED = """
const dialog = document.querySelector("dialog[open]"), stop = document.getElementById("stop").getBoundingClientRect();
return [...dialog.querySelectorAll("button:not(#stop)")].filter((each) => {
  each.scrollIntoView({block: "nearest"});
  const at = each.getBoundingClientRect();
  return at.width && !each.contains(document.elementFromPoint(at.left + at.width / 2, at.top + at.height / 2));
}).map((each) => each.id);
"""
TYPED = "document.getElementById('line').value = arguments[0]; document.getElementById('line-form').requestSubmit()"
OPEN = "return [...document.querySelectorAll('dialog[open]')].map((each) => each.id)"
# Each way into a dialog: the function that opens it, and the dialog.
WAYS = {
    "help": (lambda page: ActionChains(page.driver).send_keys("?").perform(), "help-keys"),
    "zero": (lambda page: page.driver.execute_script("document.getElementById('zero-all').click()"), "ask"),
    "remove": (lambda page: page.driver.execute_script("document.getElementById('remove').click()"), "ask"),
    "round": (lambda page: page.driver.execute_script("document.getElementById('round').click()"), "ask"),
}
JOB = "G21 G90\nG1 X5 Y5 F600\nX20\n"


@pytest.fixture(scope="module", params=BROWSERS)
def driver(request, tmp_path_factory):
    if not BROWSERS[request.param]:
        pytest.skip(f"NO {request.param.upper()}: apt-get install chromium chromium-driver firefox-esr, to test the page")
    opened = chromium() if request.param == "chromium" else firefox(tmp_path_factory.mktemp("firefox"))
    opened.named = request.param
    yield opened
    opened.quit()


def until(condition):
    limit = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < limit
        time.sleep(0.05)


def click_at(driver, x, y):
    """As a finger or a mouse would: whatever lies there."""
    actions = ActionChains(driver)
    actions.w3c_actions.pointer_action.move_to_location(round(x), round(y))
    actions.w3c_actions.pointer_action.click()
    actions.perform()


def moves(client):
    """Another page has the machine move for half a minute."""
    if client.state["state"] == "Alarm":
        client.unlock()
    there = client.state["m"][0] > 50
    assert client.order("step", by={"x": -40 if there else 40}, speed=80)["error"] == 0
    client.until(lambda state: state["state"] in ("Run", "Jog"))


@pytest.mark.parametrize("size", SIZES)
def test_stop_in_each_dialog(driver, tmp_path, size):
    with PanelProcess(tmp_path) as panel:
        client = panel.page().ready()
        client.put("job", JOB)
        page = Browser(panel, driver, SIZES[size])
        page.until(lambda: driver.execute_script("return document.getElementById('jobs').options.length") > 0)
        driver.execute_script("const jobs = document.getElementById('jobs'); jobs.value = 'job'; jobs.dispatchEvent(new Event('change'))")
        page.until(lambda: driver.execute_script("return document.getElementById('lines').children.length") > 0)
        spot = driver.execute_script(SPOT)
        for name, (press, dialog) in WAYS.items():
            for how in ("esc", "click"):
                if client.state["state"] == "Alarm":
                    client.unlock()
                page.until_state("Ready")
                press(page)
                page.until(lambda dialog=dialog: driver.execute_script(OPEN) == [dialog])
                assert driver.execute_script(IN_REACH), (name, how)
                assert driver.execute_script(COVERED) == [], (name, how)
                assert all(abs(one - other) < 1 for one, other in zip(driver.execute_script(SPOT), spot)), "STOP stays where it is"
                moves(client)
                stop_by(driver, how)
                client.until(lambda state: state["state"] == "Alarm")
                assert driver.execute_script(OPEN) == [], (name, how)
                page.until(lambda: driver.execute_script("return document.getElementById('stop').parentNode.tagName") == "HEADER")
                assert all(abs(one - other) < 1 for one, other in zip(driver.execute_script(SPOT), spot)), (name, how)
        names = [name for name, _size in client.order("jobs")["jobs"]]
        assert names == ["job"], "a question that STOP has ended is answered by no"


def stop_by(driver, how):
    """The first Esc, or two clicks where STOP is."""
    if how == "esc":
        ActionChains(driver).send_keys(Keys.ESCAPE).perform()
    else:
        spot = driver.execute_script(SPOT)[:2]
        click_at(driver, *spot)
        click_at(driver, *spot)


@pytest.mark.parametrize("size", ["phone", "desktop"])
def test_stop_in_each_dialog_of_a_board_s_page(driver, tmp_path, size):
    with Served(tmp_path) as served:
        client = served.page()
        assert client.order("give", to="page")["error"] == 0
        page = Browser(served, driver, SIZES[size])
        for name in ("help", "zero"):
            press, dialog = WAYS[name]
            for how in ("esc", "click"):
                if client.state.get("state") in (None, "Alarm"):
                    client.unlock()
                page.until_state("Ready")
                press(page)
                page.until(lambda dialog=dialog: driver.execute_script(OPEN) == [dialog])
                assert driver.execute_script(IN_REACH) and driver.execute_script(COVERED) == [], (name, how)
                moves(client)
                stop_by(driver, how)
                client.until(lambda state: state["state"] == "Alarm")
                assert driver.execute_script(OPEN) == [], (name, how)


def test_stop_in_each_dialog_of_the_site(driver, address):  # noqa: F811
    """The tab's own machine moves by a line that is typed before the dialog opens."""
    page = Browser(None, driver, SIZES["desktop"], "lang=en&board=router_3axis", address, key=False)
    for name in ("help", "zero"):
        press, dialog = WAYS[name]
        for how in ("esc", "click"):
            if page.text("state") != "Ready":
                page.until(page.find("unlock").is_enabled)
                page.click("unlock")
                page.until_state("Ready")
            press(page)
            page.until(lambda dialog=dialog: driver.execute_script(OPEN) == [dialog])
            assert driver.execute_script(IN_REACH) and driver.execute_script(COVERED) == [], (name, how)
            driver.execute_script(TYPED, "$J=G91X20F60")
            page.until(lambda: page.text("state") not in ("Ready", ""))
            stop_by(driver, how)
            page.until(lambda: page.find("unlock").is_enabled())
            assert driver.execute_script(OPEN) == [], (name, how)


def test_dialogs_are_answered_as_before(driver, tmp_path):
    """Yes, no, and one question behind the other; STOP is back in the head."""
    with PanelProcess(tmp_path) as panel:
        client = panel.page().ready()
        page = Browser(panel, driver, SIZES["desktop"])
        client.order("step", by={"x": 3}, speed=3000)
        client.until(lambda state: state["state"] == "Idle" and state["w"][0] != 0)
        page.until_state("Ready")
        before = client.state["w"][0]
        for answer, zero in (("ask-no", False), ("ask-no", False), ("ask-yes", True)):
            page.click("zero-all")
            page.until(lambda: driver.execute_script(OPEN) == ["ask"])
            page.find(answer).click()
            page.until(lambda: driver.execute_script(OPEN) == [])
            time.sleep(0.3)
            client.order("jobs")
            assert (client.state["w"][0] == 0) == zero and before, answer
        assert client.state["state"] == "Idle" and driver.execute_script("return document.getElementById('stop').parentNode.tagName") == "HEADER"


def esc_and_click(driver, field):
    """Esc with the focus in a field, then STOP by a click."""
    driver.find_element("id", field).click()
    ActionChains(driver).send_keys(Keys.ESCAPE).perform()
    driver.find_element("id", "stop").click()


def press(driver, selector):
    """Click what is there, in one step: each state draws the tiles anew."""
    until(lambda: driver.execute_script("const found = document.querySelector(arguments[0]); if (found) found.click(); return Boolean(found)", selector))


def test_the_page_at_the_machine(driver):
    """Without the key it stops, and says that the rest wants one; with it, from the address, paper is in."""
    done, stops = [], []
    machine = {"name": "m", "how": "rest", "state": "idle", "text": "", "alarm": ""}
    close, port = serve(0, KEY, lambda: [machine], lambda name, what: done.append((name, what)) or "", lambda name: stops.append(name) or "")
    try:
        driver.get("about:blank")
        driver.get(f"http://127.0.0.1:{port}/")
        until(lambda: driver.find_elements("css selector", ".tile button.go"))
        esc_and_click(driver, "key")
        until(lambda: stops == ["", ""])
        press(driver, ".tile button.go")
        until(lambda: driver.find_element("id", "said").text)
        assert done == [] and driver.find_element("id", "open").is_displayed()
        driver.get("about:blank")
        driver.get(f"http://127.0.0.1:{port}/#key={KEY}")
        until(lambda: driver.find_elements("css selector", ".tile button.go"))
        assert "key=" not in driver.current_url and not driver.find_element("id", "open").is_displayed()
        press(driver, ".tile button.go")
        until(lambda: done == [("m", "release")])
        machine["how"] = "run"
        until(lambda: driver.find_elements("css selector", ".tile button.danger"))
        press(driver, ".tile button.danger")
        until(lambda: stops == ["", "", "m"])
    finally:
        close()


def test_the_shop_s_page(driver, tmp_path):
    """Esc stops all machines, and the page says what the broker has not got."""
    error = 0
    stops = []
    dispatcher = SimpleNamespace(machines={}, is_up=True, stop_all=lambda: stops.append(1) or error, look=lambda: None, complain=print)
    book = JobTable(tmp_path / "shop.sqlite")
    shop = shop_server.Shop(dispatcher, book, KEY, "127.0.0.1")
    loop = asyncio.new_event_loop()
    serving = loop.create_task(shop.server.serve("127.0.0.1", 0))
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    try:
        port = asyncio.run_coroutine_threadsafe(shop.server.wait_for_port(serving), loop).result(30)
        driver.get(f"http://127.0.0.1:{port}/#key={KEY}")
        until(lambda: driver.find_element("id", "copies").is_displayed())
        esc_and_click(driver, "copies")
        until(lambda: "sent to all" in driver.find_element("id", "said").text or "enviado a todas" in driver.find_element("id", "said").text)
        assert len(stops) == 2
        error = errors.NOT_SENT
        driver.find_element("id", "stop").click()
        until(lambda: "not sent" in driver.find_element("id", "said").text or "não foi enviado" in driver.find_element("id", "said").text)
    finally:
        driver.get("about:blank")
        loop.call_soon_threadsafe(serving.cancel)
        loop.call_soon_threadsafe(loop.stop)
        thread.join(10)
        book.close()

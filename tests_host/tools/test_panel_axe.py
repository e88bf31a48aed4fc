"""axe-core finds no fault in the parts that open on the page: folded cards, the parts of the set-up, dialogs, bars, and the messages after a failure."""

import pytest
from test_panel_page import Browser, axe, driver, faults_found, pytestmark as of_pages  # noqa: F401
from test_panel_states import BOX, PHONE, at_rest

from host_tools import boards
from panel_process import PanelProcess

pytestmark = [*of_pages, pytest.mark.slow]
WIDE = (1366, 768)
LOOKS = {"phone": (PHONE, "pt", "dark"), "phone-light": (PHONE, "en", "light"), "wide": (WIDE, "en", "light"), "wide-dark": (WIDE, "pt", "dark")}
PARTS = ("offsets", "plate", "corner", "hole", "boss", "tool", "surface", "map", "inout", "health", "pad")
SQUARE = "G21 G90 G54\nT1 M6\nF600\nG1 X20\nY20\nX0\nY0\nM30\n"
LONG = "G21 G90 G54\nF60\nG1 X20\nM30\n"
REFUSED = "G21 G90\nG1 X1 F1000\nG1 Q5\nM2\n"
OPEN = "for (const each of document.querySelectorAll('details')) each.open = true"
TAB = "const tab = document.querySelector(`[data-tab=${arguments[0]}]`); if (tab.offsetParent) tab.click()"
VALUE = "return document.getElementById('jobs').value"
BUTTON = "localStorage.setItem('buttons', JSON.stringify([{name: 'Park', lines: ['G53 G0 Z0', 'G53 G0 X0 Y0']}]))"


@pytest.fixture(params=LOOKS)
def look(request, driver):  # noqa: F811
    """look(panel): the page as that look has it."""
    size, language, theme = LOOKS[request.param]

    def opened(panel):
        screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size == PHONE}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        return Browser(panel, driver, size, f"lang={language}&theme={theme}")

    yield opened
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def put(browser, folder, name, text):
    (folder / name).write_text(text)
    browser.find("upload").send_keys(str(folder / name))
    browser.until(lambda: browser.driver.execute_script(VALUE) == name)


def looked_at(browser, text):
    """axe-core's findings, and that it was shown."""

    def found(name, *shown):
        for each in shown:
            left, top, right, bottom = browser.driver.execute_script(BOX, each)
            assert right > left and bottom > top, (name, each)
        browser.shot(f"axe-{name}")
        assert not faults_found(browser, text), name

    return found


def test_what_opens(tmp_path, look, axe):  # noqa: F811
    with PanelProcess(tmp_path, "--board", "router_3axis") as panel, look(panel) as browser:
        found = looked_at(browser, axe)
        run = browser.driver.execute_script
        run(BUTTON)
        browser.driver.refresh()
        browser.until(lambda: run("return document.getElementById('state').dataset.state") == "Alarm")
        found("alarm", "home", "unlock")
        run(TAB, "move")
        at_rest(browser)
        run(OPEN)
        for name, text in (("square.nc", SQUARE), ("refused.nc", REFUSED)):
            put(browser, tmp_path, name, text)
            run("document.getElementById('queue-add').click()")
        browser.until(lambda: run("return document.getElementById('queue').children.length") == 2 and run("return document.getElementById('job-wrong').textContent"))
        run(TAB, "job")
        found("job", "job-wrong", "queue", "pictures", "round")
        run(TAB, "path")
        found("path", "path", "goto-form")
        run(TAB, "machine")
        found("machine", "own-buttons", "own-form", "settings", "language")
        run(TAB, "setup")
        browser.until(lambda: browser.driver.find_elements("id", "setup-corner"))
        for part in PARTS:
            run("(document.getElementById('setup-back') || document.body).click(); document.getElementById(arguments[0]).click()", f"setup-{part}")
            found(f"setup-{part}", "setup-back")
        run("document.getElementById('help-keys').showModal()")
        found("help", "help-keys")
        run("document.getElementById('help-keys').close(); document.getElementById('zero-all').click()")
        found("asks", "ask-yes")
        run("document.getElementById('ask-no').click()")
        run(TAB, "job")
        browser.choose("jobs", "square.nc")
        browser.until(lambda: browser.find("run").is_enabled())
        run("document.getElementById('run').click()")
        browser.until(lambda: browser.find("wait-go").is_displayed())
        found("tool", "wait-go", "progress", "lines")


def test_what_stands_there_after_a_failure(tmp_path, look, axe):  # noqa: F811
    """A job that was ended amid a line, on a board with a journal; then the panel is gone."""
    board = {**boards.load("router_3axis"), "journal": {"every_ms": 500}}
    (tmp_path / "board.py").write_text(f'"""A router with a journal."""\n\nBOARD = {board!r}\n')
    panel = PanelProcess(tmp_path, "--board", str(tmp_path / "board.py"))
    try:
        with look(panel) as browser:
            found = looked_at(browser, axe)
            run = browser.driver.execute_script
            browser.until(lambda: browser.text("state"))
            at_rest(browser)
            run(TAB, "job")
            put(browser, tmp_path, "long.nc", LONG)
            browser.until(lambda: browser.find("run").is_enabled())
            run("document.getElementById('run').click()")
            browser.until(lambda: float(browser.driver.execute_script("return document.getElementById('w-x').textContent")) > 1.5)
            found("runs", "pause", "job-time")
            run("document.getElementById('abort').click()")
            browser.until(lambda: browser.find("recover-row").is_displayed())
            found("interrupted", "recover-text", "recover-begin")
            panel.close()
            browser.until(lambda: browser.text("message") and run("return document.getElementById('state').dataset.state") == "")
            found("lost", "message")
    finally:
        if panel._process.poll() is None:
            panel.close()

"""The page refuses files that are no jobs, says why a button is grey, and on a phone begins with Home and Unlock in an alarm."""

import time

import pytest
from selenium import webdriver
from test_panel_page import MM, Browser, driver, pytestmark as of_pages  # noqa: F401

from panel_process import PanelProcess

pytestmark = of_pages
PHONE, WIDE = (360, 640), (1920, 1080)
PNG = b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 20
NO_JOB = {"en": "Error 181: the file is empty or no text", "pt": "Erro 181: o arquivo está vazio ou não é texto"}
PAUSED = "G21 G90 G54\nT1 M6\nG0 X1\nM2\n"
GREY = """
return [...document.querySelectorAll("button:disabled")].filter((e) => e.offsetParent && !e.title && !e.closest("#elsewhere, #setup, #queue")).map((e) => e.id || e.textContent)
"""
PAD = "return [...new Set([...document.querySelectorAll('#pad button')].map((key) => key.getAttribute('aria-disabled')))]"
TEXT = "return document.getElementById(arguments[0]).textContent"
BOX = "const b = document.getElementById(arguments[0]).getBoundingClientRect(); return [b.left, b.top, b.right, b.bottom]"


@pytest.fixture(scope="module")
def router(tmp_path_factory):
    with PanelProcess(tmp_path_factory.mktemp("router"), "--board", "router_3axis") as process:
        yield process


@pytest.fixture(autouse=True)
def left_pages(router):
    yield
    router.leave_pages()


@pytest.fixture
def page(router, driver):
    """page(language, size): the router's page, on a screen of that size."""

    def opened(language="en", size=WIDE):
        screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size == PHONE}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        return Browser(router, driver, size, f"lang={language}&theme=light")

    yield opened
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def at_rest(browser):
    """Out of the alarm."""
    state = "return document.getElementById('state').dataset.state"
    if browser.driver.execute_script(state) == "Alarm":
        browser.click("unlock")
    browser.until(lambda: browser.driver.execute_script(state) == "Idle")


def box(browser, name):
    return browser.driver.execute_script(BOX, name)


def test_a_phone_in_an_alarm_begins_with_what_ends_it(page, router):
    """Home and Unlock are in sight above the message, Home as what goes on; once it is unlocked, the keys that move come back to that spot, and a
    second tap there moves nothing."""
    with page("pt", PHONE) as browser:
        client = router.page()
        client.order("stop")
        browser.until(lambda: browser.find("state").get_attribute("data-state") == "Alarm" and browser.text("message"))
        browser.driver.execute_script("document.querySelector('[data-tab=move]').click(); scrollTo(0, 0)")
        for name in ("home", "unlock"):
            assert box(browser, name)[3] < box(browser, "message")[1], name
        assert browser.find("home").get_attribute("class") == "go" and browser.driver.execute_script(PAD) == ["true"]
        browser.find("unlock").click()
        settles = "return getComputedStyle(document.getElementById('card-jog')).pointerEvents"
        browser.until(lambda: browser.driver.execute_script(settles) == "none")
        browser.until(lambda: browser.driver.execute_script(settles) == "auto")
        assert box(browser, "card-jog")[1] < box(browser, "card-place")[1] and browser.find("home").get_attribute("class") == ""
        assert browser.driver.execute_script(PAD) == ["false"]


ALARMED = {"en": "Error 9: the machine is in alarm: home it first, or unlock it", "pt": "Erro 9: a máquina está em alarme: busque a origem primeiro, ou destrave"}


@pytest.mark.parametrize("language", ALARMED)
@pytest.mark.parametrize("way", ["an arrow key", "a key of the page"])
def test_a_key_that_moves_says_in_an_alarm_what_to_do(tmp_path, driver, language, way):
    """A router wants to be homed as it starts."""
    with PanelProcess(tmp_path, "--board", "router_3axis") as process, Browser(process, driver, WIDE, f"lang={language}&theme=light") as browser:
        browser.until(lambda: browser.find("state").get_attribute("data-state") == "Alarm")
        browser.driver.execute_script("document.getElementById('message').click()")
        before = browser.place()
        if way == "an arrow key":
            browser.driver.execute_script("document.activeElement.blur()")
            webdriver.ActionChains(browser.driver).send_keys(webdriver.Keys.ARROW_RIGHT).perform()
        else:
            browser.tap("[data-way='x+']")
        browser.until(lambda: browser.text("message").startswith(ALARMED[language]))
        assert browser.place() == before and browser.find("state").get_attribute("data-state") == "Alarm"


@pytest.mark.parametrize("language", NO_JOB)
def test_a_file_that_is_no_job_is_refused(page, router, tmp_path, language):
    with page(language) as browser:
        for name, data in (("photo.png", PNG), ("photo.nc", PNG), ("empty.nc", b""), ("blank.svg", b" \n\n")):
            (tmp_path / name).write_bytes(data)
            browser.driver.execute_script("document.getElementById('message').click()")
            browser.find("upload").send_keys(str(tmp_path / name))
            browser.until(lambda: browser.text("message").startswith(NO_JOB[language]))
        assert not [path.name for path in router.jobs.iterdir() if path.name.startswith(("photo", "empty", "blank"))]


def test_what_is_grey_says_why(page, router, tmp_path):
    with page() as browser:
        at_rest(browser)
        browser.choose("jobs", "")
        browser.until(lambda: browser.text("run-why") == "Choose a file first.")
        assert not browser.find("remove").is_enabled() and browser.find("remove").get_attribute("title") == "Choose a file first."
        assert not browser.driver.execute_script(GREY)
        (tmp_path / "pause.nc").write_text("G21\nM0\nM2\n")
        browser.find("upload").send_keys(str(tmp_path / "pause.nc"))
        browser.until(lambda: browser.find("run").is_enabled())
        assert not browser.text("run-why") and not browser.find("run").get_attribute("data-why") and browser.find("remove").is_enabled()
        browser.click("run")
        browser.until(lambda: browser.find("wait-go").is_displayed())
        assert browser.find("check").get_attribute("title") == "A job is under way." and not browser.driver.execute_script(GREY)
        browser.click("wait-go")
        browser.until(lambda: "Done" in browser.text("job-state"))
        router.page().order("give", to="guest")
        browser.until(lambda: browser.text("run-why") == "Another program moves the machine.")
        assert not browser.driver.execute_script(GREY)
        browser.click("take")
        browser.until(lambda: browser.find("run").is_enabled())


def test_accents_leave_a_name_readable(page, tmp_path):
    with page() as browser:
        (tmp_path / "peça de mão.nc").write_text("G21 G90\nG0 X1\n")
        browser.find("upload").send_keys(str(tmp_path / "peça de mão.nc"))
        browser.until(lambda: browser.driver.execute_script("return document.getElementById('jobs').value") == "peca de mao.nc")


def test_a_tool_change_is_short_on_a_phone_and_leaves_nothing(page, tmp_path):
    with page("pt", PHONE) as browser:
        at_rest(browser)
        (tmp_path / "tool.nc").write_text(PAUSED)
        browser.find("upload").send_keys(str(tmp_path / "tool.nc"))
        browser.until(lambda: browser.find("run").is_enabled() and browser.driver.execute_script("return document.getElementById('jobs').value") == "tool.nc")
        browser.click("run")
        browser.until(lambda: browser.find("wait-go").is_displayed())
        left, top, right, bottom = box(browser, "wait-text")
        assert bottom - top < 60, "at most two lines"
        assert box(browser, "wait-go")[2] - box(browser, "wait-go")[0] > 300
        browser.click("abort")
        browser.until(lambda: not browser.find("wait-bar").is_displayed())
        assert browser.driver.execute_script(TEXT, "wait-text") == browser.driver.execute_script(TEXT, "wait-go") == ""


def test_a_line_that_is_refused_is_told_before_it_runs(page, tmp_path):
    """By the firmware's own parser, on the PC; Check finds the same."""
    for language, said in (("en", "The job would stop at line 3. Error 36"), ("pt", "O trabalho pararia na linha 3. Erro 36")):
        with page(language) as browser:
            at_rest(browser)
            (tmp_path / f"word-{language}.nc").write_text("G21 G90\nG1 X1 F1000\nG1 Q5\nM2\n")
            browser.find("upload").send_keys(str(tmp_path / f"word-{language}.nc"))
            browser.until(lambda: browser.text("job-wrong").startswith(said))
    with page() as browser:
        browser.click("check")
        browser.until(lambda: "line 3" in browser.text("job-state") and "Error 36" in browser.text("job-state"))
        at_rest(browser)
        (tmp_path / "good.nc").write_text("G21 G90\nG1 X1 F1000\nG43.1 Z2\nT2 M6\n$H\nM2\n")
        browser.find("upload").send_keys(str(tmp_path / "good.nc"))
        browser.until(lambda: "good.nc" in browser.text("run") and "tools T2" in browser.text("job-facts"))
        assert "would stop" not in browser.text("job-wrong")
        (tmp_path / "cad.nc").write_text("(Exported by FreeCAD)\n(Post Processor: centroid_post)\nG21 G90\nG1 X1 F1000\nM25\n")
        browser.find("upload").send_keys(str(tmp_path / "cad.nc"))
        browser.until(lambda: "FreeCAD" in browser.text("job-wrong"))
        assert "would stop at line 5" in browser.text("job-wrong") and "choose grbl, linuxcnc or mach3_mach4" in browser.text("job-wrong")


def test_overrides_stand_beside_their_names(page):
    with page() as browser:
        gap = browser.driver.execute_script(
            "const row = document.querySelector('.override'), range = document.createRange(); range.selectNodeContents(row.firstChild);"
            "return row.children[1].getBoundingClientRect().left - range.getBoundingClientRect().right")
        assert 0 < gap < 100


def test_signals_that_are_off_say_so(page):
    for language, said in (("en", ["Door: off", "Spindle: off", "Mist: off"]), ("pt", ["Porta: desligada", "Spindle: desligado", "Névoa: desligada"])):
        with page(language) as browser:
            at_rest(browser)
            browser.until(lambda: said[0] in browser.driver.execute_script(TEXT, "signals"))
            told = browser.driver.execute_script(TEXT, "signals")
            assert all(each in told for each in said) and "–" not in told


def test_portuguese_agrees_and_a_bound_has_its_unit(tmp_path, driver):
    with PanelProcess(tmp_path, "--board", "lpt_router") as process, Browser(process, driver, WIDE, "lang=pt&theme=light") as browser:
        for name, words in (("tool", ("desligada", "ligada")), ("drives", ("desligados", "ligados"))):
            for way, said in (("off", words[0]), ("on", words[1])):
                button = browser.css(f"[data-switch={name}_{way}]")
                browser.until(button.is_enabled)
                browser.bring(button).click()
                browser.until(lambda: browser.css(f"[data-shows={name}]").text == said)
        most = browser.driver.execute_script(TEXT, "pace-most")
        assert most.startswith("1 … ") and most.endswith(" mm/min")
        assert not browser.driver.execute_script(GREY)


CORNERS = (4, 0), (4, 3), (0, 3), (0, 0)
# The page shows a corner for a moment only, and a test on a slow PC may look too late. So this script records every position that the page shows.
WATCH = """
window.shown = [];
const shown = (axis) => parseFloat(document.getElementById("w-" + axis).textContent);
setInterval(() => window.shown.push([shown("x"), shown("y")]), 10);
"""


def in_order(shown, wanted):
    """Whether the positions `wanted` are among those `shown`, one after the other, within half a step."""
    rest = iter(shown)
    return all(any(max(abs(x - at_x), abs(y - at_y)) <= 0.5 / MM + 0.001 for x, y in rest) for at_x, at_y in wanted)


def test_the_tool_goes_around_a_job(page, router, tmp_path):
    """To the corners of its box, and no further; a pause and STOP end it. The page refuses to go around a job that leads out of the travel or moves nothing."""
    client = router.page()
    with page() as browser:
        at_rest(browser)
        browser.click("zero-all")
        browser.answer()
        (tmp_path / "part.nc").write_text("G21 G90\nG0 X0 Y0\nG1 X4 Y3 F1000\nG1 X2 Y0\nM2\n")
        browser.find("upload").send_keys(str(tmp_path / "part.nc"))
        browser.until(lambda: "part.nc" in browser.text("run") and browser.find("round").is_enabled())
        browser.fill("jog-speed", "3000")
        browser.click("round")
        browser.until(lambda: "4.0 × 3.0 mm" in browser.text("ask-text"))
        browser.driver.execute_script(WATCH)
        browser.answer()
        browser.until(lambda: in_order(browser.driver.execute_script("return window.shown"), CORNERS))
        browser.until_state("Ready")
        start = browser.place()
        browser.fill("jog-speed", "60")
        for end, state in (("hold", "Idle"), ("stop", "Alarm")):
            browser.click("round")
            browser.answer()
            browser.until(lambda: browser.place() != start)
            browser.click(end)
            browser.until(lambda state=state: browser.find("state").get_attribute("data-state") == state)
            stood = browser.place()
            time.sleep(1)
            assert browser.place() == stood and 0 < stood[0] - start[0] < 4 and stood[1:] == start[1:]
            if end == "hold":
                browser.fill("goto-x", "0")
                browser.css("#goto-form button").click()
                browser.until(lambda: browser.works_at(0, 0))
                browser.until_state("Ready")
        at_rest(browser)
        for name, text, said in (("far.nc", "G21 G90\nG1 X4000 F1000\nM2\n", "out of the travel"), ("still.nc", "(nothing)\nM2\n", "moves nothing")):
            (tmp_path / name).write_text(text)
            browser.find("upload").send_keys(str(tmp_path / name))
            browser.until(lambda said=said: said in browser.find("round").get_attribute("title") and not browser.find("round").is_enabled())


def test_a_stop_of_another_page_ends_what_goes_step_by_step(page, router, tmp_path):
    """It comes while the machine stands between two moves: of a button of one's own, and around a job."""
    other = router.page()
    other.order("jobs")  # a page that has proven the key keeps its place
    with page() as browser:
        at_rest(browser)
        browser.click("zero-all")
        browser.answer()
        (tmp_path / "small.nc").write_text("G21 G90\nG0 X0 Y0\nG1 X4 Y3 F1000\nM2\n")
        browser.find("upload").send_keys(str(tmp_path / "small.nc"))
        browser.until(lambda: browser.find("round").is_enabled())
        browser.driver.execute_script("document.querySelector('#card-own details').open = true")
        browser.fill("own-name", "Twice")
        browser.fill("own-lines", "G1 X4 F3000\nG1 Y3")
        browser.tap("#own-form button")
        browser.fill("jog-speed", "3000")
        browser.driver.execute_script("const real = setTimeout; window.setTimeout = (call, ms) => real(call, 10 * ms)")  # it stands for longer
        for begin in (lambda: browser.tap("#own-buttons button"), lambda: (browser.click("round"), browser.answer())):
            begin()
            other.until(lambda state: state["state"] in ("Run", "Jog"))
            other.until(lambda state: state["state"] == "Idle" and state["w"][0] > 3.9)
            other.order("stop")
            time.sleep(4)
            assert browser.works_at(4, 0), browser.place()
            at_rest(browser)
            other.order("goto", to={"x": 0, "y": 0}, speed=3000)
            browser.until(lambda: browser.works_at(0, 0))
            browser.until_state("Ready")

"""The page in a real browser: Debian's chromium, the virtual board behind `passo panel`, a pseudo-terminal between them.

Without chromium or chromedriver these tests skip; `.ci/run` installs them if it can. PASSO_SHOTS=FOLDER keeps pictures.
"""

import json
import os
import re
import shutil
import socket
import threading
import time
from pathlib import Path

import pytest

from host_tools import boards
from host_tools.failure import Failure
from host_tools.site.npm import Package
from panel_process import PanelProcess
from passo.web.session import Hmac

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
MM = 320  # steps
LIMIT_S = 60
AXE = Package("axe-core", "axe-core", "4.14.1", "FHfa+lmNjQZfJz1q8wKqIDwC6DExcHt/pkjNQb09a3NPjCKg2rhu5qb2S4r76ASyFNNtuFooJpZe37OgudVGtQ==")
pytestmark = [
    pytest.mark.unmeasured,
    pytest.mark.xdist_group("panel"),
    pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="NO BROWSER: apt-get install chromium chromium-driver, to test the page"),
]
SQUARE = "G21 G91\nF900\nG1 X20\nG1 Y20\nG1 X-20\nG2 Y-20 J-10\n"


# Brings a control into sight: its card is folded up, or on a phone it is behind another tab.
BRING = """
const control = arguments[0], card = control.closest("section > details:not([open])"), pane = control.closest(".pane[hidden]");
if (card && !control.closest("summary")) card.querySelector("summary").click();
if (pane) document.querySelector(`[data-tab=${pane.dataset.of || pane.id.slice(5)}]`).click();
control.scrollIntoView({block: "center"});
"""
# Calls back once the control stands at the same spot in two pictures, one after the other: a click would miss a moving control.
STANDS = """
const [control, told] = arguments;
let before = NaN;
const look = () => {
    const now = control.getBoundingClientRect().y;
    if (now === before) return told();
    before = now;
    requestAnimationFrame(() => requestAnimationFrame(look));
};
look();
"""


def chromium():
    """A Chromium of its own, without a window."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    driver.set_script_timeout(LIMIT_S)
    return driver


class Browser:
    """Chromium on the page of a panel."""

    def __init__(self, panel, driver=None, size=(1280, 1000), query="lang=en&theme=light", address=None, key=True):
        """`driver`: a Chromium that stays when this one ends; else one of its own."""
        self._own = driver is None
        self.driver = driver or chromium()
        self.driver.set_window_size(*size)
        self.driver.get("about:blank")
        self.driver.get((address or panel.address) + "?" + query + (f"#key={panel.key}" if key else ""))
        self.until(lambda: self.text("state") not in ("", "No link", "Sem ligação"))
        if key:
            self.until(lambda: not self.find("card-key").is_displayed())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._own:
            self.driver.quit()

    def find(self, name):
        return self.driver.find_element("id", name)

    def text(self, name):
        return self.find(name).text.strip()

    def click(self, name):
        self.until(lambda: self.find(name).is_enabled())
        self.bring(self.find(name)).click()

    def tap(self, selector):
        """Click, clear of the header that stays in sight."""
        self.bring(self.css(selector)).click()

    def bring(self, control):
        """Into sight, and at a stand there."""
        self.driver.execute_script(BRING, control)
        self.driver.execute_async_script(STANDS, control)
        return control

    def css(self, selector):
        return self.driver.find_element("css selector", selector)

    def until(self, wanted):
        deadline = time.monotonic() + LIMIT_S
        while not wanted():
            assert time.monotonic() < deadline, self.shown()
            time.sleep(0.05)

    def shown(self):
        """Return the page's state for the message of a test that has waited too long."""
        card = "return [...document.querySelectorAll('#places td, #goto-form input, #job-state, #job-time, #log, #said')].map((each) => each.value ?? each.textContent)"
        log = [] if self.driver.name == "firefox" else self.driver.get_log("browser")
        return self.text("state"), self.text("message"), self.driver.execute_script(card), log

    def until_state(self, name):
        self.until(lambda: self.text("state") == name)

    def place(self):
        return [float(self.text(f"m-{axis}")) for axis in "xyz"]

    def works_at(self, *position):
        """Within half a step: a zero is where the last move was to end, and the machine stands at the step next to it."""
        return all(abs(float(self.text(f"w-{axis}")) - wanted) <= 0.5 / MM + 0.001 for axis, wanted in zip("xyz", position))

    def fill(self, name, value):
        self.driver.execute_script("arguments[0].value = arguments[1]", self.find(name), value)

    def choose(self, name, value):
        """Another option of a list."""
        from selenium.webdriver.support.ui import Select

        Select(self.bring(self.find(name))).select_by_value(value)

    def press(self, way):
        """A finger down on a button of the pad."""
        from selenium.webdriver import ActionChains

        button = self.bring(self.css(f"[data-way='{way}']"))
        ActionChains(self.driver).move_to_element(button).click_and_hold().perform()

    def let_go(self):
        from selenium.webdriver import ActionChains

        ActionChains(self.driver).release().perform()

    def answer(self, yes=True):
        self.click("ask-yes" if yes else "ask-no")

    def shot(self, name):
        folder = os.environ.get("PASSO_SHOTS")
        if folder:
            self.driver.save_screenshot(str(Path(folder) / f"{name}.png"))


@pytest.fixture(scope="module")
def panel(tmp_path_factory):
    with PanelProcess(tmp_path_factory.mktemp("panel")) as process:
        yield process


@pytest.fixture(scope="module")
def driver():
    opened = chromium()
    yield opened
    opened.quit()


@pytest.fixture(scope="module")
def axe():
    """The text of axe-core."""
    try:
        return AXE.read_files("axe.min.js")["axe.min.js"].decode()
    except Failure as failure:
        if "cannot fetch" not in str(failure):
            raise
        pytest.skip(f"NO AXE: {failure}")


@pytest.fixture
def browser(panel, driver):
    with Browser(panel, driver) as opened:
        if opened.text("state") == "Alarm":
            opened.click("unlock")
        opened.until_state("Ready")
        yield opened
        assert not [row for row in opened.driver.get_log("browser") if "SyntaxError" in row["message"] or "Uncaught" in row["message"]]


def steps(mm):
    return round(mm * MM)


def jogged(browser, way, end):
    """Jog, end it by `end()`, and see it end at rest, some way on."""
    before = browser.place()
    browser.press(way)
    browser.until(lambda: browser.place() != before)
    end()
    browser.until(lambda: browser.text("state") == "Ready")
    stood = browser.place()
    time.sleep(0.4)
    assert browser.place() == stood
    return before, stood


def test_the_sha256_of_the_page(browser):
    for key, message in (("k", ""), ("KEY", "x" * 55), ("KEY", "x" * 56), ("k" * 70, "é" * 200)):
        found = browser.driver.execute_async_script(
            'const [key, message, done] = arguments; const bytes = (text) => new TextEncoder().encode(text);'
            'import("./sha256.js").then(({hmac, hex}) => done(hex(hmac(bytes(key), bytes(message)))));', key, message)  # fmt: skip
        assert found == Hmac(key.encode()).hex_digest(message.encode())


def test_a_jog_ends_when_it_is_let_go(browser):
    before, after = jogged(browser, "x+", browser.let_go)
    assert after[0] > before[0] and after[1:] == before[1:]
    before, after = jogged(browser, "y+", lambda: browser.driver.execute_script("window.dispatchEvent(new Event('blur'))"))
    browser.let_go()
    assert after[1] > before[1]


def test_reports_switched_off_come_for_a_jog(browser):
    """Without reports the places stand still, but the state does not; a jog asks for reports as long as it lasts."""
    count = "window.told = (window.told || 0)"
    browser.driver.execute_script(count + "; new MutationObserver(() => { window.told += 1; }).observe(document.getElementById('m-x'), {childList: true})")
    browser.choose("refresh", "0")
    before, after = jogged(browser, "x+", browser.let_go)
    assert after[0] > before[0]
    told = browser.driver.execute_script("return window.told")
    browser.driver.execute_script("document.querySelector('input[name=step][value=\"10\"]').click()")
    browser.tap("[data-way='x-']")
    browser.until_state("Moving")
    browser.until_state("Ready")
    assert steps(browser.place()[0]) == steps(after[0]) - 10 * MM
    assert browser.driver.execute_script("return window.told") - told <= 3
    browser.choose("refresh", "50")


def test_steps_zero_and_go_there(browser):
    browser.driver.execute_script("document.querySelector('input[name=step][value=\"1\"]').click()")
    before = browser.place()
    browser.tap("[data-way='x+y+']")
    browser.until(lambda: [round(now - then, 3) for now, then in zip(browser.place(), before)] == [1, 1, 0])
    from selenium.webdriver import ActionChains
    from selenium.webdriver.common.keys import Keys

    browser.until_state("Ready")
    browser.driver.execute_script("document.activeElement.blur()")
    ActionChains(browser.driver).send_keys(Keys.ARROW_LEFT).perform()
    browser.until(lambda: round(browser.place()[0] - before[0], 3) == 0)
    browser.until_state("Ready")
    browser.click("zero-all")
    browser.answer()
    browser.until(lambda: browser.works_at(0, 0, 0))
    browser.click("path")
    browser.fill("goto-x", "3")
    browser.fill("goto-y", "2")
    browser.tap("#goto-form button")
    browser.until(lambda: browser.works_at(3, 2, 0))


def dismiss_caution(browser):
    """Touch the caution of a machine that is not homed: it stays away."""
    browser.until(lambda: "omed:" in browser.text("message") or "referenciada:" in browser.text("message"))
    browser.find("message").click()
    browser.driver.execute_async_script("setTimeout(arguments[0], 700)")  # some states later
    assert not browser.find("message").is_displayed()


def test_a_message_moves_nothing(browser):
    """A key stays under the finger that goes to it; a touch of the message takes the message away."""
    spots = "return [...document.querySelectorAll('button')].map((each) => each.getBoundingClientRect()).filter(({y}) => y < innerHeight).map(({x, y}) => [x, y])"
    size = browser.driver.get_window_size()
    dismiss_caution(browser)
    for width, height in ((1366, 768), (768, 1000), (360, 640)):
        browser.driver.set_window_size(width, height)
        browser.driver.execute_script("scrollTo(0, 0)")
        browser.driver.execute_async_script(STANDS, browser.find("stop"))
        before = browser.driver.execute_script(spots)
        browser.driver.execute_script("document.getElementById('line').value = 'G1'; document.getElementById('line-form').requestSubmit()")
        browser.until(lambda: "22" in browser.text("message"))
        assert browser.driver.execute_script(spots) == before
        browser.find("message").click()
        assert not browser.find("message").is_displayed()
    browser.driver.set_window_size(size["width"], size["height"])


def test_a_job_from_upload_to_end(browser, panel, tmp_path):
    file = tmp_path / "square.gcode"
    file.write_text(SQUARE)
    browser.find("upload").send_keys(str(file))
    browser.until(lambda: "square.gcode" in browser.find("jobs").text and "G1 X20" in browser.text("lines"))
    assert browser.text("lines").count("G1 X20") == 1
    browser.click("check")
    browser.until(lambda: "no error" in browser.text("job-state"))
    browser.until_state("Ready")
    start = browser.place()
    browser.click("run")
    browser.until_state("Running")
    browser.click("hold")
    browser.until_state("Held")
    browser.shot("held")
    time.sleep(0.2)
    stood = browser.place()
    time.sleep(0.4)
    assert browser.place() == stood and stood != start
    browser.click("resume")
    browser.until(lambda: "Done" in browser.text("job-state"))
    assert [round(now - then, 2) for now, then in zip(browser.place(), start)] == [0, 0, 0]
    browser.fill("passes", "3")
    browser.click("run")
    browser.until_state("Running")
    browser.click("abort")
    browser.until(lambda: "Ended" in browser.text("job-state"))
    browser.until(lambda: browser.text("state") in ("Ready", "Alarm"))


def test_the_pace_of_a_job_is_told(browser, panel, tmp_path):
    """Lines a second, and how full the board's queue is, while it runs."""
    file = tmp_path / "teeth.gcode"
    file.write_text("G21 G91 F3000\n" + "X0.5\nX-0.5\n" * 600)
    browser.find("upload").send_keys(str(file))
    browser.until(lambda: "teeth.gcode" in browser.text("run"))
    browser.click("run")
    browser.until(lambda: re.search(r"\d+ lines a second, queue \d+ %$", browser.text("job-time")))
    browser.shot("pace")
    browser.click("abort")
    browser.until(lambda: "Ended" in browser.text("job-state"))
    browser.until(lambda: browser.text("state") in ("Ready", "Alarm"))


def test_the_path_and_its_lines(browser, panel, tmp_path):
    """A touch on the path shows its line, one beside it a place to go to; a line shows its path; the table is that of the settings."""
    from selenium.webdriver import ActionChains

    file = tmp_path / "corner.gcode"
    file.write_text("G21 G90 F900\nG1 X0 Y0\nX40\nY30 F300\n")
    browser.find("upload").send_keys(str(file))
    browser.until(lambda: "Y30" in browser.text("lines"))
    browser.driver.execute_script(BRING, browser.find("path"))
    width, height = (browser.find("path").size[side] for side in ("width", "height"))
    scale = 0.9 * min(width / 40, height / 30)
    touch = lambda x, y: ActionChains(browser.driver).move_to_element_with_offset(  # noqa: E731
        browser.find("path"), (x - 20) * scale, (15 - y) * scale).click().perform()
    touch(40, 20)
    browser.until(lambda: browser.text("path-line") == "line 4: Y30 F300" and "4" in browser.css("#lines b").text)
    touch(10, 20)
    assert browser.text("path-line") == ""
    assert abs(float(browser.find("goto-x").get_attribute("value")) - 10) < 0.3 and abs(float(browser.find("goto-y").get_attribute("value")) - 20) < 0.3
    browser.tap("#lines span:nth-child(3)")
    browser.until(lambda: browser.text("path-line") == "line 3: X40")
    browser.click("path-in")
    browser.click("path-solid")
    browser.choose("path-shade", "feed")
    assert browser.find("path-solid").get_attribute("aria-pressed") == "true"
    browser.shot("path-solid")
    browser.click("path-solid")
    browser.choose("path-shade", "")
    browser.click("path-fit")
    ink = "const c = document.getElementById('path'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; return d.some((each) => each)"
    browser.until(lambda: browser.driver.execute_script(ink))


PAUSES = "G21 G90 F3000\nG1 X9000\nM0\nT2 M6\nX0\n"


def test_what_a_job_will_do_is_told(browser, panel, tmp_path):
    """Size, time, bounds, tools; the bounds beyond the travel; a file dropped on the page is a job, too."""
    browser.driver.execute_script(
        "const data = new DataTransfer(); data.items.add(new File([arguments[0]], 'far.gcode'));"
        "document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }))", PAUSES)
    browser.until(lambda: "far.gcode" in browser.text("run"))
    browser.until(lambda: "tools T2" in browser.text("job-facts"))
    facts = browser.text("job-facts")
    assert facts.startswith("5 lines, 1 kB · about ") and "X 0.0 … 9000.0, Y" in facts and facts.endswith("pauses: 1")
    assert "out of the travel: X 0.0 … 9000.0 mm" in browser.text("job-wrong")


def test_a_pause_is_a_bar_with_its_button(browser, panel, tmp_path):
    """M0 and M6: the bar says what to do, and its button goes on; meanwhile the page shows how long the pause has lasted."""
    file = tmp_path / "pauses.gcode"
    file.write_text("G21 G91 F3000\nM0\nX4\nT2 M6\nX-4\n")
    browser.find("upload").send_keys(str(file))
    browser.until(lambda: "pauses.gcode" in browser.text("run"))
    browser.click("run")
    for text in ("The program has paused (M0)", "Put in tool T2"):
        browser.until(lambda text=text: text in browser.text("wait-text"))
        assert "gone" in browser.text("job-time")
        browser.shot("wait-bar")
        browser.click("wait-go")
    browser.until(lambda: "Done" in browser.text("job-state") and not browser.find("wait-bar").is_displayed())


def test_the_job_chosen_is_kept(browser, panel, tmp_path):
    """After a reload *Run* starts the job named before; without a choice it starts nothing, and it asks before it starts a job that is not shown."""
    for name in ("a first.gcode", "the second.gcode"):
        (tmp_path / name).write_text(f"G21 G91 F3000 ({name})\nG1 X1\n")
        browser.find("upload").send_keys(str(tmp_path / name))
        browser.until(lambda name=name: name in browser.text("lines"))
    browser.until(lambda: browser.text("run") == "Run the second.gcode")
    browser.driver.execute_script("document.getElementById('run').scrollIntoView({block: 'center'})")
    browser.shot("chosen")
    for _ in range(2):
        browser.driver.refresh()
        browser.until(lambda: "the second.gcode" in browser.text("run") and "the second.gcode" in browser.text("lines"))
    browser.click("run")
    browser.until(lambda: "Done" in browser.text("job-state"))
    assert "the second.gcode" in browser.text("job-state")
    browser.driver.execute_script("localStorage.clear()")
    browser.driver.refresh()
    browser.until(lambda: "a first.gcode" in browser.find("jobs").text)
    assert browser.text("run") == "Run" and not browser.find("run").is_enabled()
    before = browser.place()
    browser.driver.execute_script("document.getElementById('jobs').value = 'a first.gcode'")  # chosen, and its text has not come
    browser.click("run")
    browser.until(lambda: browser.text("ask-text") == "Run a first.gcode, which is not shown here yet?")
    browser.answer(False)
    assert browser.place() == before
    browser.driver.refresh()


def test_teach_in(browser, panel):
    browser.driver.execute_script("document.querySelector('input[name=step][value=\"1\"]').click()")
    browser.click("teach-begin")
    browser.until(lambda: "1 places" in browser.text("teach-state"))
    start = browser.place()
    for number, way in enumerate(("x+", "x+", "y+")):
        browser.until_state("Ready")
        browser.tap(f"[data-way='{way}']")
        browser.until(lambda: f"{number + 2} places" in browser.text("teach-state"))
    taught = browser.place()
    browser.click("teach-save")
    browser.until(lambda: "taught.gcode" in browser.find("jobs").text)
    text = (panel.jobs / "taught.gcode").read_text()
    assert text.count("G1") == 2, text
    for way in ("x-", "x-", "y-"):
        browser.until_state("Ready")
        before = browser.place()
        browser.tap(f"[data-way='{way}']")
        browser.until(lambda: browser.place() != before)
    browser.until(lambda: browser.text("state") == "Ready" and browser.place() == start)
    browser.click("run")
    browser.until(lambda: "taught.gcode: Done" in browser.text("job-state"))
    assert browser.place() == taught


def switched(browser, name, text):
    """Press a button of the tool unless its signal shows already; the spindle's last order may still be under way."""
    if text in browser.find("signals").get_attribute("textContent"):
        return True
    if browser.text("state") == "Ready":
        browser.tap(f"[data-output='{name}']")
        time.sleep(0.5)
    return False


def junction(browser):
    """The value of $11 that the page shows; the table is made anew when settings come."""
    return float(browser.driver.execute_script("return document.querySelector(\"[aria-label^='$11 ']\").value"))


def test_tool_overrides_line_and_settings(browser):
    for name, text in (("spindle_cw", "Spindle: on"), ("spindle_off", "Spindle: off"), ("flood", "Coolant: on"),
                       ("coolant_off", "Coolant: off"), ("mist", "Mist: on"), ("coolant_off", "Mist: off")):  # fmt: skip
        browser.until(lambda: switched(browser, name, text))
    for button, what, text in (("feed+10", "feed", "110 %"), ("feed100", "feed", "100 %"), ("rapid25", "rapid", "25 %"), ("rapid100", "rapid", "100 %")):
        browser.tap(f"[data-override='{button}']")
        browser.until(lambda: browser.text(f"ov-{what}") == text)
    for line, answer in (("$LINK", "[LINK:"), ("G9", "Error 20")):
        browser.fill("line", line)
        browser.tap("#line-form button")
        browser.until(lambda line=line, answer=answer: f"> {line}" in browser.text("said") and answer in browser.text("said"))
    from selenium.webdriver.common.keys import Keys

    browser.find("line").send_keys(Keys.ARROW_UP, Keys.ARROW_UP)
    assert browser.find("line").get_attribute("value") == "$LINK"
    browser.tap("#card-settings summary")
    for yes, kept in ((False, 0.01), (True, 0.02)):
        browser.driver.execute_script(
            "const input = document.querySelector(\"[aria-label^='$11 ']\"); input.value = '0.02'; input.dispatchEvent(new Event('change'))")
        browser.answer(yes)
        browser.until(lambda: junction(browser) == kept)
    browser.click("give")
    browser.until(lambda: "sender" in browser.text("owner"))
    browser.tap("[data-way='x+']")
    browser.until(lambda: "112" in browser.text("message"))
    browser.click("take")
    browser.until(lambda: browser.text("owner") == "this page")


def test_stop_and_a_page_without_the_key(browser, panel):
    """Anybody stops a move, and a jog that is held. On a PC that is late the jog may have ended before: then it stands, and no alarm comes."""
    with Browser(panel, key=False) as stranger:
        assert stranger.find("card-key").is_displayed()
        before = stranger.place()
        stranger.press("x+")
        stranger.until(lambda: "172" in stranger.text("message"))
        stranger.let_go()
        assert stranger.place() == before
        browser.press("x+")
        browser.until(lambda: browser.place() != before)
        stranger.click("stop")
        browser.until(lambda: browser.text("state") in ("Alarm", "Ready"))
        stood = browser.place()
        time.sleep(0.4)
        assert browser.place() == stood, "though the button is still held"
        browser.let_go()
        if browser.text("state") == "Alarm":
            browser.click("unlock")
            browser.until_state("Ready")
        browser.fill("line", "$J=G91X20F60")
        browser.tap("#line-form button")
        browser.until_state("Moving")
        stranger.click("stop")
        browser.until_state("Alarm")
        stranger.fill("key", panel.key.lower())
        stranger.tap("#key-form button")
        stranger.until(lambda: not stranger.find("card-key").is_displayed())
        stranger.click("unlock")
        stranger.until_state("Ready")


class Cable:
    """Carries a browser's bytes to the panel until it is cut: then nothing comes any more, and no connection ends."""

    def __init__(self, port):
        self._target = port
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        self.whole = True
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        while True:
            try:
                one, _ = self._server.accept()
            except OSError:
                return
            other = socket.create_connection(("127.0.0.1", self._target))
            for ends in ((one, other), (other, one)):
                threading.Thread(target=self._carry, args=ends, daemon=True).start()

    def _carry(self, one, other):
        try:
            while data := one.recv(65_536):
                while not self.whole:
                    time.sleep(0.1)
                other.sendall(data)
            other.close()
        except OSError:
            other.close()


def descendants(pid):
    """The processes that a process has started, and those that they have."""
    found = [path.read_text() for path in Path(f"/proc/{pid}/task").glob("*/children")]
    children = [int(word) for text in found for word in text.split()]
    return children + [each for child in children for each in descendants(child)]


@pytest.mark.parametrize("how", ["cut", "killed"])
def test_a_lost_link_ends_the_jog(browser, panel, how):
    """`browser` looks on, while the one that jogs loses its link, or is killed."""
    cable = Cable(panel.port)
    jogger = Browser(panel, address=f"http://127.0.0.1:{cable.port}/")
    try:
        before = browser.place()
        jogger.press("y+")
        browser.until(lambda: browser.place() != before)
        if how == "cut":
            cable.whole = False
        else:
            children = descendants(jogger.driver.service.process.pid)
            assert children
            for process in children:
                os.kill(process, 9)
        time.sleep(0.5)  # a computer that is late lets the machine stand between two pieces of a jog; its lease is over by now
        browser.until_state("Ready")
        stood = browser.place()
        cable.whole = True
        time.sleep(1)
        assert browser.place() == stood, "bytes held up in the cable may not move the machine"
    finally:
        if how == "cut":
            jogger.driver.quit()
        else:
            jogger.driver.service.stop()


DESKTOP, PHONE = (1280, 2000), (390, 3400)
SIZES = ((360, 640), (768, 1024), (1366, 768))
LOOKS = [(DESKTOP, "en", "light"), (PHONE, "pt", "dark")]
LOOKS += [pytest.param(size, language, theme, marks=pytest.mark.slow) for size in (DESKTOP, PHONE) for language in ("en", "pt")
          for theme in ("light", "dark") if (size, language, theme) not in LOOKS]  # fmt: skip


def faults_found(browser, axe):
    """Return all faults that axe-core finds on the page, however small: [(rule, nodes)]."""
    browser.driver.execute_cdp_cmd("Runtime.evaluate", {"expression": axe})
    found = browser.driver.execute_async_script(
        "const done = arguments[0]; axe.run({resultTypes: ['violations']}).then((result) => done(JSON.stringify(result.violations)))")
    return [(rule["id"], [node["html"][:120] for node in rule["nodes"]]) for rule in json.loads(found)]


@pytest.mark.parametrize("size, language, theme", LOOKS)
def test_axe_finds_nothing(panel, driver, axe, size, language, theme):
    with Browser(panel, driver, size, f"lang={language}&theme={theme}") as browser:
        browser.until(lambda: browser.text("h-place") == {"en": "Position", "pt": "Posição"}[language])
        browser.shot(f"{language}-{theme}-{size[0]}")
        wide = browser.driver.execute_script("return document.documentElement.scrollWidth - window.innerWidth")
        assert wide <= 0, f"{wide} pixels beyond the window"
        assert not faults_found(browser, axe)




@pytest.mark.parametrize("size", SIZES)
def test_nothing_is_longer_than_two_screens(panel, driver, size):
    """Each part on a phone, all of them at once on a tablet and a PC; STOP and the state are in sight at the end of it, too."""
    with Browser(panel, driver) as browser:
        within_two_screens(browser, size)


DEEP = "G21 G90 G54\nT1 M6\nG0 Z5\n" + "G1 X80 Y65 F900 Z-2\nG0 Z5 X0 Y0\n" * 5 + "M30\n"  # two warnings: tools, and out of the travel
SHEET = '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40"><path d="M5 5 L55 5 L55 35 L5 35 Z" fill="none" stroke="#000"/></svg>'


@pytest.mark.parametrize("board, name, text", [
    ("torch_manipulator", "", ""), ("router_3axis", "deep.gcode", DEEP), ("plotter_2014", "sheet.svg", SHEET),
    *(pytest.param(*each, marks=pytest.mark.slow) for each in (("two_motor_kit", "", ""), ("lpt_router", "", ""), ("laser_xy", "deep.gcode", DEEP))),
], ids=lambda value: value if len(value) < 20 else "")  # fmt: skip
def test_what_is_longest_in_portuguese(tmp_path, driver, board, name, text):
    """With a job chosen and all its facts shown."""
    with PanelProcess(tmp_path, "--board", board) as process, Browser(process, driver, query="lang=pt&theme=light") as browser:
        browser.until(lambda: browser.find("card-jog").is_displayed() or browser.find("card-keys").is_displayed())
        if name:
            (tmp_path / name).write_text(text)
            browser.find("upload").send_keys(str(tmp_path / name))
            browser.until(lambda: "cerca de" in browser.find("job-facts").get_attribute("textContent"))
        for size in SIZES:
            within_two_screens(browser, size)


@pytest.mark.parametrize("language, name", [("en", "steps per degree"), ("pt", "passos por grau")])
def test_a_rotary_axis_counts_degrees(tmp_path, driver, language, name):
    with PanelProcess(tmp_path, "--board", "router_4axis") as process, Browser(process, driver, query=f"lang={language}&theme=light") as browser:
        browser.until(lambda: browser.driver.execute_script("return [...document.querySelectorAll('#settings tr')].some((row) => row.textContent.includes(arguments[0]))", name))
        for size in SIZES:
            within_two_screens(browser, size)
            browser.shot(f"rotary-{language}-{size[0]}")
        said = {what: [each.get_attribute("textContent") for each in browser.driver.find_elements("css selector", what)]
                for what in ("#places th", "#where small", "#goto-axes span", "#pad small", "#settings tr", "[data-turns]")}  # fmt: skip
        assert ("Locked" if language == "en" else "Travada") in browser.text("message")
        assert said["#places th"] == ["X mm", "Y mm", "Z mm", "A °"] and said["#where small"] == ["mm", "mm", "mm", "°"]
        assert said["#goto-axes span"] == ["X, mm", "Y, mm", "Z, mm", "A, °"]
        assert [text for text in said["#pad small"] if "°" in text] == ["A+ °", "A− °"]
        rows = {row.partition(" ")[0]: row for row in (" ".join(row.split("\n")) for row in said["#settings tr"])}
        for number, unit in (("$103", "steps/°" if language == "en" else "passos/°"), ("$113", "°/min"), ("$123", "°/s²")):
            assert [row for row in rows.values() if row.startswith(number) and unit in row and "mm" not in row], rows
        assert [row for row in rows.values() if row.startswith("$103") and name in row] and [row for row in rows.values() if row.startswith("$102") and "mm" in row], rows
        assert said["[data-turns]"] == [", A:\u00a0°/min", ", A:\u00a0°", ", A:\u00a0°/min"]


def test_a_clamp_and_a_vacuum_have_their_buttons(tmp_path, driver):
    """Each by its own code; letting go of the work is asked for, and refused beneath a spindle."""
    board = boards.load("router_3axis")
    board["outputs"] += [{"name": "clamp", "pin": 22}, {"name": "p1_vacuum", "pin": 28}]
    file = tmp_path / "mine.py"
    file.write_text(f"BOARD = {board!r}\n")

    def pressed(word):
        return browser.driver.execute_script("return document.querySelector(`[data-work='${arguments[0]}']`).getAttribute('aria-pressed')", word) == "true"

    def refusals():
        return browser.driver.execute_script("return document.body.textContent.includes(arguments[0])", "M5 first")

    with PanelProcess(tmp_path, "--board", str(file)) as process, Browser(process, driver, query="lang=en&theme=light") as browser:
        browser.until(lambda: "Locked" in browser.text("message"))
        browser.click("unlock")
        browser.until(lambda: "Locked" not in browser.text("message"))
        for word in ("Vac", "Clamp"):
            browser.until(lambda word=word: browser.css(f"[data-work='{word}']").is_displayed())
            browser.tap(f"[data-work='{word}']")
            browser.until(lambda word=word: pressed(word))
        browser.until(lambda: switched(browser, "spindle_cw", "Spindle: on"))
        browser.tap("[data-work='Clamp']")
        browser.answer(False)
        browser.tap("[data-work='Clamp']")
        browser.answer(True)
        browser.until(refusals)
        assert pressed("Clamp")
        browser.until(lambda: switched(browser, "spindle_off", "Spindle: off"))
        browser.tap("[data-work='Clamp']")
        browser.answer(True)
        browser.until(lambda: not pressed("Clamp"))
        assert pressed("Vac")
        browser.tap("[data-work='Vac']")
        browser.until(lambda: not pressed("Vac"))


def test_beside_a_clamp_a_vacuum_without_a_number_has_no_button(tmp_path, driver):
    """M10 is the clamp's there."""
    board = boards.load("router_3axis")
    board["outputs"] += [{"name": "clamp", "pin": 22}, {"name": "vacuum", "pin": 28}]
    file = tmp_path / "mine.py"
    file.write_text(f"BOARD = {board!r}\n")
    with PanelProcess(tmp_path, "--board", str(file)) as process, Browser(process, driver, query="lang=en&theme=light") as browser:
        browser.until(lambda: browser.css("[data-work='Clamp']").is_displayed())
        browser.until(lambda: not browser.css("[data-work='Vac']").is_displayed())


# Positions as long as these, and the rows and columns of their table are as before.
LONG = """
const cells = [...document.querySelectorAll("#places td[id]")], row = () => document.querySelector("#places tr").offsetHeight, before = row();
for (const cell of cells) cell.textContent = "-116.559";
const table = document.querySelector("#card-place table");
return [row() - before, table.getBoundingClientRect().right <= document.getElementById("zero-all").parentNode.getBoundingClientRect().right];
"""


@pytest.mark.parametrize("language", ["en", "pt"])
def test_long_positions_fit_on_a_phone(panel, driver, language):
    with Browser(panel, driver, query=f"lang={language}&theme=light") as browser:
        browser.until(lambda: browser.find("card-place").is_displayed() and browser.find("w-z").get_attribute("textContent"))
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 360, "height": 640, "deviceScaleFactor": 1, "mobile": True})
        try:
            browser.until(lambda: driver.execute_script("return innerWidth") == 360)
            driver.execute_script("document.querySelector('[data-tab=move]').click()")
            assert driver.execute_script(LONG) == [0, True]
        finally:
            driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


# How dark the path's picture is, 0 … 1, amid its left and its right half.
DARK = """
const canvas = document.getElementById("path"), ink = canvas.getContext("2d"), size = 30;
return [0.33, 0.75].map((part) => {
    const { data } = ink.getImageData(part * canvas.width - size / 2, (canvas.height - size) / 2, size, size);
    let sum = 0;
    for (let at = 0; at < data.length; at += 4) sum += data[at + 3] * (255 - data[at]);
    return sum / (255 * 255 * size * size);
});
"""
FILL = "G21 G90 G54\nM4 S0\nG1 F6000\nG0 X10 Y10\n" + "".join(f"G1 X60 S50\nX110 S1000\nG0 X10 Y{10 + row / 5}\n" for row in range(300)) + "M5\nM2\n"


@pytest.mark.slow
def test_a_fill_is_the_picture_that_it_burns(tmp_path, driver):
    """Rows as dark as their power, and as thin as they are close: no block of one grey."""
    (tmp_path / "fill.gcode").write_text(FILL)
    with PanelProcess(tmp_path, "--board", "laser_xy") as process, Browser(process, driver) as browser:
        browser.until(lambda: browser.find("card-place").is_displayed())
        browser.find("upload").send_keys(str(tmp_path / "fill.gcode"))
        browser.until(lambda: driver.execute_script(DARK)[1] > 0.2)
        browser.shot("fill")
        weak, strong = driver.execute_script(DARK)
        assert weak < strong / 3


# The texts that can be read on the page, name by name, without the places and times of now.
READ = """
const seen = [...document.querySelectorAll("body *")].filter((e) => !e.children.length && e.textContent.trim() && !e.closest("script, noscript, option, #where, #places, #job-state, dialog"));
return seen.map((e) => `${(e.closest("[id]") || {}).id}: ${e.textContent.trim()}`);
"""


def test_another_language_is_that_of_the_whole_page(panel, driver, tmp_path):
    """Chosen on a page that stands, it changes every word that a page opened in it would show."""
    (tmp_path / "deep.gcode").write_text(DEEP)
    with Browser(panel, driver) as browser:
        browser.find("upload").send_keys(str(tmp_path / "deep.gcode"))
        browser.until(lambda: "tools T1" in browser.find("job-facts").get_attribute("textContent") and "deep.gcode" in browser.find("run").get_attribute("textContent"))
        browser.choose("language", "pt")
        browser.until(lambda: browser.find("h-job").get_attribute("textContent") == "Trabalho")
        changed = driver.execute_script(READ)
    with Browser(panel, driver, query="lang=pt&theme=light") as browser:
        browser.until(lambda: "ferramentas T1" in browser.find("job-facts").get_attribute("textContent"))
        browser.until(lambda: set(driver.execute_script(READ)) == set(changed))  # some words come with a later status only


def test_pause_is_always_in_sight(panel, driver, tmp_path):
    """While a job runs it stands beside STOP, on each part of a phone's page; two quick taps have paused, and not gone on."""
    (tmp_path / "paused.gcode").write_text("G21 G91 F600\n" + "G1 X9 Y9\nG1 X-9 Y-9\n" * 30)
    screen = {"width": 360, "height": 640, "deviceScaleFactor": 1, "mobile": True}
    with Browser(panel, driver) as browser:
        if browser.find("unlock").is_enabled():
            browser.click("unlock")
        browser.until(lambda: browser.find("state").get_attribute("data-state") == "Idle")
        assert not browser.find("pause").is_displayed()
        browser.find("upload").send_keys(str(tmp_path / "paused.gcode"))
        browser.until(lambda: "paused.gcode" in browser.text("run"))
        browser.click("run")
        browser.until(lambda: browser.find("state").get_attribute("data-state") == "Run")
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        try:
            for name in ("path", "machine", "move"):
                browser.css(f"[data-tab={name}]").click()
                pause, stop = browser.find("pause").rect, browser.find("stop").rect
                assert browser.text("pause") == "Pause" and pause["height"] >= 48
                assert pause["x"] + pause["width"] <= stop["x"] + 1 and stop["width"] > 0.6 * 360
            browser.shot("pause")
            browser.until(lambda: browser.find("pause").is_enabled())
            driver.execute_script("const pause = document.getElementById('pause'); pause.click(); setTimeout(() => pause.click(), 300)")
            browser.until_state("Held")
            time.sleep(1)
            assert browser.text("state") == "Held" and browser.text("pause") == "Resume"
            browser.shot("paused")
            browser.find("pause").click()
            browser.until_state("Running")
            browser.css("[data-tab=job]").click()
        finally:
            driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.click("abort")
        browser.until_state("Ready")
        assert not browser.find("pause").is_displayed()


def test_a_job_that_runs_makes_nothing_longer(panel, driver, tmp_path):
    file = tmp_path / "slow.gcode"
    file.write_text("G21 G91 F600\n" + "G1 X9 Y9\nG1 X-9 Y-9\n" * 30)
    with Browser(panel, driver, query="lang=pt&theme=light") as browser:
        if browser.find("unlock").is_enabled():
            browser.click("unlock")
        browser.until(lambda: browser.find("state").get_attribute("data-state") == "Idle")
        browser.find("upload").send_keys(str(file))
        browser.until(lambda: "slow.gcode" in browser.text("run"))
        browser.click("run")
        browser.until(lambda: browser.find("state").get_attribute("data-state") == "Run")
        for size in SIZES:
            within_two_screens(browser, size)
        browser.click("abort")
        browser.until(lambda: browser.find("state").get_attribute("data-state") == "Idle")


def within_two_screens(browser, size):
    width, height = size
    driver = browser.driver
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
    before = driver.execute_script("return innerWidth")
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    try:
        tabs = driver.find_elements("css selector", "[data-tab]")
        for tab in [each for each in tabs if each.is_displayed()] or tabs[:1]:
            if tab.is_displayed():
                tab.click()
            browser.until(lambda: driver.execute_script("return document.documentElement.scrollHeight") <= 2 * height)  # once it is laid out
            assert driver.execute_script("return document.documentElement.scrollWidth") <= width
            driver.execute_script("scrollTo(0, 1e6)")
            for name in ("stop", "state"):
                top, bottom = driver.execute_script("const box = arguments[0].getBoundingClientRect(); return [box.top, box.bottom]", browser.find(name))
                assert 0 <= top and bottom <= height  # asked in one step: a status may change what lies above meanwhile
            small = driver.execute_script(
                "return [...document.querySelectorAll('button')].filter((e) => e.offsetParent && e.offsetHeight < 48).map((e) => e.id || e.textContent)")
            assert not small
    finally:
        driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.until(lambda: driver.execute_script("return innerWidth") == before)  # else the next click meets what stood there

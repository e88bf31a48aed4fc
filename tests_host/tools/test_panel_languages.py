"""The page of machines that do not speak G-code, in Chromium: pulse files, and which cards the page hides for each language.

As tools/test_panel_page.py; `place` and `trace` are those of the virtual board.
"""

import time

import pytest

from panel_process import PanelProcess
from test_panel_page import CHROMIUM, DRIVER, Browser, axe, chromium, faults_found  # noqa: F401
from test_panel_walk import Walker

pytestmark = [
    pytest.mark.unmeasured,
    pytest.mark.xdist_group("panel"),
    pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="NO BROWSER: apt-get install chromium chromium-driver, to test the page"),
]
PULSES = "[+300(\n" + "A" * 400 + "\n" + "G" * 200 + "\n)*1500\n" + "D" * 100 + "\n]\n"
END = (600, 100, 0)


@pytest.fixture(scope="module")
def driver():
    opened = chromium()
    yield opened
    opened.quit()


def step_of(browser, value):
    browser.driver.execute_script(f"document.querySelector('input[name=step][value=\"{value}\"]').click()")


def upload(browser, tmp_path, name, text):
    file = tmp_path / name
    file.write_text(text)
    browser.find("upload").send_keys(str(file))
    browser.until(lambda: name in browser.find("jobs").text and browser.find("jobs").get_attribute("value") == name)


def play(browser, what):
    browser.until(lambda: browser.css(f"[data-play={what}]").is_enabled())
    browser.tap(f"[data-play={what}]")


def marked(browser):
    """Return the line under way, from a list that the page makes anew all the time."""
    return browser.driver.execute_script("const mark = document.querySelector('#lines b'); return mark ? mark.textContent : ''")


def steps(panel):
    """Return the places after each step, once the panel has ended."""
    return [tuple(row[1:4]) for row in panel.trace()]


@pytest.mark.slow
def test_pulse_files(tmp_path, driver):
    """Played, paused, moved by hand and back; backward; code by code; taught; the steps are those of the trace."""
    with PanelProcess(tmp_path, "--board", "lpt_router") as panel:
        browser = Browser(panel, driver, (1280, 1600))
        browser.until_state("Ready")
        hidden = ["card-tool", "card-signals", "card-line", "card-motors", "zero-all", "home", "jog-speed"]
        assert not [name for name in hidden if browser.find(name).is_displayed()]
        assert not browser.driver.find_elements("css selector", "[data-way='x+y+']")
        upload(browser, tmp_path, "part.txt", PULSES)
        browser.click("check")
        browser.until(lambda: "no error" in browser.text("job-state"))
        browser.until_state("Ready")
        browser.click("run")
        browser.until(lambda: "Playing" in browser.text("job-state") and browser.place()[0] > 1)
        assert marked(browser) in ("A", "G") and not browser.text("lines").startswith("…")
        browser.click("hold")
        browser.until_state("Held")
        held = browser.place()
        browser.shot("pulses-held")
        step_of(browser, 1)
        browser.tap("[data-way='z+']")
        browser.until(lambda: browser.place()[2] == 1 and browser.find("by-hand").is_displayed())
        assert not browser.find("resume").is_enabled()
        browser.shot("pulses-by-hand")
        play(browser, "return")
        browser.until(lambda: "waits" in browser.text("countdown"))
        assert browser.place()[2] == 0 and browser.place()[0] > held[0]
        browser.shot("pulses-waits")
        browser.until(lambda: "Done" in browser.text("job-state"))
        browser.until(lambda: browser.place() == [place / 80 for place in END])
        play(browser, "back")
        browser.until(lambda: "Back at the start" in browser.text("job-state"))
        browser.until(lambda: browser.place() == [0, 0, 0])
        browser.click("single")
        browser.until(lambda: "1 of 706" in browser.text("job-state") and browser.text("state") == "Held")
        for number in (2, 3, 4):
            browser.click("single")
            browser.until(lambda: f"{number} of 706" in browser.text("job-state"))
        browser.until(lambda: browser.place() == [round(1 / 80, 3), 0, 0])
        play(browser, "step_back")
        browser.until(lambda: browser.place() == [0, 0, 0])
        browser.click("abort")
        browser.until_state("Ready")
        for name, text in (("tool_on", "on"), ("tool_off", "off"), ("drives_on", "on"), ("drives_off", "off")):
            browser.until(lambda: browser.css(f"[data-switch={name}]").is_enabled())
            browser.tap(f"[data-switch={name}]")
            browser.until(lambda: browser.css(f"[data-shows={name.split('_')[0]}]").text == text)
        browser.tap("[data-switch=drives_on]")
        browser.fill("pace", "600")
        browser.tap("#pace-form button")
        browser.until(lambda: browser.text("speed-now") == "600")
        browser.click("teach-begin")
        browser.until(lambda: "0 places" in browser.text("teach-state"))
        step_of(browser, 0)
        browser.press("x+")
        browser.until(lambda: browser.place()[0] > 0.5)
        browser.let_go()
        browser.until_state("Ready")
        step_of(browser, 1)
        browser.tap("[data-way='y+']")
        browser.until(lambda: browser.place()[1] == 1)
        browser.until_state("Ready")
        taught = browser.place()
        browser.click("teach-save")
        browser.until(lambda: browser.find("jobs").get_attribute("value") == "taught.txt")
        browser.click("run")
        browser.until(lambda: "taught.txt: Done" in browser.text("job-state"))
        browser.until_state("Ready")
        assert browser.place() == pytest.approx([2 * part for part in taught], abs=0.0021)  # places are shown to 0.001 mm
        assert not [row for row in browser.driver.get_log("browser") if "SyntaxError" in row["message"] or "Uncaught" in row["message"]]
    walked = steps(panel)
    assert END in walked and walked[-1] == tuple(round(2 * part * 80) for part in taught)
    corner = walked.index((400, 0, 0))
    assert walked[corner : corner + 201] == [(400 + step, step, 0) for step in range(201)]


def field(browser, form, **values):
    """Fill in the fields of a form."""
    for name, value in values.items():
        browser.driver.execute_script(f"document.querySelector('#{form} [name={name}]').value = '{value}'")


def send(browser, form):
    browser.until(lambda: browser.css(f"#{form} button").is_enabled())
    browser.tap(f"#{form} button")


@pytest.mark.slow
def test_the_torch(tmp_path, driver):
    """The relays, a jog, a place on the plane, each axis on its own, a seam, the origin, preferences that ask first."""
    with PanelProcess(tmp_path, "--board", "torch_manipulator") as panel:
        browser = Browser(panel, driver, (1280, 2000))
        browser.until_state("Ready")
        assert not [name for name in ("card-job", "card-tool", "card-teach", "home") if browser.find(name).is_displayed()]
        assert browser.css("[data-shows=ours]").text == "off"
        step_of(browser, 1)
        browser.tap("[data-way='x+']")
        browser.until(lambda: "117" in browser.text("message"))
        browser.tap("[data-switch=motors_on]")
        browser.until(lambda: browser.css("[data-shows=ours]").text == "on")
        browser.until_state("Ready")
        place = lambda: [float(browser.text(f"m-{axis}")) for axis in "xy"]  # noqa: E731
        browser.tap("[data-way='x+']")
        browser.until(lambda: place() == [1, 0])
        step_of(browser, 0)
        browser.press("y+")
        browser.until(lambda: place()[1] > 2)
        browser.let_go()
        browser.until_state("Ready")
        browser.fill("goto-x", "10")
        browser.fill("goto-y", "5")
        browser.tap("#goto-form button")
        browser.until(lambda: place() == [10, 5])
        browser.until_state("Ready")
        field(browser, "move-form", x=-5, y=5, xv=600, yv=1200)
        send(browser, "move-form")
        browser.until(lambda: place() == [5, 10])
        browser.until_state("Ready")
        field(browser, "weave-form", x=10, y=0, amplitude=2, pitch=5)
        send(browser, "weave-form")
        browser.until_state("Running")
        browser.shot("torch-weaves")
        browser.until(lambda: place() == [15, 10])
        browser.until_state("Ready")
        for yes in (False, True):
            field(browser, "preferences-form", jogx=2, sx=48)
            send(browser, "preferences-form")
            browser.answer(yes)
        browser.until(lambda: browser.text("message") == "")
        browser.until_state("Ready")
        browser.click("origin")
        browser.answer()
        browser.until(lambda: place() == [0, 0])
        browser.tap("[data-switch=motors_off]")
        browser.until(lambda: browser.css("[data-shows=ours]").text == "off")
        assert not [row for row in browser.driver.get_log("browser") if "SyntaxError" in row["message"] or "Uncaught" in row["message"]]
    walked = [row[:2] for row in steps(panel)]
    assert (480, 415) in walked and (240, 830) in walked and walked[-1] == (720, 830)
    sides = [y for _, y in walked[walked.index((240, 830)) :]]
    assert abs(max(sides) - 830 - 166) <= 1 and abs(min(sides) - 830 + 166) <= 1


@pytest.mark.slow
def test_a_job_of_grbl_step_by_step(tmp_path, driver):
    """One line a press, the one under way marked; Resume goes on with the rest."""
    with PanelProcess(tmp_path) as panel:
        browser = Browser(panel, driver, (1280, 1600))
        browser.until(lambda: browser.text("state") in ("Ready", "Alarm"))
        if browser.text("state") == "Alarm":
            browser.click("unlock")
        browser.until_state("Ready")
        start = browser.place()
        upload(browser, tmp_path, "square.gcode", "G21 G91\nG1 X4 F3000\nY4\nX-4\nY-4\n")
        for line, by in ((1, (0, 0)), (2, (4, 0)), (3, (4, 4))):
            browser.until(lambda: browser.text("state") == "Ready")
            browser.click("single")
            browser.until(lambda: f"line {line}, {line} of 5" in browser.text("job-state"))
            browser.until(lambda: [round(now - then, 3) for now, then in zip(browser.place(), start)] == [*by, 0])
        assert "step by step" in browser.text("job-state") and marked(browser).startswith("3")
        browser.click("resume")
        browser.until(lambda: "Done" in browser.text("job-state") and browser.place() == start)


SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40"><title>praça</title>'
    '<rect x="10" y="10" width="20" height="10" fill="none" stroke="black"/></svg>'
)


def played(browser, what):
    """Press a button of the plotter's card."""
    button = f"#card-plotter [data-play={what}]"
    browser.until(lambda: browser.css(button).is_enabled())
    browser.tap(button)


@pytest.mark.slow
def test_the_plotter(tmp_path, driver):
    """Homed, a place, a drawing from SVG that is drawn point by point, its speed, STOP; a file that is none is named."""
    with PanelProcess(tmp_path, "--board", "plotter_2014") as panel:
        browser = Walker(panel, driver)
        browser.until_state("Ready")
        hidden = ("card-tool", "card-teach", "card-switches", "hold", "resume", "zero-all", "unlock")
        assert not [name for name in hidden if browser.find(name).is_displayed()]
        browser.click("home")
        browser.until_state("Homing")
        deadline = time.monotonic() + 60  # homing is simulated finely: it may take longer than it lasts
        while browser.text("state") == "Homing":
            assert time.monotonic() < deadline
            time.sleep(0.1)
        browser.until_state("Ready")
        place = lambda: [float(browser.text(f"m-{axis}")) for axis in "xy"]  # noqa: E731
        assert place() == [0, 0]
        browser.fill("goto-x", "5")
        browser.fill("goto-y", "4")
        browser.tap("#goto-form button")
        browser.until(lambda: place() == [5, 4])
        browser.press("x+")
        browser.until(lambda: place()[0] > 7)
        browser.let_go()
        browser.until_state("Ready")
        browser.fill("draw-speed", "700")
        browser.tap("#draw-speed-form button")
        file = tmp_path / "none.svg"
        file.write_text("<svg")
        browser.find("upload").send_keys(str(file))
        browser.until(lambda: "180" in browser.text("message"))
        file = tmp_path / "rectangle.svg"
        file.write_text(SVG, encoding="utf-8")
        browser.find("upload").send_keys(str(file))
        browser.until(lambda: "rectangle.svg.txt" in browser.find("jobs").text)
        browser.choose("jobs", "rectangle.svg.txt")
        browser.until(lambda: "LINE" in browser.text("lines"))
        browser.click("check")
        browser.until(lambda: "no error" in browser.text("job-state"))
        browser.click("run")
        browser.until_state("Running")
        browser.until(lambda: browser.text("drawn") in ("2", "3") and browser.text("pen") == "down")
        browser.shot("plotter-draws")
        browser.until(lambda: "Done" in browser.text("job-state"))
        browser.until_state("Ready")
        assert browser.text("pen") == "up"
        end = place()
        played(browser, "step_back")
        browser.until(lambda: place() != end)
        played(browser, "back")
        browser.until(lambda: "line 1, 1 of" in browser.text("job-state") and not browser.css("#card-plotter [data-play=back]").is_enabled())
        start = place()
        browser.click("single")
        browser.until(lambda: "line 2, 2 of" in browser.text("job-state") and "step by step" in browser.text("job-state"))
        assert place() != start
        browser.shot("plotter-step")
        played(browser, "run")
        browser.until(lambda: "Done" in browser.text("job-state"))
        browser.until(lambda: place() == end)
        browser.click("run")
        browser.until(lambda: browser.text("drawn") in ("1", "2", "3") and browser.text("state") == "Running")
        browser.click("stop")
        browser.until(lambda: "Ended" in browser.text("job-state"))
        browser.until_state("Ready")
        browser.type("draw-speed", "800")
        browser.tap("#points-card summary")
        browser.click("points-click")
        browser.click("points-click")
        browser.type("points", "1,1 2,2")
        browser.click("points-next")
        browser.tap("#points-form .go")
        browser.until(lambda: "points.txt" in browser.find("jobs").text)
        assert not browser.unused("card-plotter")
        assert not [row for row in browser.driver.get_log("browser") if "SyntaxError" in row["message"] or "Uncaught" in row["message"]]
    walked = [row[:2] for row in steps(panel)]
    assert not [corner for corner in ((100, 200), (300, 200), (300, 300), (100, 300)) if corner not in walked]


def test_each_language_by_the_machine_chooser(tmp_path, driver):
    """The page becomes that of each machine in turn: its cards, and one motion; the parts that the language lacks are hidden."""
    with PanelProcess(tmp_path, "--board", "two_motor_kit") as panel:
        browser = Browser(panel, driver, (1280, 1800))
        browser.until_state("Ready")
        assert not [name for name in ("card-place", "card-job", "card-path", "card-line") if browser.find(name).is_displayed()]
        browser.tap("[data-motor='1 on']")
        browser.until(lambda: "250 steps/s" in browser.text("motor-1") and browser.text("state") == "Running")
        browser.tap("[data-motor='1 reverse']")
        browser.until(lambda: browser.text("motor-1").startswith("anticlockwise"))
        browser.fill("speed-2", "4")
        browser.tap("[data-motor='2 speed']")
        browser.press("y+")
        browser.until(lambda: "62.5 steps/s" in browser.text("motor-2"))
        browser.let_go()
        browser.until(lambda: browser.text("motor-2") == "off")
        browser.tap("[data-motor='0 off']")
        browser.until_state("Ready")
        for board, card, button in (("lpt_router", "card-program", "[data-way='z+']"), ("torch_manipulator", "card-torch", "[data-switch=motors_on]"),
                                    ("plotter_2014", "card-plotter", "[data-way='x+']")):  # fmt: skip
            browser.choose("machines", board)
            browser.click("machine")
            browser.answer()
            browser.until(lambda: browser.find(card).is_displayed() and not browser.find("card-keys").is_displayed())
            browser.until_state("Ready")
            step_of(browser, 1)
            browser.tap(button)
            shown = {"[data-way='z+']": ("m-z", "1.000"), "[data-way='x+']": ("m-x", "1.000")}.get(button)
            browser.until(lambda: browser.text(shown[0]) == shown[1] if shown else browser.css("[data-shows=ours]").text == "on")
        assert not [row for row in browser.driver.get_log("browser") if "SyntaxError" in row["message"] or "Uncaught" in row["message"]]


@pytest.mark.slow
@pytest.mark.parametrize("board", ["lpt_router", "torch_manipulator", "plotter_2014", "two_motor_kit"])
@pytest.mark.parametrize("size, language, theme", [((1280, 1700), "en", "light"), ((390, 4200), "pt", "dark")])
def test_pictures(tmp_path, driver, axe, board,  # noqa: F811
                   size, language, theme):
    """No card is wider than the window, in either language; axe-core finds no serious fault."""
    with PanelProcess(tmp_path, "--board", board) as panel:
        browser = Browser(panel, driver, size, f"lang={language}&theme={theme}")
        time.sleep(0.5)
        browser.shot(f"{board}-{language}-{size[0]}")
        assert browser.driver.execute_script("return document.documentElement.scrollWidth - window.innerWidth") <= 0
        assert not faults_found(browser, axe)
        english = browser.driver.execute_script("return [...document.querySelectorAll('section:not([hidden]) h2')].map((each) => each.textContent)")
        assert ("Mover" in english) == (language == "pt")

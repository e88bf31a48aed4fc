"""A user's tasks on the page, from nothing to the end, with the taps counted: in Chromium and Firefox, on a phone and a desktop, in English and Portuguese. A
tap is a press of a control; swiping down to it is none.

Firefox is driven by its own port (marionette.py); without it its walks skip. PASSO_SHOTS=FOLDER keeps pictures.
"""

import os
import signal
import subprocess
import time

import pytest
from marionette import FIREFOX, firefox
from test_panel_page import CHROMIUM, DRIVER, Browser, chromium

from host_tools import boards, interpreter
from panel_process import PanelProcess

pytestmark = [pytest.mark.slow, pytest.mark.unmeasured, pytest.mark.xdist_group("panel")]
REST_S = 120  # homing a plotter of 2014
JOB_S = 300  # some 20 s at rest
SIZES = {"phone": (360, 640), "desktop": (1366, 768)}
SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40">'
    '<path d="M5 5 L55 5 L55 35 L5 35 Z M15 12 C25 2 35 32 45 12" fill="none" stroke="black"/></svg>'
)
ENGRAVING = "G21 G90 G54\nM4 S0\nG1 F6000\n" + "".join(
    f"G0 X{2 if row % 2 else 12} Y{row / 2}\nG1 X{12 if row % 2 else 2} S{200 + 40 * row}\nS0\n" for row in range(12)) + "M5\nG0 X0 Y0\nM2\n"
POCKET = "G21 G90 G54\nF6000\nM3 S5000\nG0 Z0\nG0 X2 Y2\nG1 Z-2\n" + "".join(f"X20\nY{2.5 + row / 2}\nX2\nY{3 + row / 2}\n" for row in range(0, 40, 2)) + "G0 Z0\nM5\nM30\n"
OF_TWO_TOOLS = (
    "G21 G90 G54\nT1 M6\nM3 S5000\nF6000\nG0 Z5\nG0 X2 Y2\nG1 Z-2\n" + "".join(f"X20\nY{3 + 2 * row}\nX2\nY{4 + 2 * row}\n" for row in range(9))
    + "G0 Z5\nM5\nT2 M6\nM3 S8000\nG0 X2 Y2\nG1 Z-3\nX20\nY20\nX2\nY2\nG0 Z5\nM5\nM30\n")
PLATE_MM, CORNER_MM, TOP_MM = (180, 125, -24), (120, 80), -40  # on the virtual table of --stock: above the plate, of the pocket, of the piece
ERRORS = "window.wrong = []; addEventListener('error', (event) => window.wrong.push(event.message));"


class Hand(Browser):
    """The user's finger: a control behind a tab or in a folded card takes one tap more."""

    def __init__(self, panel, driver, size, language):
        self.taps = 0
        if driver.name != "firefox":  # which counts its own frame
            screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size == SIZES["phone"]}
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        super().__init__(panel, driver, size, query=f"lang={language}&theme=light")
        self.driver.execute_script(ERRORS)

    def _press(self, element):
        self.taps += 1
        self.bring(element).click()

    def reach(self, element):
        """The control is on the page's part that is shown."""
        folded, tab = self.driver.execute_script(
            "const at = arguments[0], card = at.closest('details:not([open])'), pane = at.closest('.pane[hidden]');"
            "return [card && at.tagName !== 'SUMMARY' ? card.querySelector('summary') : null,"
            " pane ? document.querySelector(`[data-tab=${pane.dataset.of || pane.id.slice(5)}]`) : null]", element)
        for each in (tab, folded):
            if each:
                self._press(each)
        return element

    def touch(self, name):
        element = self.find(name) if name.isidentifier() or "-" in name and " " not in name and name[0] not in "#[" else self.css(name)
        self.reach(element)
        self.until(element.is_enabled)
        self._press(element)

    def put(self, path):
        """A file: the button of the page, and the file in the list of the device."""
        element = self.find("upload")
        self.reach(element)
        self.taps += 2
        element.send_keys(str(path))
        self.until(lambda: self.driver.execute_script("return document.getElementById('jobs').value") in (path.name, path.name + ".txt"))

    def state(self):
        return self.driver.execute_script("return document.getElementById('state').dataset.state")

    def place_of(self, axis):
        return float(self.driver.execute_script("return document.getElementById(arguments[0]).textContent", f"w-{axis}"))

    def rest(self):
        deadline = time.monotonic() + REST_S
        while self.state() != "Idle":
            assert time.monotonic() < deadline, (self.state(), self.text("message"))
            time.sleep(0.1)

    def type(self, name, text):
        """A number into a field: one tap, and the keyboard of the device."""
        element = self.reach(self.find(name))
        self.taps += 1
        self.driver.execute_script("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('change', {bubbles: true}))", element, str(text))

    def go(self, **places):
        """By the form, in work coordinates."""
        for axis, place in places.items():
            self.type(f"goto-{axis}", place)
        self.touch("#goto-form button")
        deadline = time.monotonic() + REST_S
        while any(abs(self.place_of(axis) - place) >= 0.006 for axis, place in places.items()):
            assert time.monotonic() < deadline, (self.state(), self.text("message"))
            time.sleep(0.1)
        self.rest()

    def show(self, name):
        """A picture, if they are kept; and nothing is wider than the screen, nothing has failed."""
        assert not self.driver.execute_script(WIDER), name
        assert not self.driver.execute_script("return window.wrong")
        self.shot(name)


WIDER = """
const wide = document.documentElement.scrollWidth > innerWidth;
return wide ? [...document.querySelectorAll("body *")].filter((e) => e.getBoundingClientRect().right > innerWidth + 0.5).map((e) => e.outerHTML.slice(0, 80)) : [];
"""
FOUND = "return /^(Done|Pronto)/.test(document.querySelector('#card-setup .progress').textContent)"
BROWSERS = {"chromium": bool(CHROMIUM and DRIVER), "firefox": bool(FIREFOX)}


@pytest.fixture(scope="module", params=BROWSERS)
def driver(request, tmp_path_factory):
    if not BROWSERS[request.param]:
        pytest.skip(f"NO {request.param.upper()}: apt-get install chromium chromium-driver firefox-esr, to test the page")
    opened = chromium() if request.param == "chromium" else firefox(tmp_path_factory.mktemp("firefox"))
    opened.named = request.param
    yield opened
    opened.quit()


@pytest.fixture(params=[(size, language) for size in SIZES for language in ("en", "pt")], ids=lambda found: "-".join(found))
def hand(request, driver):
    """hand(panel): a page of that size and language."""
    size, language = request.param

    def opened(panel):
        made = Hand(panel, driver, SIZES[size], language)
        made.name = f"{driver.named}-{size}-{language}"
        made.small = size == "phone"
        return made

    return opened


def done(panel, page):
    """Until the job has been done, which the panel tells in no language."""
    client, deadline = panel.page(), time.monotonic() + JOB_S
    while not client.state.get("job") or client.state["job"]["how"] != "done":
        assert time.monotonic() < deadline, client.state
        client.hear()
    page.rest()


def test_from_nothing_to_a_drawing(hand, tmp_path, show):
    (tmp_path / "map.svg").write_text(SVG)
    with PanelProcess(tmp_path, "--board", "plotter_2014") as panel:
        page = hand(panel)
        page.rest()
        page.touch("home")
        page.until(lambda: page.state() == "Home")
        page.rest()
        page.put(tmp_path / "map.svg")
        page.show(f"plotter-placed-{page.name}")
        page.touch("run")
        page.until(lambda: page.state() == "Run")
        page.show(f"plotter-draws-{page.name}")
        done(panel, page)
        page.show(f"plotter-done-{page.name}")
        assert ("meio passo" if page.name.endswith("pt") else "half step") in page.find("draw-speed-unit").get_attribute("textContent")
        words = (panel.jobs / "plotter" / "map.svg.txt").read_text()
        show("taps", f"a drawing, {page.name}: {page.taps}")
        assert page.taps <= (5 if page.small else 4)
    points = {tuple(map(int, row.split()[1:])) for row in words.splitlines() if row.startswith("LINE")}
    passed = {(row[1] + by[0], row[2] + by[1]) for row in panel.trace() for by in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))}  # axes share no tick
    assert len(points) > 20 and points <= passed


def begin(page, file):
    """Unlock if need be, set zero where the tool stands, and run the file."""
    if page.state() == "Alarm":
        page.touch("unlock")
    page.rest()
    page.touch("zero-all")
    page.touch("ask-yes")
    page.put(file)
    page.touch("run")


def test_an_engraving(hand, tmp_path, show):
    """The zero is set where the work lies; lines of rising power, the beam off between them."""
    (tmp_path / "lines.gcode").write_text(ENGRAVING)
    board = boards.load("laser_xy")
    with PanelProcess(tmp_path, "--board", "laser_xy") as panel:
        page = hand(panel)
        begin(page, tmp_path / "lines.gcode")
        page.until(lambda: page.state() == "Run")
        page.show(f"engraving-{page.name}")
        done(panel, page)
        page.show(f"engraved-{page.name}")
        show("taps", f"an engraving, {page.name}: {page.taps}")
        assert page.taps <= (8 if page.small else 6)
    scale = board["axes"][0]["steps_per_m"] / 1000
    rows = panel.trace()
    start = rows[0][1:3]
    ends = {(round(start[0] + x * scale), round(start[1] + row / 2 * scale)) for row in range(12) for x in (2, 12)}
    assert len(ends - {row[1:3] for row in rows}) == 0


def test_a_pocket_with_touch_plate_and_tool_change(hand, tmp_path, show):
    """Homed, Z found by the plate on the piece, X and Y set where the pocket begins; the bar asks for each of two tools."""
    (tmp_path / "pocket.gcode").write_text(OF_TWO_TOOLS)
    with PanelProcess(tmp_path, "--board", "router_3axis") as panel:
        page = hand(panel)
        page.until(lambda: page.state() in ("Alarm", "Idle"))
        page.touch("home")
        page.until(lambda: page.state() == "Home")
        page.rest()
        page.go(**dict(zip("xyz", PLATE_MM)))
        page.reach(page.find("card-setup"))
        if not page.css("#card-setup details").get_attribute("open"):
            page.touch("#card-setup summary")
        page.until(lambda: page.driver.find_elements("css selector", "#setup-plate"))
        page.touch("setup-plate")
        page.until(lambda: page.find("wizard-plate").is_enabled())
        page.show(f"pocket-plate-{page.name}")
        page.touch("wizard-plate")
        page.touch("ask-yes")
        deadline = time.monotonic() + REST_S
        while not page.driver.execute_script(FOUND):
            assert time.monotonic() < deadline
            time.sleep(0.1)
        page.rest()
        page.show(f"pocket-found-{page.name}")
        page.go(z=10)
        page.go(**dict(zip("xy", CORNER_MM)))
        for number in (1, 2):
            page.touch(f"#places tr:nth-child({number}) button")
        page.until(lambda: [page.place_of(axis) for axis in "xy"] == [0, 0])
        page.put(tmp_path / "pocket.gcode")
        page.touch("run")
        for tool in "12":
            page.until(lambda tool=tool: f"T{tool}" in page.text("wait-text") or f" {tool}" in page.text("wait-text"))
            page.show(f"pocket-tool-{tool}-{page.name}")
            page.touch("wait-go")
        page.until(lambda: page.state() == "Run" and page.place_of("y") > 4)
        page.show(f"pocket-{page.name}")
        done(panel, page)
        page.show(f"pocket-done-{page.name}")
        show("taps", f"a pocket, {page.name}: {page.taps}")
        assert page.taps <= (26 if page.small else 21)
        assert [page.place_of(axis) for axis in "xyz"] == [2, 2, 5]


def test_a_crash_and_its_recovery(hand, tmp_path, show):
    """The PC's program is killed amid the job: the board comes to its stand; a new page offers it, asks, and goes on."""
    (tmp_path / "pocket.gcode").write_text(POCKET)
    board = {**boards.load("router_3axis"), "journal": {"every_ms": 500}}
    (tmp_path / "board.py").write_text(f'"""A router with a journal."""\n\nBOARD = {board!r}\n')
    words = [*interpreter.passo(), "board", "--board", str(tmp_path / "board.py"), "--link", str(tmp_path / "machine"), "--trace", str(tmp_path / "steps.csv")]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        process.stdout.readline()
        port = ("--port", str(tmp_path / "machine"))
        first = PanelProcess(tmp_path, *port)
        page = hand(first)
        page.until(lambda: page.state() in ("Alarm", "Idle"))
        begin(page, tmp_path / "pocket.gcode")
        page.until(lambda: page.place_of("y") > 4)
        before = page.taps
        first._process.send_signal(signal.SIGKILL)
        first._process.wait()
        first._process.stdout.close()
        time.sleep(4)  # the board gives its host up after three seconds, and comes to its stand
        with PanelProcess(tmp_path, *port) as panel:
            page = hand(panel)
            page.until(lambda: page.state() in ("Alarm", "Idle"))
            page.until(lambda: page.driver.execute_script("return !document.getElementById('recover-row').hidden"))
            if page.state() == "Alarm":
                page.touch("unlock")
            if page.driver.execute_script("return !document.getElementById('recover-doubt').hidden"):
                page.touch("recover-sure")
            page.show(f"crash-{page.name}")
            page.touch("recover-begin")
            page.until(lambda: not page.driver.execute_script("return document.getElementById('recover-down').hidden"))
            page.rest()
            page.show(f"crash-over-{page.name}")
            page.touch("recover-down")
            page.until(lambda: page.driver.execute_script("return document.getElementById('recover-row').hidden"))
            done(panel, page)
            show("taps", f"a crash, {page.name}: {before} to the crash, {page.taps} from there")
            assert page.taps <= (5 if page.small else 4)
            assert [page.place_of(axis) for axis in "xyz"] == [2, 22, 0]
    finally:
        os.kill(process.pid, signal.SIGTERM)
        process.wait(30)
        process.stdout.close()

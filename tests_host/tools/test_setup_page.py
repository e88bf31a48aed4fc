"""The set-up on the page, in Chromium: wizards find the piece on the virtual machine's table, STOP and refusals hold, and it looks as it should.

The piece is that of host_tools/sim/stock.py; the tool has a diameter of 6 mm. PASSO_SHOTS=FOLDER keeps pictures.
"""

import re
import time

import pytest
from test_panel_page import BRING, Browser, axe, driver, pytestmark as of_pages, faults_found, within_two_screens  # noqa: F401

from panel_process import PanelProcess

pytestmark = [*of_pages, pytest.mark.slow]
WIZARD_S = 150
PHONE, DESKTOP = (360, 640), (1366, 768)
QUICK = {"fast": 300, "slow": 20, "travel": 1500, "back": 0.6}
# key: the other fields, the tool's machine coordinates, and G54 afterwards: None, the axis stays
FOUND = {
    "corner": ({"inset": 8}, (108.5, 67, -36), (100.0, 60.0, -40.0)),
    "hole": ({}, (148, 101, -44), (150.0, 100.0, None)),
    "boss": ({}, (239, 101.5, -41), (240.0, 100.0, None)),
    "plate": ({}, (180, 125, -24), (None, None, -40.0)),
}
OTHER_CORNERS = {"fr": ((192, 67, -36), (200.0, 60.0, -40.0)), "bl": ((108, 132, -36), (100.0, 140.0, -40.0)), "br": ((192, 110, -36), None)}


class SetUp(Browser):
    def __init__(self, panel, driver, **how):
        self.panel = panel
        super().__init__(panel, driver, **how)
        self.until(lambda: self.driver.find_elements("id", "setup-corner"))

    def open(self, key):
        if self.driver.find_elements("id", "setup-back"):
            self.click("setup-back")
        if not self.css("#card-setup details").get_attribute("open"):
            self.tap("#card-setup summary")
        self.click(f"setup-{key}")

    def set(self, key, fields):
        for name, value in fields.items():
            found = self.driver.find_elements("id", f"setup-{key}-{name}")
            if found:
                self.driver.execute_script("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('change'))", found[0], str(value))

    def wizard(self, key, fields, sure=True):
        """Begin a wizard."""
        self.open(key)
        self.set(key, {**QUICK, **fields})
        self.click(f"wizard-{key}")
        self.answer(sure)

    def told(self):
        return self.css(".progress").text

    def ended(self):
        deadline = time.monotonic() + WIZARD_S
        while not self.told().startswith(("Done", "Ended", "The dry run")):
            assert time.monotonic() < deadline, self.told()
            time.sleep(0.05)
        return self.told()


def page_of(panel):
    page = panel.page()
    page.until(lambda state: state["link"])
    return page


def said(panel, line, start):
    """Send a line from a page; return the numbers of the board's line in brackets that begins with `start`."""
    page = page_of(panel)
    assert page.order("line", line=line)["error"] == 0
    while True:
        text = page.said("said")["text"]
        if text.startswith(start):
            page.socket.close()
            return [float(part) for part in re.split("[,:]", text[len(start) : -1])]


def stand(panel, x, y, z):
    """Go there by the top."""
    page = page_of(panel)
    page.until(lambda state: state["state"] == "Idle")
    for line in ("G21G90G53G0Z0", f"G53G0X{x}Y{y}", f"G53G0Z{z}"):
        while page.order("line", line=line)["error"]:  # the one before is still under way
            time.sleep(0.05)
        page.until(lambda state: state["state"] == "Run" or line[-2:] == "Z0")
        page.until(lambda state: state["state"] == "Idle")
    page.until(lambda state: [round(value, 2) for value in state["m"]] == [x, y, z])
    page.socket.close()


def home(panel):
    page = page_of(panel)
    page.order("home")
    page.until(lambda state: state["state"] == "Home")
    deadline = time.monotonic() + WIZARD_S
    while page.state["state"] != "Idle":
        assert time.monotonic() < deadline, page.state
        page.hear()
    page.socket.close()


@pytest.fixture(scope="module")
def panel(tmp_path_factory):
    with PanelProcess(tmp_path_factory.mktemp("setup"), "--board", "router_3axis") as process:
        yield process


@pytest.fixture(scope="module")
def homed(panel):
    home(panel)
    return panel


def test_nothing_is_sought_before_the_machine_is_homed(panel, driver):
    with SetUp(panel, driver) as page:
        page.open("plate")
        assert not page.find("wizard-plate").is_enabled()
        page.click("unlock")
        page.until_state("Ready")
        page.until(lambda: "not homed" in page.css(".reason").text)
        assert not page.find("wizard-plate").is_enabled()


@pytest.mark.parametrize("key", FOUND)
def test_a_wizard_finds_the_work(homed, driver, key, show):
    fields, place, wanted = FOUND[key]
    with SetUp(homed, driver) as page:
        stand(homed, *place)
        page.wizard(key, fields)
        assert page.ended() == "Done."
        page.shot(f"setup-{key}-done")
        found = said(homed, "$#", "[G54:")
        show(f"{key} found", str(found))
        assert all(abs(is_ - was) < 0.006 for is_, was in zip(found, wanted) if was is not None), found


@pytest.mark.parametrize("corner", ["fr", "bl"])
def test_other_corners(homed, driver, corner):
    place, wanted = OTHER_CORNERS[corner]
    with SetUp(homed, driver) as page:
        stand(homed, *place)
        page.wizard("corner", {"inset": 8, "corner": corner})
        assert page.ended() == "Done."
        found = said(homed, "$#", "[G54:")
        assert all(abs(is_ - was) < 0.006 for is_, was in zip(found, wanted)), found
        page.set("corner", {"corner": "fl"})


def test_the_length_of_a_tool_is_stored_and_used(homed, driver):
    with SetUp(homed, driver) as page:
        stand(homed, 180, 125, -24)
        page.wizard("tool", {"number": 3})
        assert page.ended() == "Done."
        assert abs(said(homed, "$#", "[T3:")[0] - (80 - 28)) < 0.006, "the plate is 28 mm below the top of Z, which goes 80 mm down"
        assert abs(said(homed, "$#", "[TLO:")[0] - 52) < 0.006
        page_of(homed).order("line", line="G49")


def test_stop_ends_a_wizard_and_leaves_the_zeros(homed, driver):
    before = said(homed, "$#", "[G54:")
    with SetUp(homed, driver) as page:
        stand(homed, 108, 67, -36)
        page.wizard("corner", {"inset": 8})
        page.until(lambda: "Step 6" in page.told() or "Step 7" in page.told())
        page.click("stop")
        assert "Stopped" in page.ended()
        page.until(lambda: page.text("state") in ("Alarm", "Ready"))
        time.sleep(0.5)
        place = page.place()
        time.sleep(1)
        assert page.place() == place
        after = said(homed, "$#", "[G54:")
        assert after[:2] == before[:2], "X and Y had not been found"
        if page.text("state") == "Alarm":
            page.until(lambda: page.css(".reason").text)
            assert not page.find("wizard-corner").is_enabled()
    home(homed)


def test_what_is_in_the_way_ends_it(homed, driver):
    """The tool is to go down beside the work, but the work is there: it is longer than said."""
    with SetUp(homed, driver) as page:
        stand(homed, 130, 67, -36)
        page.wizard("corner", {"inset": 8, "over": 6})
        assert "in the way" in page.ended()
        page.until_state("Ready")


def test_a_closed_probe_is_refused_and_a_dry_run_touches_nothing(homed, driver):
    with SetUp(homed, driver) as page:
        stand(homed, 170, 130, -28.5)  # on the plate
        page.open("boss")
        page.until(lambda: "closed already" in page.css(".reason").text)
        assert not page.find("wizard-boss").is_enabled()
        page.shot("setup-closed")
        stand(homed, 240, 100, -41)
        page.until(lambda: page.find("wizard-boss").is_enabled() and "seen closed" in page.css(".lamp").text)
        before, seen = page.place(), []
        page.tap(".scene + p button:last-child")
        page.answer()
        while not page.told().startswith(("The dry run", "Ended")):
            seen.append(page.place())
        assert page.told() == "The dry run has ended." and page.place() == before
        assert max(z for _, _, z in seen) >= -21.1 and min(z for _, _, z in seen) >= -41.001
        assert max(x for x, _, _ in seen) > 255 and min(y for _, y, _ in seen) < 85


def test_offsets_are_named_chosen_zeroed_and_gone_to(homed, driver):
    with SetUp(homed, driver) as page:
        stand(homed, 50, 40, -10)
        page.open("offsets")
        name = page.css("[aria-label='Name of G55']")
        name.send_keys("Vice")
        page.until(lambda: page.css(".offset:nth-child(2) .system").is_enabled())
        page.tap(".offset:nth-child(2) .system")
        page.until(lambda: page.css(".offset:nth-child(2) .system").get_attribute("aria-pressed") == "true")
        page.until(lambda: page.css(".zeros button:last-child").is_enabled())
        page.tap(".zeros button:last-child")
        page.answer()
        page.until(lambda: page.css(".offset:nth-child(2) .at").text == "X 50.00  Y 40.00  Z -10.00")
        stand(homed, 20, 20, -20)
        page.until(lambda: page.find("offset-go").is_enabled())
        page.click("offset-go")
        page.answer()
        page.until(lambda: page.place() == [50, 40, 0])
        page.until(lambda: page.find("offset-down").is_enabled())
        page.click("offset-down")
        page.answer()
        page.until(lambda: page.place() == [50, 40, -10])
        page.driver.refresh()
        page.until(lambda: page.driver.find_elements("id", "setup-offsets"))
        page.open("offsets")
        assert page.css("[aria-label='Name of G55']").get_attribute("value") == "Vice"
        page.until(lambda: page.css(".offset:nth-child(1) .system").is_enabled())
        page.tap(".offset:nth-child(1) .system")
        page.until(lambda: page.css(".offset:nth-child(1) .system").get_attribute("aria-pressed") == "true")


@pytest.mark.parametrize("language", ["en", "pt"])
@pytest.mark.parametrize("size", [PHONE, DESKTOP])
def test_each_part_fits_and_axe_finds_nothing(homed, driver, axe, size, language):
    with SetUp(homed, driver, size=(1366, 768), query=f"lang={language}&theme=light") as page:
        screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size[0] < 600}
        for key in [each.get_attribute("id")[6:] for each in page.driver.find_elements("css selector", "#setup .tile")]:
            page.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
            page.open(key)
            time.sleep(0.6)
            page.shot(f"setup-{key}-{language}-{size[0]}")
            faults = faults_found(page, axe)
            assert not faults, (key, faults)
            page.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
            page.until(lambda: page.driver.execute_script("return innerWidth") > 600)  # its own screen is that of within_two_screens()
            within_two_screens(page, size)

"""Jobs on the page in a real browser: begun at a line, one behind the other, chosen by their pictures, dropped on it."""

import time

import pytest
from test_panel_page import BRING, Browser, browser, driver, pytestmark as of_pages  # noqa: F401

from host_tools import boards
from panel_process import PanelProcess

pytestmark = of_pages
POCKET = "G21 G90 G54\nF1500\nM3 S5000\nG0 Z0\nG0 X2 Y2\nG1 Z-2\nX10\nY8\nX2\nY2\nG0 Z0\nM5\nM30\n"
DROP = """
const data = new DataTransfer();
for (const [name, text] of arguments[0]) data.items.add(new File([text], name));
document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
"""


@pytest.fixture(scope="module")
def panel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("panel")
    with PanelProcess(folder) as process:
        yield process


def drop(browser, **files):
    browser.driver.execute_script(DROP, [[f"{name}.gcode", text] for name, text in files.items()])
    last = list(files)[-1]
    browser.until(lambda: f"{last}.gcode" in browser.text("run") and browser.find("run").is_enabled())
    browser.until(lambda: files[last].split("\n")[0] in browser.text("lines") and browser.text("job-facts"))


def test_a_line_is_begun_at(browser):
    """A touch on a line fills the field; the page lists the restored state before anything moves, and asks before the tool goes down."""
    browser.click("zero-all")
    browser.answer()
    drop(browser, pocket=POCKET)
    browser.tap("#lines span:nth-child(8)")
    assert browser.find("from-line").get_attribute("value") == "8"
    before = browser.place()
    browser.tap("#from-form button")
    browser.until(lambda: "Restored: G54, mm, absolute, feed 1500 mm/min." in browser.text("recover-text"))
    told = browser.text("recover-text")
    assert "pocket.gcode, from line 8." in told and "over X 10.00 Y 2.00 mm; spindle 5000 rpm; then you are asked, and it goes down to Z -2.00 mm." in told
    assert browser.text("h-recover") == "Begin at a line" and not browser.find("recover-begin").is_enabled()
    assert not browser.find("recover-drop").is_displayed() and browser.place() == before
    browser.shot("from-line")
    browser.click("recover-sure")
    browser.click("recover-begin")
    browser.until(lambda: "Next: " in browser.text("recover-text"))
    assert browser.text("w-x") == "10.000" and browser.text("w-y") == "2.000"
    browser.shot("from-line-over")
    browser.click("recover-down")
    browser.until(lambda: not browser.find("recover-row").is_displayed())
    browser.until(lambda: "pocket.gcode: Done, line 13" in browser.text("job-state"))
    assert [browser.text(f"w-{axis}") for axis in "xyz"] == ["2.000", "2.000", "0.000"]


CARD = """
const done = arguments[arguments.length - 1];
Promise.all([import("./recover.js"), import("./controls.js")]).then(([{Recover}, {nameTool}]) => {
  const card = Object.create(Recover.prototype), offer = {name: "A", line: 3, known: true};
  const told = [{32: "1", 30: "1000"}, {32: "0", 30: "24000"}].map((settings) => { nameTool(settings); return [card.stopped(offer, false), card.stopped(offer, true)]; });
  done(told);
});
"""


def test_a_laser_s_card_speaks_of_no_spindle(browser):
    laser, router = browser.driver.execute_async_script(CARD)
    assert laser[0] == "A stopped in line 3, laser off. It can go on there: over the place with the laser off, then you are asked."
    assert laser[1].startswith("A stopped in line 3, the laser is on.")
    assert router[0].startswith("A stopped in line 3, spindle off. It can go on there: tool up,")


def test_a_line_that_is_left_moves_nothing(browser):
    drop(browser, left=POCKET)
    before = browser.place()
    browser.fill("from-line", "9")
    browser.tap("#from-form button")
    browser.until(lambda: browser.find("recover-row").is_displayed())
    browser.click("recover-forget")
    browser.until(lambda: not browser.find("recover-row").is_displayed())
    browser.fill("from-line", "99")
    browser.tap("#from-form button")
    browser.until(lambda: "ends before line 99" in browser.text("message"))
    assert browser.place() == before


def queue(browser, *names):
    for name in names:
        browser.choose("jobs", f"{name}.gcode")
        browser.click("queue-add")
        browser.until(lambda name=name: f"{name}.gcode" in browser.text("queue"))


def test_jobs_wait_for_one_another(browser):
    """The next begins by itself; behind a change of tools it is asked for, and the bar's button goes on."""
    drop(browser, a="G21 G91\nG1 X1 F1000\n", b="G21 G91\nG1 Y1 F1000\n", c="G21 G91\nT3 M6\nG1 X-1 F1000\n")
    browser.tap("#queue-row summary")
    queue(browser, "c", "a", "b")
    browser.tap("#queue li:nth-child(1) [aria-label='c.gcode: later']")
    browser.until(lambda: browser.text("queue").startswith("a.gcode"))
    browser.tap("#queue li:nth-child(3) [aria-label='b.gcode: earlier']")
    browser.until(lambda: browser.text("queue").split("\n")[0].startswith("a.gcode") and browser.text("queue").rindex("c.gcode") > browser.text("queue").index("b.gcode"))
    assert browser.text("queue-count") == "(3)"
    browser.shot("queue")
    start = browser.place()
    browser.click("queue-run")
    browser.until(lambda: "Next: c.gcode. Put in tool T3" in browser.text("wait-text"))
    assert [round(now - then, 2) for now, then in zip(browser.place(), start)] == [1, 1, 0]
    browser.shot("queue-waits")
    browser.click("wait-go")
    browser.until(lambda: "Put in tool T3" in browser.text("wait-text") and browser.text("state") == "Held")
    browser.click("wait-go")
    browser.until(lambda: "c.gcode: Done" in browser.text("job-state"))
    browser.until(lambda: browser.text("queue") == "" and browser.text("queue-count") == "")
    queue(browser, "a", "b")
    browser.tap("#queue li:nth-child(2) [aria-label='b.gcode: out of the queue']")
    browser.until(lambda: browser.text("queue-count") == "(1)")
    browser.click("queue-clear")
    browser.until(lambda: browser.text("queue-count") == "")


def test_jobs_are_chosen_by_their_pictures(browser):
    drop(browser, wide="G1 X40 F900\n", high="G1 Y40 F900\n", none="(nothing)\nM5\n")
    browser.tap("#pictures-row summary")
    browser.until(lambda: "wide.gcode" in browser.text("pictures"))
    count = """return Object.fromEntries([...document.querySelectorAll("#pictures button")].map((each) => { const c = each.querySelector("canvas");
      const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; let x = [c.width, 0], y = [c.height, 0];
      for (let n = 3; n < d.length; n += 4) if (d[n]) { const p = (n - 3) / 4; x = [Math.min(x[0], p % c.width), Math.max(x[1], p % c.width)];
        y = [Math.min(y[0], Math.floor(p / c.width)), Math.max(y[1], Math.floor(p / c.width))]; }
      return [each.textContent.split(" ")[0], [x[1] - x[0], y[1] - y[0]]]; }))"""
    browser.until(lambda: browser.driver.execute_script(count)["wide.gcode"][0] > 200)
    sizes = browser.driver.execute_script(count)
    assert sizes["high.gcode"][1] > 140 and sizes["high.gcode"][0] < 9 > sizes["wide.gcode"][1] and sizes["none.gcode"][0] < 0, sizes
    browser.shot("pictures")
    browser.driver.execute_script(BRING, browser.css("#pictures li:last-child button"))
    next(each for each in browser.driver.find_elements("css selector", "#pictures button") if each.text.startswith("high")).click()
    browser.until(lambda: "high.gcode" in browser.text("run"))


def test_several_files_are_dropped_and_what_is_no_job_is_told(browser):
    drop(browser, first="G1 X1 F100\n", second="G1 X2 F100\n")
    assert {"first.gcode", "second.gcode"} <= {row.split(" (")[0] for row in browser.find("jobs").text.split("\n") for row in [row.strip()]}
    browser.driver.execute_script(DROP, [["empty.gcode", ""], ["../../evil.gcode", "G1 X3 F100\n"]])
    browser.until(lambda: "evil.gcode" in browser.text("run"))
    browser.driver.execute_script(DROP, [["second.gcode", "G1 X5 F100\n"]])
    browser.until(lambda: browser.text("ask-text") == "Replace second.gcode?")
    browser.answer(False)
    time.sleep(0.3)
    assert "G1 X5" not in browser.text("lines")


def test_what_the_pc_does_is_not_greyed_there(browser):
    assert not browser.find("elsewhere").is_displayed() and boards.names()


SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">'
    '<path d="M5 5 L35 5 L35 25 Z" fill="none" stroke="black"/></svg>'
)


HPGL = "IN;SP1;PU400,200;PD1400,200,1400,1000,400,200;PU;PU1800,600;CI300;SP0;"


def test_a_drawing_becomes_a_program(browser):
    """HPGL dropped on a router's page: its picture, its lines, and the width that is typed."""
    browser.driver.execute_script(DROP, [["map.plt", HPGL]])
    browser.until(lambda: "map.plt.gcode" in browser.text("run") and browser.find("place-form").is_displayed())
    assert "G0 Z2" in browser.text("lines")
    box = [float(browser.find(f"place-{name}").get_attribute("value")) for name in ("x", "y", "width")]
    assert box == pytest.approx([10, 5, 42.5], abs=0.1)
    browser.shot("hpgl")
    browser.fill("place-width", "85")
    browser.driver.execute_script("document.getElementById('place-width').dispatchEvent(new Event('input'))")
    browser.tap("#place-form .go")
    browser.until(lambda: "X95" in browser.text("lines"))


@pytest.mark.slow
def test_a_drawing_is_placed_with_a_finger(tmp_path, driver):  # noqa: F811
    """Dropped as SVG, carried by a finger on the picture, made larger by a number, and placed: its words are others then."""
    from selenium.webdriver import ActionChains

    with PanelProcess(tmp_path, "--board", "plotter_2014") as panel, Browser(panel, driver) as page:
        page.driver.execute_script(DROP, [["map.svg", SVG], ["not.svg", "<svg>nothing"]])
        page.until(lambda: "Error 180" in page.text("message"))
        page.until(lambda: "map.svg.txt" in page.text("run") and page.find("place-form").is_displayed())
        corner = [float(page.find(f"place-{name}").get_attribute("value")) for name in ("x", "y", "width")]
        assert corner == [5, 5, 30]
        words = (panel.jobs / "plotter" / "map.svg.txt").read_text()
        page.click("place-finger")
        page.driver.execute_script(BRING, page.find("path"))
        ActionChains(page.driver).move_to_element(page.find("path")).click_and_hold().move_by_offset(40, -30).move_by_offset(20, -10).release().perform()
        x, y, width = [float(page.find(f"place-{name}").get_attribute("value")) for name in ("x", "y", "width")]
        assert x > corner[0] + 3 and y > corner[1] + 2 and width == 30
        page.shot("placing")
        assert (panel.jobs / "plotter" / "map.svg.txt").read_text() == words, "nothing is placed yet"
        page.fill("place-width", "60")
        page.driver.execute_script("document.getElementById('place-width').dispatchEvent(new Event('input'))")
        page.tap("#place-form .go")
        page.until(lambda: (panel.jobs / "plotter" / "map.svg.txt").read_text() != words)
        page.until(lambda: page.find("place-finger").get_attribute("aria-pressed") == "false")
        page.until(lambda: [abs(float(page.find(f"place-{name}").get_attribute("value")) - value) < 0.2 for name, value in zip(("x", "y", "width"), (x, y, 60))] == [True] * 3)
        page.shot("placed")


def test_the_page_is_installed_and_loads_without_its_server(tmp_path, driver):  # noqa: F811
    """At 127.0.0.1 a service worker keeps the files; without the panel the page loads, and says that the link is lost."""
    with PanelProcess(tmp_path) as panel, Browser(panel, driver) as page:
        manifest = page.driver.execute_script("return fetch('manifest.json').then((found) => found.json())")
        assert manifest["start_url"] == "./" and manifest["icons"][0]["src"] == "icon.svg"
        page.driver.execute_script("window.ready = false; navigator.serviceWorker.ready.then(() => { window.ready = true; })")
        page.until(lambda: page.driver.execute_script("return window.ready && Boolean(navigator.serviceWorker.controller)"))
        address = panel.address
    driver.get(address + "?lang=pt")
    page.until(lambda: page.text("state") == "Sem ligação" and "caiu" in page.text("message"))
    driver.get("about:blank")

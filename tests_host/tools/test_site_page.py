"""The static site in Chromium, from a plain file server: machines home, draw and stop; the words are those of the golden files.

Needs Debian's chromium and chromedriver (apt-get install chromium chromium-driver) and selenium; without them it skips.
"""

import functools
import http.server
import json
import shutil
import threading
import time

import pytest
from test_site import DRIVER, NODE, order, package  # noqa: F401

from host_tools.site import builder as site

webdriver = pytest.importorskip("selenium.webdriver", reason="there is no selenium: the site was NOT tried in a browser")
CHROMIUM = shutil.which("chromium")
CHROMEDRIVER = shutil.which("chromedriver")
pytestmark = [
    pytest.mark.unmeasured,
    pytest.mark.xdist_group("site"),
    pytest.mark.skipif(
        not (CHROMIUM and CHROMEDRIVER), reason="there is no chromium with its driver: the site was NOT tried in a browser"
    ),
]
PATIENCE_S = 700  # with a machine far slower than this one
STATE = "document.getElementById('state').dataset.state"
AT = "document.getElementById('machine-view').dataset.at"
PACE = "document.getElementById('machine-pace').textContent"
WATCH = """
window.seen = [];
addEventListener("machine", (event) => { if (event.detail.at) seen.push([performance.now(), event.detail.at, event.detail.tool]); });
const job = document.getElementById("job-state");
window.jobs = [];
new MutationObserver(() => jobs.push(job.textContent)).observe(job, { childList: true });
"""
# Digests in a worker of the site; its messages are put into the window.
DIGESTS = """
window.digests = null;
const worker = new Worker("site_digests.js", { type: "module" });
worker.onmessage = (event) => { window.digests = event.data; };
fetch("asked.json").then((answer) => answer.json()).then((asked) => worker.postMessage(asked));
"""


@pytest.fixture(scope="module")
def address(package, tmp_path_factory):  # noqa: F811
    """The site on a plain file server; beside it what site_digests.js needs."""
    folder = tmp_path_factory.mktemp("served") / "site"
    site.build(folder, package)
    shutil.copyfile(DRIVER, folder / DRIVER.name)
    (folder / "asked.json").write_text(json.dumps(order(["square", "relief"])[0]))

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            """Not a test's business."""

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()


class Browser:
    def __init__(self, address, folder):
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1280,1400", f"--user-data-dir={folder}"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(CHROMEDRIVER))
        self.address = address

    def open(self, query):
        self.driver.get(self.address + query)
        self.run(WATCH)

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def until(self, condition):
        """Wait until a JavaScript expression holds."""
        end = time.monotonic() + PATIENCE_S
        while not self.run(f"return {condition}"):
            assert time.monotonic() < end, (condition, self.logged(), self.text("message"))
            time.sleep(0.02)

    def press(self, name):
        """Press a button as soon as it may be."""
        self.until(f"!document.getElementById({name!r}).disabled")
        self.run("document.getElementById(arguments[0]).click()", name)

    def state(self, name):
        self.until(f"{STATE} === {name!r}")

    def text(self, name):
        return self.driver.find_element("id", name).text

    def at(self):
        return [int(part) for part in self.run(f"return {AT}").split()]

    def choose(self, job):
        self.until(f"[...document.getElementById('jobs').options].some((each) => each.value === {job!r})")
        self.run("const jobs = document.getElementById('jobs'); jobs.value = arguments[0]; jobs.onchange()", job)

    def run_job(self):
        """Run the job chosen to its end; return the page's last text about it."""
        self.run("jobs = []; seen = []")
        self.press("run")
        self.until("jobs.some((each) => /: (Done|Ended)/.test(each))")
        return self.run("return jobs[jobs.length - 1]")

    def logged(self):
        return [row["message"] for row in self.driver.get_log("browser")]


@pytest.fixture(scope="module")
def browser(address, tmp_path_factory):
    made = Browser(address, tmp_path_factory.mktemp("chromium"))
    yield made
    made.driver.quit()


@pytest.mark.slow
def test_words_are_the_same_in_a_tab(browser, show):
    browser.open("?lang=en")
    browser.run(DIGESTS)
    browser.until("window.digests")
    told = browser.run("return window.digests")
    golden = order(["square", "relief"])[1]
    assert [line.split() for line in told["lines"]] == list(golden.values())
    words = sum(int(fields[1]) for fields in golden.values())
    show("words per second in Chromium's WebAssembly", f"{words / sum(told['ms']) * 1000:.0f}: the square of 2014 and a relief")


@pytest.mark.slow
def test_a_plotter_draws_the_square_of_2014(browser):
    browser.open("?lang=en&board=plotter_2014")
    browser.state("Idle")
    browser.press("home")
    browser.state("Home")
    browser.state("Idle")
    browser.choose("square.txt")
    assert browser.run_job().startswith("square.txt: Done")
    drawn = [tuple(at) for _, at, tool in browser.run("return seen") if tool]
    assert drawn and browser.at() == [200, 150]
    assert all(200 <= x <= 600 and 150 <= y <= 550 and (x in (200, 600) or y in (150, 550)) for x, y in drawn)
    assert browser.run("return document.getElementById('machine-faults').textContent") == "0"


def stands_after(browser, press, release):
    """Milliseconds from the end of a jog of X at 50 mm/s until the machine stands, and the millimetres that it goes on."""
    browser.run("document.getElementById('jog-speed').value = 3000")
    before = browser.at()[0]
    press()
    browser.until(f"{AT}.split(' ')[0] - {before} > 2000")
    browser.run("seen = seen.slice(-1); window.released = 0")
    browser.run(release)
    browser.until("seen.length > 12 && seen.slice(-8).every((each) => each[1][0] === seen[seen.length - 1][1][0])")
    released, seen = browser.run("return [released, seen]")
    last = seen[-1][1][0]
    first = [at[0] for when, at, _ in seen if when <= released][-1]
    return next(when for when, at, _ in seen if at[0] == last) - released, (last - first) / 320


def test_jog_and_stop_end_at_once(browser, show):
    browser.open("?lang=en")
    browser.press("unlock")
    browser.state("Idle")
    button = "document.querySelector('[data-way=\"x+\"]')"
    down = f"const button = {button}; button.dispatchEvent(new PointerEvent('pointerdown', {{button: 0, pointerId: 1, bubbles: true}}))"
    browser.run("Element.prototype.setPointerCapture = () => {}")  # a pointer that a test made up cannot be captured

    def press():
        browser.until(f"{STATE} === 'Idle'")
        browser.run(down)

    ends = {
        "released": f"released = performance.now(); {button}.dispatchEvent(new PointerEvent('pointerup', {{bubbles: true}}))",
        "focus lost": "released = performance.now(); window.dispatchEvent(new Event('blur'))",
        "STOP": "released = performance.now(); document.getElementById('stop').click()",
    }
    told = {}
    for name, release in ends.items():
        told[name] = stands_after(browser, press, release)
    ramp_mm = 50 * 50 / (2 * 250)
    for name, (_, mm) in told.items():
        # Without a release the lease would end it: 10 mm at 50 mm/s, and the ramp.
        assert mm <= 50 * 0.2 + ramp_mm + 50 * 0.06, name
    browser.state("Alarm")
    assert told["STOP"][1] < ramp_mm
    figures = ", ".join(f"{name}: {ms:.0f} ms, {mm:.1f} mm" for name, (ms, mm) in told.items())
    show("a jog of 50 mm/s in the tab stands after", f"{figures} (the ramp alone: 200 ms, {ramp_mm:.1f} mm)")


def test_what_a_stranger_brings(browser, tmp_path):
    """Files that are no jobs, a job twice, another machine, and the page loaded again."""
    browser.open("?lang=en")
    browser.press("unlock")
    browser.state("Idle")
    picture = tmp_path / "picture.nc"
    picture.write_bytes(bytes(range(256)) * 4)
    browser.driver.find_element("id", "upload").send_keys(str(picture))
    browser.until("document.getElementById('message').textContent.includes('181')")
    odd = tmp_path / "söme (file).nc"
    odd.write_bytes(bytes(range(1, 256)) * 4)
    good = tmp_path / "good.nc"
    good.write_text("G21 G91\nG1 X1 F600\n")
    for file in (odd, good):
        browser.driver.find_element("id", "upload").send_keys(str(file))
        name = "some _file_.nc" if file is odd else "good.nc"
        browser.until(f"document.getElementById('jobs').value === {name!r}")
        for _ in range(2):
            if file is odd:
                browser.press("run")
                browser.until("document.getElementById('message').textContent.includes('184')")
                browser.state("Idle")
                continue
            before = browser.at()[0]
            assert browser.run_job().startswith("good.nc: Done") and browser.at()[0] - before == 320
    browser.run("document.getElementById('machines').value = 'plotter_2014'; document.getElementById('machine').onclick()")
    browser.press("ask-yes")
    browser.until("document.getElementById('machine-view').dataset.board === 'plotter_2014'")
    browser.state("Idle")
    browser.open("?lang=pt&board=nonsense")
    browser.state("Alarm")
    assert browser.text("h-machine") == "A máquina desta aba"
    outside = browser.run("return performance.getEntriesByType('resource').map((each) => each.name)")
    assert outside and all(name.startswith(browser.address) for name in outside)
    assert not [line for line in browser.logged() if "SEVERE" in line or "rror" in line]


@pytest.mark.slow
def test_the_relief_of_the_site(browser, show):
    """The whole of it, as it is sent to visitors: where it cuts is where its program says."""
    browser.open("?lang=en")
    browser.press("home")
    browser.state("Home")
    browser.state("Idle")
    browser.choose("relief.gcode")
    browser.run("window.begun = performance.now()")
    assert browser.run_job().startswith("relief.gcode: Done")
    assert browser.at() == [0, 0, -4000]
    cut = [at for _, at, tool in browser.run("return seen") if tool and at[2] < -12.9 * 400]
    assert len(cut) > 500
    assert all(60 * 320 <= x <= 120 * 320 and 50 * 320 <= y <= 90 * 320 and -19 * 400 <= z for x, y, z in cut)
    wall = browser.run("return (performance.now() - begun) / 1000")
    show("the relief of the site in Chromium", f"{wall:.0f} s; at the end {browser.run(f'return {PACE}')} of real time")

"""A lesson: thirty virtual plotters, as many drawings dropped on the shop's page, people who put paper in, and pictures of the page in Chromium.

    python tests_host/sims/shop_lesson.py FOLDER [MACHINES]

All in real time. Ends with an error unless the page says at the end that each drawing is done, and each machine's last job is drawn in its tile.
"""

import math
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

from machine_page import MachinePage
from selenium import webdriver
from shop_load import MOSQUITTO, free_port

from host_tools import interpreter

AN_AGENT = 5
LIMIT_S = 900
SIZES = (320, 720), (768, 1024), (1920, 1080), (3840, 2160)


def star(number):
    """An SVG of a star with `number` + 5 points."""
    points = number % 12 + 5
    turn = [math.pi * each / points - math.pi / 2 for each in range(2 * points + 1)]
    path = " L".join(f"{30 + (25 if at % 2 == 0 else 12) * math.cos(angle):.2f} {30 + (25 if at % 2 == 0 else 12) * math.sin(angle):.2f}" for at, angle in enumerate(turn))
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60"><path d="M{path}" fill="none" stroke="black"/></svg>'


class Lesson:
    def __init__(self, folder, machines):
        self.folder, self.programs = folder, []
        self.names = [f"p{number:02}" for number in range(1, machines + 1)]
        self.port = free_port()
        (folder / "mosquitto.conf").write_text(f"listener {self.port} 127.0.0.1\nallow_anonymous true\n")
        self.start([MOSQUITTO, "-c", str(folder / "mosquitto.conf")])
        key = folder / "shop.key"
        self.shop = self.said(self.passo("shop", "--shop-key", key, "--book", folder / "book.sqlite", "--http", "0"), r"(http\S+)")
        self.pages = []
        for at in range(0, machines, AN_AGENT):
            words = [word for name in self.names[at : at + AN_AGENT] for word in ("--virtual", f"{name}=corexy_plotter")]
            self.pages.append(self.said(self.passo("agent", *words, "--shop-key", key, "--at-machine", "0", "--page-key", folder / "page.key"), r"page: (\S+)/"))
        self.pages = [MachinePage(address, (folder / "page.key").read_text().strip()) for address in self.pages]

    def start(self, words):
        self.programs.append(subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True))
        return self.programs[-1]

    def passo(self, verb, *words):
        return self.start([*interpreter.passo(), verb, "--broker", f"127.0.0.1:{self.port}", *map(str, words)])

    def said(self, program, pattern):
        for line in program.stdout:
            if found := re.search(pattern, line):
                return found[1]
        raise AssertionError(f"{program.args} says nothing of {pattern}")

    def people(self):
        """Put paper in at each machine that is at rest and has drawn nothing. Returns how many have done so."""
        done = 0
        for page in self.pages:
            for machine in page.machines():
                done += bool(machine["ended"])
                what = {"rest": "" if machine["ended"] else "release", "waits": "go"}.get(machine["how"])
                if what:
                    page.do(machine["name"], what)
        return done

    def close(self):
        for program in reversed(self.programs):
            program.terminate()
        for program in self.programs:
            program.wait(30)
            program.stdout.close()


def wall(folder):
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1920,1200", f"--user-data-dir={folder}/browser"):
        options.add_argument(argument)
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))


def looks(browser, folder):
    """Pictures of the page from a phone to a wall screen, in both languages: nothing is wider than the screen, STOP is in sight."""
    for width, height in SIZES:
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 700}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        for language in ("en", "pt"):
            browser.find_element("css selector", f"#language option[value={language}]").click()
            time.sleep(1)
            browser.execute_script("window.scrollTo(0, 0)")
            browser.save_screenshot(str(folder / f"{width}-{language}.png"))
            seen = browser.execute_script("""const stop = document.getElementById('stop').getBoundingClientRect();
                return [document.documentElement.scrollWidth, stop.left, stop.right, stop.top, stop.bottom]""")
            assert seen[0] <= width and 0 <= seen[1] <= seen[2] <= width and 0 <= seen[3] <= seen[4] <= height, (width, language, seen)
            browser.execute_script("window.scrollTo(0, document.body.scrollHeight)")
            browser.save_screenshot(str(folder / f"{width}-{language}-end.png"))
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    browser.find_element("css selector", "#language option[value=en]").click()
    time.sleep(1)


def main():
    folder, machines = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 30
    folder.mkdir(parents=True)
    begun = time.monotonic()
    lesson = Lesson(folder, machines)
    browser = wall(folder)

    def until(what, seen):
        while not seen():
            assert time.monotonic() - begun < LIMIT_S, (what, browser.find_element("id", "counts").text)
            time.sleep(0.5)
        print(f"{time.monotonic() - begun:.0f} s: {what}", flush=True)

    def counts():
        return browser.find_element("id", "counts").text

    try:
        browser.get(lesson.shop)
        until("all machines are on the wall", lambda: len(browser.find_elements("css selector", ".tile")) == machines)
        browser.find_element("css selector", "#kind option[value=corexy_plotter]").click()
        paths = [folder / f"{name}.svg" for name in lesson.names]
        for number, path in enumerate(paths):
            path.write_text(star(number))
        browser.find_element("id", "file").send_keys("\n".join(map(str, paths)))
        browser.find_element("css selector", "#add button").click()
        until("all are queued", lambda: f"{machines} jobs in the queue" in counts())
        browser.save_screenshot(str(folder / "1-queued.png"))
        until("some draw", lambda: (lesson.people(), browser.save_screenshot(str(folder / "2-drawing.png")))[0] >= machines // 3)
        looks(browser, folder)
        until("all are done", lambda: lesson.people() == machines and f"0 jobs in the queue, {machines} done" in counts())
        time.sleep(2)
        browser.save_screenshot(str(folder / "3-done.png"))
        inked = browser.execute_script("""return [...document.querySelectorAll('.tile')].map((tile) => {
            const canvas = tile.querySelector('canvas'), data = canvas.clientHeight > 50 ? canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data : [];
            return [tile.querySelector('h2').textContent, data.some((value) => value > 0)];
        })""")
        assert all(ink for _name, ink in inked), inked
        assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []
    finally:
        browser.quit()
        lesson.close()


if __name__ == "__main__":
    main()

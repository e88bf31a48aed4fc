"""The torch's small page in a browser: with the key it moves, without it does not, and a held button stops when it is let go.

Needs Debian's chromium and chromedriver (apt-get install chromium chromium-driver) and selenium; without them it skips.
"""

import shutil
import time

import pytest

from test_http import KEY, LIMIT_S, Torch
from titles import WITHOUT

webdriver = pytest.importorskip("selenium.webdriver", reason="there is no selenium: the torch's page was NOT tried in a browser")
CHROMIUM = shutil.which("chromium")
CHROMEDRIVER = shutil.which("chromedriver")
pytestmark = [
    pytest.mark.unmeasured,
    pytest.mark.skipif(
        not (CHROMIUM and CHROMEDRIVER), reason="there is no chromium with its driver: the torch's page was NOT tried in a browser"
    ),
]
ENDS = {
    "released": "button.dispatchEvent(new PointerEvent('pointerup'))",
    "blurred": "window.dispatchEvent(new Event('blur'))",
}


class Page:
    def __init__(self, url, folder, language="pt-BR"):
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        options.add_experimental_option("prefs", {"intl.accept_languages": language})
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=390,844", f"--user-data-dir={folder}"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(CHROMEDRIVER))
        self.driver.get(url)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def text(self, name):
        return self.driver.find_element("id", name).text

    def press(self, path):
        self.driver.execute_script(f"document.querySelector('form[action=\"{path}\"] button').click()")

    def until(self, condition):
        deadline = time.monotonic() + LIMIT_S
        while not condition():
            assert time.monotonic() < deadline, (self.text("answer"), self.driver.get_log("browser"))
            time.sleep(0.02)


def test_the_page(tmp_path):
    with Torch("torch_pico_w") as torch_board:
        with Page(torch_board.url, tmp_path / "stranger") as page:
            page.press("/ON")
            page.until(lambda: "error=178" in page.text("answer"))
            assert page.driver.switch_to.active_element.get_attribute("id") == "key"
        with Page(f"{torch_board.url}/#key={KEY}", tmp_path / "known") as page:
            assert KEY not in page.driver.current_url  # nor in the history, then
            assert "PARAR" in page.text("halt")
            assert not page.driver.execute_script(WITHOUT) and "Para a tocha" in page.driver.execute_script("return document.getElementById('halt').title")
            page.press("/ON")
            page.until(lambda: page.text("answer") == "code=238&state=stopped&error=0")
            page.press("/COMMAND")
            page.until(lambda: page.text("place") == "X 1.00 Y 1.00 mm")
            for name, end in ENDS.items():
                before = torch_board.settled()["px"]
                page.driver.execute_script(
                    "window.button = document.querySelector('form[action=\"/JOGX+\"] button');"
                    "button.dispatchEvent(new PointerEvent('pointerdown'))"
                )
                page.until(lambda before=before: torch_board.info()["px"] > before + 100)  # more than two jogs
                page.driver.execute_script(end)
                held = torch_board.info()["px"]
                after = torch_board.settled()["px"]
                # 480 steps/s for 100 ms ahead, one jog of 48 steps, and a request that was on its way
                assert after - held <= 2 * 48 + 48, name
            assert page.driver.get_log("browser") == []
        with Page(torch_board.url, tmp_path / "english", "en-US") as page:
            assert "STOP" in page.text("halt")

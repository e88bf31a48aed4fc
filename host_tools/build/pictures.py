"""Makes the pictures of the documents anew: wiring drawings in both languages, and README's picture of the page.

    python -m host_tools.build.pictures           # the drawings of docs/start/machines and docs/pt/machines
    python -m host_tools.build.pictures --page    # docs/start/page.png too: by Chromium, selenium and Pillow

tests_host/rules/test_guides.py fails while a drawing is not that of its board file.
"""

import re
import shutil
import subprocess
import sys
import tempfile
import time

from host_tools import boards, interpreter, language
from host_tools.resources import ROOT

DOCS = ROOT / "docs"
BOARDS = (
    "plotter_2014", "router_3axis", "router_4axis", "router_ballscrew", "router_tmc2209", "router_tmc5160", "laser_xy", "laser_rotary", "corexy_plotter",
    "torch_manipulator", "mill_2004", "lpt_router", "two_motor_kit",
)  # fmt: skip
FOLDERS = {"en": DOCS / "start" / "machines", "pt": DOCS / "pt" / "machines"}
PAGE = DOCS / "start" / "page.png"
_SIZE = 1280, 1240
_HOMING_S, _RUNNING_S = 40, 12
JOB = ROOT / "examples" / "plate.gcode"


def wiring_drawings():
    """Return {file: text} of all wiring drawings of the documents."""
    from host_tools.wiring.drawing import wiring_svg
    from passo.config.boardfile import check

    found = {}
    try:
        for spoken, folder in FOLDERS.items():
            language.choose_language(spoken)
            found.update({folder / f"{name}.svg": wiring_svg(check(boards.load(name))) for name in BOARDS if name in boards.names()})
    finally:
        language.choose_language(None)
    return found


def save_page_picture(file):
    """Write a picture of the page of a virtual router that has homed and is at a job. Takes a minute."""
    with tempfile.TemporaryDirectory() as jobs:
        shutil.copy(JOB, jobs)
        command = [*interpreter.passo(), "panel", "--demo", "--http", "0", "--jobs", jobs]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as panel:
            try:
                address = next(found[0] for line in panel.stdout if (found := re.search(r"http://\S+#key=\S+", line)))
                _take_screenshot(address, file)
            finally:
                panel.terminate()


def _take_screenshot(address, file):
    """Home the machine on its page, start JOB, and write a picture of the browser's window."""
    import io

    from PIL import Image
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    for word in ("--headless=new", "--no-sandbox", "--lang=en", "--hide-scrollbars", f"--window-size={_SIZE[0]},{_SIZE[1]}"):
        options.add_argument(word)
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
    try:
        browser.get(address)
        time.sleep(2)
        _press_element(browser, "button", "Home")
        time.sleep(_HOMING_S)
        _press_element(browser, "option", JOB.name)
        time.sleep(3)
        _press_element(browser, "button", "Run")
        time.sleep(_RUNNING_S)
        picture = Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
        picture.quantize(64).save(file, optimize=True)
    finally:
        browser.quit()


def _press_element(browser, kind, label):
    """Press the first element of that kind and name, as the page shows it in English."""
    for each in browser.find_elements("tag name", kind):
        if each.is_enabled() and (each.text.strip().startswith(label) or each.get_attribute("value") == label):
            browser.execute_script("arguments[0].scrollIntoView({block: 'nearest'})", each)
            each.click()
            return browser.execute_script("window.scrollTo(0, 0)")
    print(f"the page has no {kind} {label!r}", file=sys.stderr)


if __name__ == "__main__":
    for _file, _text in wiring_drawings().items():
        _file.parent.mkdir(parents=True, exist_ok=True)
        _file.write_text(_text, encoding="utf-8")
        print(_file.relative_to(ROOT))
    if "--page" in sys.argv[1:]:
        save_page_picture(PAGE)
        print(PAGE.relative_to(ROOT), PAGE.stat().st_size)

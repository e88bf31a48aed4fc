"""The plotter's card of points, as the PC program of 2014 took them: typed or clicked, several objects in a row, each with its time."""

import pytest
from test_panel_page import Browser, driver, pytestmark as of_pages  # noqa: F401

from panel_process import PanelProcess

pytestmark = [*of_pages, pytest.mark.slow]  # it homes in real time


def test_objects_by_their_points(tmp_path, driver):
    with PanelProcess(tmp_path, "--board", "plotter_2014") as process, Browser(process, driver, query="lang=en&theme=light") as browser:
        browser.until(lambda: browser.text("state") in ("Ready", "Alarm"))
        browser.click("home")
        browser.until_state("Homing")
        browser.until_state("Ready")

        def typed():
            return browser.find("points").get_attribute("value")

        browser.tap("#points-card summary")
        browser.driver.execute_script("document.getElementById('points').value = arguments[0]", "10,10 30,10 30,25 10,10\n50,10")
        browser.click("points-click")
        browser.tap("#path")
        browser.until(lambda: len(typed().split("\n")[1].split()) == 2)
        browser.click("points-click")
        browser.tap("#path")
        assert len(typed().split("\n")[1].split()) == 2, "no longer"
        browser.driver.execute_script("document.getElementById('points').value = arguments[0]", "10,10 30,10 30,25 10,10\n50,10 50,20\n")
        browser.tap("#points-form .go")
        browser.until(lambda: browser.find("jobs").get_property("value") == "points.txt")
        browser.click("run")
        browser.until(lambda: len(browser.driver.find_elements("css selector", "#object-times li")) == 2)
        browser.until(lambda: "Done" in browser.text("job-state"))
        said = browser.find("object-times").get_attribute("textContent")
        assert said.startswith("Object 0: ") and "Object 1: " in said
        browser.driver.execute_script("document.getElementById('points').value = '10,10 x'")
        browser.tap("#points-form .go")
        browser.until(lambda: "two points or more" in browser.text("message"))
    drawn = {(x, y) for _, x, y, *_ in process.trace()}
    assert {(300, 250), (500, 200)} <= drawn and (500, 300) not in drawn, "10 steps are a millimetre"

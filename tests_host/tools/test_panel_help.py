"""Help for every element, as the program of 2009 had it (its annex B has a topic a button): each control of the page says what it does.

Controls without a sentence are counted, on a machine of each language, in English and in Portuguese: none.
"""

import pytest
from test_panel_page import Browser, driver, pytestmark as of_pages  # noqa: F401

from panel_process import PanelProcess
from titles import WITHOUT

pytestmark = of_pages
MACHINES = ("mill_2004", "plotter_2014", "torch_manipulator", "lpt_router", "two_motor_kit")
CONTROLS = """
return [...document.querySelectorAll("button, input:not([type=hidden]), select, textarea, summary, canvas, a[href], [tabindex]")]
  .map((e) => [e.outerHTML.slice(0, 160), e.dataset.help || e.title || "", e.title]);
"""
SPEAKS = "return document.documentElement.lang === arguments[0]"


def sentences(browser):
    """Return the sentences of the controls, once each control has one."""
    try:
        browser.until(lambda: not browser.driver.execute_script(WITHOUT))
    except AssertionError:
        pytest.fail("without a sentence: " + "\n".join(browser.driver.execute_script(WITHOUT)))
    return {help_ for _, help_, _ in browser.driver.execute_script(CONTROLS)}


@pytest.mark.parametrize("machine", MACHINES)
def test_no_control_is_without_a_sentence(machine, tmp_path, driver):
    said = {}
    for language in ("en", "pt"):
        folder = tmp_path / language
        folder.mkdir()
        with PanelProcess(folder, "--board", machine) as process, Browser(process, driver, query=f"lang={language}&theme=light") as browser:
            browser.until(lambda language=language: browser.driver.execute_script(SPEAKS, language))
            said[language] = sentences(browser)
            if machine == "mill_2004":
                for view in ("plate", "corner", "hole", "boss", "tool", "surface", "map", "offsets", "inout", "health", "pad"):
                    browser.until(lambda view=view: browser.driver.execute_script("return Boolean(document.getElementById(`setup-${arguments[0]}`))", view))
                    browser.driver.execute_script("document.getElementById(`setup-${arguments[0]}`).click()", view)
                    said[language] |= sentences(browser)
                    browser.driver.execute_script("document.getElementById('setup-back').click()")
    assert len(said["en"]) > 40 and not {text for text in said["en"] & said["pt"] if len(text.split()) > 3}, "in both languages the same"


def test_a_grey_control_says_why_and_then_what_it_does_again(tmp_path, driver):
    with PanelProcess(tmp_path, "--board", "router_3axis") as process, Browser(process, driver, query="lang=en&theme=light") as browser:
        def title():
            return browser.find("unlock").get_attribute("title")

        browser.until(lambda: browser.text("state") == "Alarm" or "Locked" in browser.text("message"))
        browser.until(lambda: title().startswith("Ends the alarm"))
        browser.click("unlock")
        browser.until(lambda: title() == "The machine is not locked.")

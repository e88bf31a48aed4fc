"""The page as a board serves it: all modules in one script, which a browser runs as it runs them."""

import functools
import http.server
import threading

import pytest
from test_page_syntax import parsed
from test_panel_page import CHROMIUM, DRIVER, chromium

from host_tools import boards
from host_tools.build.pages import bundle, texts_of
from host_tools.failure import Failure


def test_it_is_one_script(tmp_path):
    texts = texts_of(boards.load("plotter_page"))
    assert [name for name in texts if name.endswith(".js")] == ["panel.js"]
    (tmp_path / "panel.js").write_bytes(texts["panel.js"])
    assert not parsed([tmp_path / "panel.js"], tmp_path)


@pytest.mark.quick
def test_names_are_each_modules_own():
    made = bundle({"a.js": 'import "./c.js";\nimport { one, two as twice } from "./b.js";\nconst $ = 1;\nuse(one, twice, $);\n',
                   "b.js": 'import { three } from "./c.js";\nconst $ = 2;\nexport const one = $;\nexport function two() { return three; }\n',
                   "c.js": "export class three {}\n"}, "a.js")  # fmt: skip
    assert made.index("of_c") < made.index("of_b") < made.index("of_a")
    assert "const {one, two: twice} = of_b;" in made.replace("{ ", "{").replace(" }", "}") and "import" not in made and "export" not in made


@pytest.mark.quick
@pytest.mark.parametrize("text", ('import * as b from "./b.js";\n', "export default 1;\n", "export let x = 1;\n", 'import { a } from "./a.js";\n'))
def test_what_it_does_not_know_is_refused(text):
    with pytest.raises(Failure):
        bundle({"a.js": text, "b.js": ""}, "a.js")


@pytest.mark.unmeasured
@pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="NO BROWSER: apt-get install chromium chromium-driver, to test the page")
def test_a_browser_runs_it(tmp_path):
    """Without a server behind it the page says so, in Portuguese."""
    for name, text in texts_of(boards.load("plotter_page")).items():
        (tmp_path / name).write_bytes(text)
    (tmp_path / "errors.json").write_text("{}")
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(http.server.SimpleHTTPRequestHandler, directory=str(tmp_path)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    driver = chromium()
    try:
        driver.get(f"http://127.0.0.1:{server.server_port}/?lang=pt&theme=light")
        wanted = "return document.documentElement.lang === 'pt' && document.getElementById('stop').textContent === 'PARAR' && document.getElementById('message').textContent !== ''"
        from selenium.webdriver.support.ui import WebDriverWait

        WebDriverWait(driver, 60).until(lambda opened: opened.execute_script(wanted))
        assert not [row for row in driver.get_log("browser") if "Uncaught" in row["message"] or "SyntaxError" in row["message"]]
    finally:
        driver.quit()
        server.shutdown()
        server.server_close()

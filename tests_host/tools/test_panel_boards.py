"""Board files of the user's own, from the page: made, changed, refused by the firmware's check, taken back, deleted. `passo machine`
writes the same. PASSO_SHOTS=FOLDER keeps pictures."""

import copy
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st
from test_panel_page import Browser, driver, pytestmark as of_pages  # noqa: F401
from titles import WITHOUT
from typer.testing import CliRunner

from host_tools import board_edit, board_files, boards
from host_tools.cli.main import app
from host_tools.failure import Failure
from host_tools.panel.machine_form import Form
from host_tools.panel.own_boards import OwnBoards
from panel_process import PanelProcess
from passo import errors
from passo.config.boardfile import check

LIKE = 'BOARD = {"name": "mine", "like": "%s"}\n'


class Desk:
    """Orders about the files of a folder, of which Passo's own and none of the user's are there at first."""

    def __init__(self, folder):
        self.folder = folder / "own"
        self.present = "lpt_router"
        self.told = 0
        self.files = board_files.available_files(self.folder)
        self.own = OwnBoards(self.folder, self.files, lambda: self.present, self._tell)

    def _tell(self):
        self.told += 1

    def order(self, what, name="mine.py", **fields):
        return self.own.finish(self.own.carry_out({"do": "board", "what": what, "name": name, **fields}))

    def read(self, name="mine.py"):
        return (self.folder / name).read_text(encoding="utf-8")


@pytest.fixture
def desk(tmp_path):
    return Desk(tmp_path)


def fields_of(told):
    return {field["key"]: field["value"] for group in told["groups"] for row in group["rows"] for field in row["fields"]}


def test_a_machine_is_made_changed_and_deleted(desk, tmp_path, monkeypatch):
    told = desk.order("new", "lpt_router", **{"as": "mine"})
    assert told["name"] == "mine.py" and told["own"] and not told["old"] and desk.told == 1 and desk.files["mine.py"] == str(desk.folder / "mine.py")
    fields = fields_of(told)
    assert fields["step_program.interval_us"] == 312 and fields["axes.x.steps_per_m"] == 80.0 and fields["axes.z.used"] is True and fields["inputs.stop.pin"] == 16
    values = {"step_program.interval_us": "250", "axes.x.steps_per_m": "81.25", "axes.z.used": False, "axes.y.pins.1": "10", "player": True, "inputs.repl.pin": "-", "inputs.stop.active": True,
              "inputs.probe.pin": "15", "outputs.enable.active": False, "port.0.bit": "-", "port.7.inverted": True}  # fmt: skip
    told = desk.order("set", values=values)
    assert told["t"] == "board" and told["old"], told
    board = boards.load(desk.files["mine.py"])
    assert [axis["name"] for axis in board["axes"]] == ["x", "y"] and board["axes"][0]["steps_per_m"] == 81_250 and board["axes"][1]["pins"] == [3, 10]
    assert {item["name"]: (item["pin"], item.get("active", 1)) for item in board["inputs"]} == {"stop": (16, 0), "probe": (15, 1)}
    assert board["outputs"] == [{"name": "enable", "pin": 9, "active": 1}]
    assert [board["step_program"][key] for key in ("interval_us", "port_bits", "port_invert")] == [250, "-6543210", 1]
    assert fields_of(told)["inputs.repl.pin"] == "-" and fields_of(told)["axes.z.used"] is False, "what was taken away can come back"

    monkeypatch.chdir(tmp_path)  # the command writes the same
    for words in (["new", "mine", "--like", "lpt_router"], ["set", "mine.py", "inputs.repl=None", "axes.z=None", "inputs.probe={}", "step_program.interval_us=250",
                  "axes.x.steps_per_m=81250", "axes.y.pins=[3, 10]", "player=timer", "inputs.stop.active=0", "inputs.probe.pin=15", "outputs.enable.active=1", "step_program.port_bits='-6543210'",
                  "step_program.port_invert=1"]):  # fmt: skip
        assert CliRunner().invoke(app, ["machine", *words]).exit_code == 0
    assert boards.load("mine.py") == board and Path("mine.py.old").read_text(encoding="utf-8") == desk.read("mine.py.old")

    changed = desk.read()
    assert desk.order("set", values={"axes.z.used": True, "axes.z.steps_per_m": "100", "inputs.repl.pin": "20", "inputs.probe.pin": "-"})["t"] == "board"
    board = boards.load(desk.files["mine.py"])
    assert board["axes"][2] == {"name": "z", "pins": [4, 7], "steps_per_m": 100_000, "travel_steps": 8000}
    assert {item["name"]: item["pin"] for item in board["inputs"]} == {"stop": 16, "repl": 20}
    again = desk.read()
    assert desk.order("back")["t"] == "board" and desk.read() == changed and desk.read("mine.py.old") == again
    assert desk.order("back")["t"] == "board" and desk.read() == again

    desk.present = "mine.py"
    assert desk.order("remove")["text"] == "machine mine.py is the chosen one: choose another first"
    desk.present = "lpt_router"
    assert desk.order("remove") == {"t": "answer", "do": "board", "error": 0} and "mine.py" not in desk.files and desk.told == 2
    assert not (desk.folder / "mine.py").exists() and desk.read("mine.py.old") == again
    assert desk.order("get") == errors.ORDER_FIELD


def test_a_copy_of_what_is_itself_like_another(desk):
    assert desk.order("new", "plotter_pico_2", **{"as": "mine"})["t"] == "board" and boards.load(desk.files["mine.py"])["chip"] == "rp2350"
    assert desk.order("set", values={"axes.x.steps_per_m": "6"})["t"] == "board"
    assert desk.order("new", **{"as": "other"})["name"] == "other.py"
    board = boards.load(desk.files["other.py"])
    assert board["name"] == "other" and board["axes"][0]["steps_per_m"] == 6000


@pytest.mark.parametrize("values, said", [
    ({"inputs.stop.pin": "2"}, "board mine.py: pin 2 is claimed by"), ({"step_program.interval_us": "0"}, "interval_us"), ({"step_program.interval_us": "250001"}, "interval_us"),
    ({"axes.x.steps_per_m": "much"}, "steps_per_m"), ({"axes.x.steps_per_m": ""}, "steps_per_m"), ({"axes.x.steps_per_m": "nan"}, "steps_per_m"), ({"axes.x.used": False, "axes.y.used": False, "axes.z.used": False}, "axes"),
    ({"port.0.bit": "6"}, "port_bits"), ({"name": "x"}, "the page has no such field"), ({"axes.x.used": "no"}, "the page has no such field"), ({"inputs.a b.pin": "3"}, "the page has no such field"),
    ({"tool.pin": "-"}, "tool.pin"),
])  # fmt: skip
def test_what_the_firmware_refuses_is_said_and_not_written(desk, values, said):
    desk.order("new", "lpt_router", **{"as": "mine"})
    before = desk.read()
    answer = desk.order("set", values=values)
    assert answer["error"] == errors.ORDER_FIELD and said in answer["text"], answer
    assert desk.read() == before and not (desk.folder / "mine.py.old").exists()


def test_what_is_refused_else(desk):
    for name in ("", "x y", "../x", "new", "a_old", "x" * 33):
        assert desk.order("new", "lpt_router", **{"as": name}) == errors.ORDER_FIELD or "is no name for a machine" in desk.order("new", "lpt_router", **{"as": name})["text"]
    assert not desk.folder.exists() or not list(desk.folder.iterdir())
    desk.order("new", "lpt_router", **{"as": "mine"})
    assert "exists" in desk.order("new", "lpt_router", **{"as": "mine"})["text"]
    assert "has not been changed" in desk.order("back")["text"]
    for what in ("set", "back", "remove"):
        assert "is one of Passo's own" in desk.order(what, "lpt_router", values={})["text"]
    assert desk.order("get", "lpt_router")["own"] is False
    for fields in ({"what": "set", "name": "mine.py"}, {"what": "set", "name": "mine.py", "values": {"tool.pin": 3}}, {"what": "set", "name": "mine.py", "values": {"tool.pin": "x" * 33}}, {"what": "all", "name": "mine.py"}, {"what": "get", "name": "/etc/passwd"}):
        assert desk.own.carry_out(fields) == errors.ORDER_FIELD


@pytest.mark.parametrize("name", boards.names())
def test_what_is_shown_and_given_back_changes_nothing(name):
    """Of each board, as it is and as the one that another is like."""
    whole = boards.read(boards.path(name))
    for text in [whole] + [LIKE % name] * (boards.LIKE not in boards.own_table(whole, name)):
        form = Form(text, name)
        shown = {field["key"]: field["value"] for group in form.groups() for row in group["rows"] for field in row["fields"]}
        given = form.path_values({key: value if isinstance(value, bool) else str(value) for key, value in shown.items()})
        before, after = (check(copy.deepcopy(boards.parse_table(each, name))) for each in (text, board_edit.set_values(text, given)))
        before.pop("additions", None), after.pop("additions", None)
        assert before == after


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_whatever_a_page_gives_the_file_stays_one(data):
    """Each change is refused with a sentence, or the file is one that the firmware takes."""
    text = LIKE % data.draw(st.sampled_from(["lpt_router", "router_3axis", "mill_2004", "plotter_2014"]))
    for _ in range(data.draw(st.integers(1, 4))):
        form = Form(text, "mine.py")
        kinds = {field["key"]: field["kind"] for group in form.groups() for row in group["rows"] for field in row["fields"]}
        keys = data.draw(st.lists(st.sampled_from([*kinds, "inputs.probe.pin", "outputs.mist.pin", "axes.q.used"]), min_size=1, max_size=5, unique=True))
        words = st.sampled_from(["-", "", "1", "15", "20", "80.5", "-3", "1e400", "nan", "x", "{", '"'])
        values = {key: data.draw(st.booleans() if kinds.get(key) == "box" else words) for key in keys}
        try:
            text = board_files.edit_text("mine.py", text, form.path_values(values))
        except Failure as failure:
            assert failure.message()


def test_orders_want_the_key_and_a_stand_and_all_pages_are_told(tmp_path):
    with PanelProcess(tmp_path, "--board", "router_3axis", "--boards", str(tmp_path / "own")) as panel:
        page = panel.page().ready()
        other, stranger = panel.page(), panel.page(key="ABCD")
        assert "board" in page.hello["can"]
        assert stranger.order("board", what="new", name="router_3axis", **{"as": "mine"})["error"] == errors.NO_SESSION
        assert page.order("step", by={"x": 5}, speed=600)["error"] == 0
        page.until(lambda state: state["state"] == "Jog")
        assert page.order("board", what="new", name="router_3axis", **{"as": "mine"})["error"] == errors.BUSY
        assert page.order("board", what="get", name="router_3axis")["own"] is False
        page.until(lambda state: state["state"] == "Idle")
        assert page.order("board", what="new", name="router_3axis", **{"as": "mine"})["name"] == "mine.py"
        assert "mine.py" in other.said("machines")["machines"] and "mine.py" in panel.page().hello["machines"]
        assert page.order("board", what="set", name="mine.py", values={"axes.x.steps_per_m": "160"})["old"]
        assert page.order("machine", name="mine.py")["error"] == 0
        assert page.said("machine")["machines"][:2] == ["mine.py", "router_3axis"]
        page.until(lambda state: state["link"])
        assert page.order("settings")["settings"]["100"] == "160.000"
        assert "is the chosen one" in page.order("board", what="remove", name="mine.py")["text"]


@pytest.mark.slow
@of_pages[-1]
@pytest.mark.parametrize("language, size", [("en", (1280, 1000)), ("pt", (390, 844))])
def test_the_card_makes_a_machine_changes_it_and_deletes_it(language, size, tmp_path, driver):  # noqa: F811
    own = tmp_path / "own"
    with PanelProcess(tmp_path, "--board", "lpt_router", "--boards", str(own)) as panel, Browser(panel, driver, size, f"lang={language}&theme=light") as browser:
        def there(name):
            return browser.driver.execute_script("return Boolean(document.getElementById(arguments[0]))", name)

        def field(key):
            return browser.bring(browser.css(f"[data-key='{key}']"))

        def put(key, text):
            field(key).clear()
            field(key).send_keys(text)

        def until_shown(key, text):
            browser.until(lambda: browser.driver.execute_script("return document.querySelector(arguments[0]).value", f"[data-key='{key}']") == text)

        def file():
            return boards.load(str(own / "mine.py"))

        browser.until(lambda: there("card-board"))
        browser.bring(browser.find("machine"))
        browser.tap("#card-board summary")
        browser.until(lambda: browser.text("board-form") != "")
        assert "lpt_router" in browser.text("board-form") and not there("board-save")
        browser.bring(browser.find("board-as")).send_keys("mine\n")
        browser.until(lambda: there("board-save") and browser.find("machines").get_attribute("value") == "mine.py")
        browser.until(lambda: not browser.driver.execute_script(WITHOUT))
        assert browser.driver.execute_script("return document.documentElement.scrollWidth <= innerWidth && document.getElementById('card-board').scrollWidth <= document.getElementById('card-board').clientWidth")
        browser.shot(f"board-made-{language}")
        put("axes.x.steps_per_m", "160")
        browser.driver.execute_script("arguments[0].value = '2'", field("inputs.stop.pin"))  # the STEP pin of X
        browser.click("board-save")
        browser.until(lambda: "2" in browser.text("message"))
        assert "mine.py" in browser.text("message") and ("claimed" if language == "en" else "pino 2") in browser.text("message")
        browser.shot(f"board-refused-{language}")
        assert (own / "mine.py").exists() and not (own / "mine.py.old").exists()
        browser.driver.execute_script("arguments[0].value = '17'", field("inputs.stop.pin"))
        field("inputs.stop.active").click()
        browser.bring(field("axes.x.steps_per_m")).send_keys("\n")  # the keyboard saves, too
        browser.until(lambda: (own / "mine.py.old").exists() and "mine.py" in browser.text("message"))
        assert file()["axes"][0]["steps_per_m"] == 160_000 and file()["inputs"][0] == {**boards.load("lpt_router")["inputs"][0], "pin": 17, "active": 0}
        browser.shot(f"board-saved-{language}")
        browser.click("board-back")
        until_shown("axes.x.steps_per_m", "80")
        assert file()["axes"][0]["steps_per_m"] == 80_000
        browser.click("board-back")
        until_shown("axes.x.steps_per_m", "160")
        browser.click("board-remove")
        browser.answer(False)
        browser.click("board-remove")
        browser.answer()
        browser.until(lambda: not (own / "mine.py").exists() and "mine.py" not in browser.find("machines").text)
        browser.until(lambda: "mine.py" in browser.text("message") and browser.find("machines").get_attribute("value") == "lpt_router")
        assert not [row for row in browser.driver.get_log("browser") if "Uncaught" in row["message"]]

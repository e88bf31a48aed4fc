"""The page of each machine, served by its own board and by a PC: proof, lease, hand-over and STOP are the same."""

from passo import errors
from passo.protocols.page.lease import LEASE_MS
from served_pages import OnBoard, OnCable

BOTH = (OnBoard, OnCable)
SPEED = 600
# Of each language: a machine, what gets it ready, the orders that move it, and the direction of its jogs.
MACHINES = {
    "grbl": ("router_3axis", (("unlock", {}),), ("step", {"by": {"x": 5}, "speed": SPEED}), {"x": 1}),
    "plotter": ("plotter_2014", (), ("step", {"by": {"x": 5}, "speed": SPEED}), {"x": 1}),
    "torch": ("torch_manipulator", (("output", {"name": "motors_on"}),), ("step", {"by": {"x": 5}, "speed": SPEED}), {"x": 1}),
    "pulses": ("lpt_router", (), ("step", {"by": {"x": 5}, "speed": SPEED}), {"x": 1}),
    "keys": ("two_motor_kit", (), ("motor", {"motor": 1, "what": "on"}), {"x": 1}),
}
BRAKES_MS = 50  # the longest way to a stand of these, from SPEED
BRAKED_MS = 66  # from the order on, if it overtakes nothing: less than the way that is queued ahead of any of these
OVERTAKEN_MS = 145  # if a piece of the jog comes after the brake, and has to be braked as well
ENDS_MS = 80  # a jog that is let go, or whose page has gone: the bytes sent, and the words in the pins' queue
NOT_QUICK = ("check_a_jog_that_is_let_go_brakes", "check_a_jog_ends_with_its_lease")


def ready(served, language):
    """(desk, page) of a machine that the page commands, and that may move."""
    name, orders, _, _ = MACHINES[language]
    desk = served(name)
    page = desk.page()
    page.until(lambda state: state["link"])
    if desk.commands() != desk.mine:
        assert page.order("give", to="page")["error"] == 0
        desk.run_ms(300)
    assert desk.commands() == desk.mine
    for order, fields in orders:
        assert page.order(order, **fields)["error"] == 0, order
        desk.run_ms(300)
    page.until(lambda state: state["state"] in ("Idle", "Stopped"))
    return desk, page


def moves(language):
    return MACHINES[language][2]


def what_it_can(language):
    """A page of the board has the same orders as one of the PC, except those that only a PC has, or only a board."""
    of_pc, of_board = [set(ready(served, language)[1].hello["can"]) for served in (OnCable, OnBoard)]
    assert of_pc - of_board <= {"jobs", "teach", "single"}, of_pc - of_board
    assert of_board - of_pc == {"command"}, of_board - of_pc
    travels = [ready(served, language)[1].hello["travel"] for served in (OnCable, OnBoard)]
    assert travels[0] == travels[1] or language == "grbl" and travels[0] is None, travels  # by cable the settings say it


# Orders that no machine takes as they are.
WRONG = (
    ("nothing", {}), ("step", {"by": {"q": 1}, "speed": SPEED}), ("step", {"by": {"x": "1"}, "speed": SPEED}), ("step", {"by": {"x": 1}}),
    ("step", {"by": {"x": 1}, "speed": 0}), ("step", {"by": {}, "speed": SPEED}), ("goto", {"to": [1, 2], "speed": SPEED}), ("zero", {"axes": "q"}),
    ("jog", {"lease": 0, "beat": 1, "way": {"x": 1}, "speed": SPEED}), ("jog", {"lease": 1, "beat": 1, "way": {"x": 0}, "speed": SPEED}),
    ("override", {"what": "feed", "to": 7}), ("output", {"name": 5}), ("set", {"number": "1", "value": 1}), ("line", {"line": "\x07"}),
)  # fmt: skip


def what_orders_do(language):
    """Wrong orders are answered alike and move nothing; the same order moves the machine as far, and its state has the same fields."""
    order, fields = moves(language)
    seen = []
    for served in BOTH:
        desk, page = ready(served, language)
        before = desk.place()
        answers = [page.order(name, **more)["error"] for name, more in WRONG]
        desk.run_ms(300)
        assert desk.place() == before, served
        assert page.order(order, **fields)["error"] == 0
        desk.run_ms(1500)
        page.until(lambda state: state["state"] in ("Idle", "Stopped", "Run"))
        seen.append((answers, [one - other for one, other in zip(desk.place(), before)], set(page.state)))
    of_board, of_pc = seen
    assert of_board[0] == of_pc[0] and 0 not in of_board[0], (of_board[0], of_pc[0])
    assert of_board[1] == of_pc[1] != [0] * len(of_pc[1]) or language == "keys", (of_board[1], of_pc[1])  # its motor goes on
    assert of_pc[2] - of_board[2] <= {"stored", "teaching"} and of_board[2] <= of_pc[2], of_pc[2] ^ of_board[2]  # a PC has jobs and teach-in


def only_who_proves_the_key(language):
    order, fields = moves(language)
    for served in BOTH:
        desk, page = ready(served, language)
        before = desk.place()
        assert page.order(order, False, **fields)["error"] == errors.NO_SESSION
        stranger = desk.page("A" * 16)
        body = {"do": order}
        body.update(fields)
        stranger.say(stranger.message(body))
        assert stranger.wait(lambda told: told["t"] == "answer")["error"] == errors.NO_SESSION
        desk.run_ms(600)
        assert desk.place() == before, served
        message = page.message(body)
        page.say(message)
        page.say(message)
        desk.run_ms(300)
        told = [each["error"] for each in page.told if each["t"] == "answer"]
        assert told == [0, errors.NO_SESSION], "once, and not again: %r" % told
        assert desk.place() != before


def refused(desk, page, order, fields):
    """The error that an order was refused with: in its answer, or in the log behind it."""
    page.told.clear()
    error = page.order(order, **fields)["error"]
    desk.run_ms(400)
    logs = [number for told in page.told if told["t"] == "log" for number in told["log"]]
    return error or (logs + [0])[0]


def who_commands(language):
    """Another link takes the command: the page moves nothing, and takes it back at rest, not while something moves."""
    order, fields = moves(language)
    for served in BOTH:
        desk, page = ready(served, language)
        desk.take()
        assert desk.commands() == "other"
        before = desk.place()
        assert refused(desk, page, order, fields) == errors.COMMANDED_ELSEWHERE, served
        assert desk.place() == before, served
        if language == "keys" and served is OnCable:
            continue  # it has no word for that
        assert page.order("give", to="page")["error"] == 0
        desk.run_ms(300)
        assert desk.commands() == desk.mine
        page.until(lambda state: state["owner"] == "page" and state["state"] in ("Idle", "Alarm", "Stopped"))
        for each, more in MACHINES[language][1]:
            page.order(each, **more)
            desk.run_ms(300)
        assert page.order(order, **fields)["error"] == 0
        desk.run_ms(500)
        assert desk.place() != before


def stop_needs_no_key(language):
    order, fields = moves(language)
    for served in BOTH:
        desk, page = ready(served, language)
        stranger = desk.page("A" * 16)
        before = desk.place()
        assert page.order(order, **fields)["error"] == 0
        for _ in range(2000):
            desk.run_ms(1)
            if desk.place() != before:
                break
        assert desk.place() != before
        desk.run_ms(30)
        stranger.say('{"do":"stop"}')
        assert stranger.wait(lambda told: told.get("do") == "stop")["error"] == 0
        desk.run_ms(60)
        stood = desk.place()
        assert stood != before
        desk.run_ms(400)
        assert desk.place() == stood, served


def hold(desk, page, lease, milliseconds, way):
    """Hold a jog for `milliseconds`, renewed each 60 ms."""
    page.until(lambda state: "beat" in state)
    desk.run_ms(250)
    answer = page.order("jog", lease=lease, beat=page.state["beat"], way=way, speed=SPEED)
    assert answer["error"] == 0, answer
    for _ in range(milliseconds // 60):
        desk.run_ms(60)
        assert page.order("keep", lease=lease, beat=page.state["beat"])["error"] == 0


def a_jog_ends_with_its_lease(language):
    way = MACHINES[language][3]
    for served in BOTH:
        desk, page = ready(served, language)
        before = desk.place()
        hold(desk, page, 7, 420, way)
        assert desk.place() != before
        desk.run_ms(LEASE_MS + ENDS_MS + BRAKES_MS)
        stood = desk.place()
        assert page.order("keep", lease=7, beat=page.state["beat"])["error"] == errors.LEASE
        desk.run_ms(500)
        assert desk.place() == stood, (served, stood, desk.place())
        assert page.order("jog", lease=7, beat=page.state["beat"], way=way, speed=SPEED)["error"] == errors.LEASE, "its number is used up"
        hold(desk, page, 8, 120, way)
        assert page.order("release", lease=8)["error"] == 0
        desk.run_ms(ENDS_MS + BRAKES_MS)
        stood = desk.place()
        desk.run_ms(500)
        assert desk.place() == stood, (language, served)


def a_jog_that_is_let_go_brakes(language):
    """It brakes at once, not at the end of the queue; at any moment, also amid a piece without an answer."""
    for served in BOTH:
        desk, page = ready(served, language)
        took = []
        for lease in range(1, 9):
            hold(desk, page, lease, 240, MACHINES[language][3])
            desk.run_ms(6 * lease)
            at = desk.now_ms()
            assert page.order("release", lease=lease)["error"] == 0
            desk.run_ms(400)
            took.append(desk.now_ms() - desk.stood_ms() - at)
        assert min(took) <= BRAKED_MS and max(took) <= OVERTAKEN_MS, (language, served, took)


def a_jog_ends_with_its_page(language):
    for served in BOTH:
        desk, page = ready(served, language)
        hold(desk, page, 1, 300, MACHINES[language][3])
        page.close()
        desk.run_ms(ENDS_MS + BRAKES_MS)
        stood = desk.place()
        desk.run_ms(500)
        assert desk.place() == stood, served


def of_settings(desk, *numbers):
    settings = desk.app.controller.machine.settings
    return [settings.value(number) for number in numbers]


def settings_of_the_board(language):
    """Told to all, set by the page that commands and has proven its key, refused by number; steps/mm count for the page at once."""
    desk, page = ready(OnBoard, language)
    told = page.order("settings")["settings"]
    assert float(told["100"]) * 1000 == of_settings(desk, 100)[0] and "110" in told
    assert page.order("set", False, number=100, value=33.5)["error"] == errors.NO_SESSION
    assert page.order("set", number=999, value=1)["error"] == errors.STATEMENT
    before = of_settings(desk, 100)
    assert page.order("set", number=100, value=0)["error"] == errors.SETTING_RANGE and of_settings(desk, 100) == before
    assert page.order("set", number=100, value=33.5)["error"] == 0 and of_settings(desk, 100) == [33_500]
    desk.run_ms(300)
    told = [each for each in page.told if each["t"] == "settings"][-1]["settings"]
    assert float(told["100"]) == 33.5
    if language == "keys":
        return
    at = desk.place()
    order, fields = moves(language)
    assert page.order(order, **fields)["error"] == 0
    desk.run_ms(1500)
    assert abs(abs(desk.place()[0] - at[0]) - 5 * 33.5) <= 1, (at, desk.place())


def preferences_of_a_torch(served):
    """Steps/mm, jogs and speeds in one order: the board has kept them, in millimetres; refused steps/mm change nothing of it."""
    desk, page = ready(served, "torch")
    assert page.order("configure", jogx=2, jogy=0.5, xv=300, yv=450, sx=50)["error"] == 0
    desk.run_ms(500)
    assert of_settings(desk, 100, 101, 150, 151, 170, 171) == [50_000, 83_000, 2000, 506, 300_000, 449_639]  # 42 steps, 622 steps/s
    told = page.order("preferences")
    assert told["scale"] == [50, 83] and told["jog"] == [2, 0.506], told
    page.order("configure", jogx=3, jogy=3, xv=300, yv=450, sy=99_999)
    desk.run_ms(500)
    assert of_settings(desk, 100, 101, 150) == [50_000, 83_000, 2000]
    page.order("configure", jogx=3, jogy=3, xv=300, yv=450)
    desk.run_ms(500)
    assert of_settings(desk, 150, 151) == [3000, 3000]


def check_settings_of_the_board():
    for language in MACHINES:
        if language != "grbl":
            settings_of_the_board(language)


def check_preferences_of_a_torch():
    for served in BOTH:
        preferences_of_a_torch(served)


def check_what_it_can():
    for language in MACHINES:
        what_it_can(language)


def check_what_orders_do():
    for language in MACHINES:
        what_orders_do(language)


def check_only_who_proves_the_key():
    for language in MACHINES:
        only_who_proves_the_key(language)


def check_who_commands():
    for language in MACHINES:
        who_commands(language)


def check_stop_needs_no_key():
    for language in MACHINES:
        stop_needs_no_key(language)


def check_a_jog_ends_with_its_lease():
    for language in MACHINES:
        a_jog_ends_with_its_lease(language)


def check_a_jog_that_is_let_go_brakes():
    for language in MACHINES:
        a_jog_that_is_let_go_brakes(language)


def check_a_jog_ends_with_its_page():
    for language in MACHINES:
        a_jog_ends_with_its_page(language)

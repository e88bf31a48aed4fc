"""A relief streamed at full speed, with pages that look on and without: how many lines a second the machine makes."""

import csv
import math
import threading
import time

import pytest
import websocket

from panel_process import PanelProcess

pytestmark = [pytest.mark.unmeasured, pytest.mark.slow, pytest.mark.xdist_group("panel")]
LINES = 5000
PUSHES_S = 10


def relief():
    """Lines of 0.1 mm, 60 mm there and back, with a Z of their own."""
    rows = [f"X{0.1 * (600 - abs(n % 1200 - 600)):.1f}Z{-0.2 - 0.1 * math.sin(n / 9):.3f}" for n in range(1, LINES)]
    return "G21G90\nG1F5000\n" + "\n".join(rows) + "\n"


def watch(page, pushed, ended):
    """Count what is pushed to a page while the machine runs."""
    try:
        while not ended.is_set():
            if page.hear()["t"] == "state" and page.state["state"] == "Run":
                pushed.append(time.monotonic())
    except (websocket.WebSocketException, OSError):
        pass


def lines_a_second(folder, pages):
    """(lines a second of the machine's time, pushes a second to each page)."""
    with PanelProcess(folder) as panel:
        runner = panel.page().ready()
        runner.put("relief", relief())
        assert runner.order("run", name="relief")["error"] == 0
        runner.socket.close()
        ended = threading.Event()
        watchers = [(panel.page(), []) for _ in range(pages)]
        threads = [threading.Thread(target=watch, args=(page, pushed, ended)) for page, pushed in watchers]
        for thread in threads:
            thread.start()
        how = "run"
        while how == "run":
            time.sleep(3)
            looker = panel.page()
            how = looker.until(lambda state: state["job"])["job"]["how"]
            looker.socket.close()
        assert how == "done"
        ended.set()
        for thread in threads:
            thread.join()
    with open(panel.trace_file, newline="") as file:
        times = [float(row["t_us"]) for row in csv.DictReader(file)]
    return LINES / (times[-1] - times[1]) * 1e6, [len(pushed) / (pushed[-1] - pushed[0]) for _, pushed in watchers]


def test_pages_that_look_on_cost_nothing(tmp_path):
    (tmp_path / "without").mkdir()
    (tmp_path / "with").mkdir()
    without, _ = lines_a_second(tmp_path / "without", 0)
    watched, pushes = lines_a_second(tmp_path / "with", 2)
    print(f"{without:.0f} lines/s without, {watched:.0f} with two pages: {watched / without:.3f}; pushed {pushes}")
    assert watched >= 0.95 * without
    assert min(pushes) >= PUSHES_S

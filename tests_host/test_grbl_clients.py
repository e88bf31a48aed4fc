"""Senders that people use, against the firmware on a pseudo-terminal; each skips where it is not installed."""

import time

import pytest

from running_router import Running


@pytest.fixture
def board():
    running = Running()
    yield running
    running.close()


def zigzag(count, step):
    return [f"G1 X{step * (i + 1):.3f} Y{(i % 2) * 0.5:.3f} F4000" for i in range(count)]


@pytest.mark.parametrize("one_by_one", [True, False], ids=["ok", "characters"])
def test_grbl_streamer(board, one_by_one):
    module = pytest.importorskip("grbl_streamer")
    said = []
    client = module.GrblStreamer(lambda kind, *data: said.append((kind, *data)))
    kinds = lambda: [event[0] for event in said]
    state = lambda: board.app.controller.state
    client.setup_logging()
    client.cnect(board.line.name, 115200)
    try:
        board.until(lambda: client.connected)
        client.poll_start()
        client.incremental_streaming = one_by_one
        board.until(lambda: ("on_read", "$132=80.000") in said)
        client.killalarm()
        client.homing()
        board.until(lambda: board.app.controller.homed and state() == "idle")
        zero = list(board.world.place)

        said.clear()
        client.write("\n".join(zigzag(60, 0.2)))
        client.job_run()
        board.until(lambda: "on_job_completed" in kinds() and state() == "idle")
        assert board.position() == [3840, 160, 0]
        assert [at - by for at, by in zip(board.world.place, zero)] == [3840, 160, 0]

        client.job_new()
        client.write("G1 X0 Y0 F600")
        client.job_run()
        board.until(lambda: state() == "run" and board.position()[0] < 3700)
        client.hold()
        board.until(lambda: board.app.controller.pauses.standing())
        stood = board.position()
        time.sleep(0.2)
        assert board.position() == stood
        client._iface.serialport.write(b"\x91")
        client.resume()
        board.until(lambda: state() == "run")
        assert board.app.controller.tools.overrides[0] == 110
        client._iface.serialport.write(b"\x91" * 9)
        board.until(lambda: state() == "idle")
        assert board.position() == [0, 0, 0]

        client._iface_write("$J=X50F1000\n")
        board.until(lambda: state() == "jog" and board.position()[0] > 100)
        client._iface.serialport.write(b"\x85")
        board.until(lambda: state() == "idle")
        assert 100 < board.position()[0] < 16000

        client._iface_write("G0 X-5\n")
        board.until(lambda: any(event == ("on_alarm", "ALARM:2") for event in said))
        client.softreset()
        board.until(lambda: board.app.controller.alarm == 200)
        client.killalarm()
        board.until(lambda: state() == "idle")
        assert [at - by for at, by in zip(board.world.place, zero)] == board.position()
        assert "on_error" in kinds()  # the answer to the line that raised the alarm
    finally:
        client.disconnect()

"""CAM programs run on the virtual router as they are, without a refused line, and their cycles go where the compiler says they go."""

import pytest

from cam_files import ALL
from host_tools.cli import stream
from host_tools.clients.grbl import GrblClient, Refused
from host_tools.programs import compiler, gcode_file
from host_tools.sim.job import VirtualJob
from plain_reader import events
from running_router import Running

STEPS_MM = (320, 320, 400)


@pytest.mark.parametrize("name", ALL)
def test_streamed_as_they_are(name, tmp_path, monkeypatch):
    """From homing to M30, with the tool changes acknowledged."""
    path = tmp_path / "part.nc"
    path.write_text(ALL[name])
    assert compiler.detect_dialect(path)[0] == "plain"
    running = Running("fast")

    class Panel(stream.Panel):
        def poll_keys(self):
            super().poll_keys()
            if running.app.controller.state == "hold":
                self.press_key("r")

    monkeypatch.setattr(stream, "Panel", Panel)
    try:
        with GrblClient(running.line.name) as client:
            client.connect()
            client.command("$H", 60)
            client.command("G10L20P1X-30Y-40Z40")
        stream.stream(path, running.line.name, 115200, "count", False, False, None, 30.0)
        assert not running.app.controller.machine.alarm and running.app.controller.queue.still()
    finally:
        running.close()


@pytest.mark.parametrize("name", ALL)
def test_the_board_goes_where_the_listing_goes(name, tmp_path):
    """The firmware's cycles and the compiler's lines go to the same lowest and highest places, by the same path."""
    path = tmp_path / "part.nc"
    path.write_text("".join(row for row in ALL[name].splitlines(True) if "G53" not in row and "G43" not in row and "G49" not in row))
    plain, made = VirtualJob("router_3axis"), VirtualJob("router_3axis")
    plain.run(gcode_file.file_lines(path))
    program = compiler.compile_file(path, "ngc", start=(0.0, 0.0, 0.0))
    made.run(program.rows())
    assert plain.errors == made.errors == []
    assert plain.low == pytest.approx(made.low, abs=0.004) and plain.high == pytest.approx(made.high, abs=0.004)
    assert plain.seconds == pytest.approx(made.seconds, rel=0.02)
    lowest = min(event[-1][2] for event in events(program.listing.codes, (0.0, 0.0, 0.0)) if event[0] in ("rapid", "feed"))
    assert made.low[2] == pytest.approx(lowest, abs=0.004)


def test_tool_lengths():
    """G43 H1 Z15 goes to 15 mm above zero with that tool's length; a table survives a reset, and an unknown tool is refused."""
    with Running("fast") as running:
        with GrblClient(running.line.name) as client:
            client.connect()
            client.command("$X")
            client.command("G43 H7")
            client.command("G10 L1 P1 Z12.5")
            client.command("G10 L1 P2 Z3")
            client.command("G0 G43 H1 Z5")
            running.until(lambda: running.position()[2] == 17.5 * STEPS_MM[2])
            with pytest.raises(Refused, match="error 39"):
                client.command("G43 H7")
            client.command("G43 H2 Z0")
            running.until(lambda: running.position()[2] == 3 * STEPS_MM[2])
            running.until(lambda: running.app.controller.state == "idle")
            assert {"[T1:12.500]", "[T2:3.000]", "[TLO:3.000]"} <= set(client.command("$#"))
            client.reset()
            client.command("$X")
            said = client.command("$#")
            assert "[T1:12.500]" in said and "[TLO:0.000]" in said
            client.command("G49 G0 Z1")
            running.until(lambda: running.position()[2] == STEPS_MM[2])


def test_a_cycle_is_held_and_goes_on():
    """Between two pecks too: nothing of the hole is lost."""
    with Running("real") as running:
        with GrblClient(running.line.name) as client:
            client.connect()
            client.command("$X")
            client.command("G91")
            client._write_bytes(b"G99 G83 X1 Z-2.5 R1 Q0.5 F1500\n")
            running.until(lambda: running.world.steps > 900)
            client.real_time(b"!")
            running.until(running.standing)
            client.real_time(b"~")
            running.until(lambda: running.position() == [320, 0, 400] and running.app.controller.state == "idle")
            client.command("G0 X1")
            running.until(lambda: running.position() == [640, 0, 400])


def test_a_cycle_beyond_the_travel_does_not_begin():
    with Running("fast") as running:
        with GrblClient(running.line.name) as client:
            client.connect()
            client.command("$H", 60)
            client.command("$20=1")
            start = running.position()
            with pytest.raises(Refused, match="alarm 2"):
                client.command("G91 G99 G83 X100 Z-10 R-2 Q1 F100 L9")
            assert running.position() == start

"""The torch manipulator on the emulated Pico: moves whose axes run on their own, how soon they set out, stop, counts."""

from statistics import median

from emulated import make_machine, uf2  # noqa: F401

from passo.protocols.torch import protocol as torch

BYTE_MS = 10 / 115.2
UP_LIMIT_MS = 4000
LATEST_MS = 6  # as a rule, of which up to 3 until the feeder looks; now and then a collection of garbage comes in between


def until_up(machine):
    begun = machine.now_ms()
    while machine.now_ms() < begun + UP_LIMIT_MS:
        machine.take()
        machine.send(torch.frame("INFO"))
        machine.run_ms(50)
        if machine.take()[:1] == b"\xbb":
            machine.run_ms(20)  # the rest of that answer
            machine.take()
            return
    raise AssertionError(f"no answer within {UP_LIMIT_MS} ms")


def steps_of(rows, axis):
    """Microseconds of each step of an axis in consecutive rows of a trace."""
    return [row[0] for before, row in zip(rows, rows[1:]) if row[1 + axis] != before[1 + axis]]


def worst_us(rows, count, rate):
    """How far a step of three axes, of which each makes `count` at `rate` a second, is off its time, in microseconds."""
    worst = 0
    for axis in range(3):
        times = steps_of(rows, axis)
        assert len(times) == count
        worst = max(worst, *[abs(us - times[0] - i * 1e6 / rate) for i, us in enumerate(times)])
    return worst


def test_moves_on_the_pico(make_machine, show):
    machine = make_machine("torch_manipulator")
    until_up(machine)
    machine.send(torch.frame("CONNECT"))
    machine.run_ms(70)
    latencies = []
    place = [0, 0]
    for x, x_speed, y, y_speed in ((10, 480, 14, -830), (20, -1000, 60, 3001), (200, 4800, 300, -8300)):
        known = len(machine.trace.rows()) - 1
        data = torch.move(x, x_speed, y, y_speed)
        begun = machine.now_ms()
        machine.send(data)
        machine.run_ms(70)
        rows = machine.trace.rows()[known:]
        latencies.append(rows[1][0] / 1000 - begun - len(data) * BYTE_MS)
        for axis, count, speed in ((0, x, x_speed), (1, y, y_speed)):
            times = steps_of(rows, axis)
            place[axis] += count if speed > 0 else -count
            assert len(times) == count
            for i, us in enumerate(times):
                assert abs(us - times[0] - i * 1e6 / abs(speed)) < 11
    machine.send(torch.frame("INFO") + torch.passo(torch.STATUS_OF))
    machine.run_ms(20)
    said = machine.take()
    assert said[:10] == torch.answer("INFO", 200, -300)
    status = torch.answer_from(said[10:])[1]
    assert [status["x"], status["y"]] == place and status["error"] == 0
    assert status["dropped"] <= 1  # a frame that was under way as the UART was opened
    machine.send(torch.move(4000, 4800, 4000, 8300))
    machine.run_ms(60)
    machine.send(torch.frame("STOP"))
    machine.run_ms(20)
    x, y = torch.answer_from(machine.take())[1].values()
    rows = machine.trace.rows()
    assert list(rows[-1][1:3]) == [place[0] + x, place[1] + y] and machine.plant.errors == []
    assert median(latencies) < LATEST_MS
    show(
        "the torch manipulator on the Pico",
        "from a move's last byte to its first step "
        f"{', '.join(f'{ms:.1f}' for ms in latencies)} ms; {machine.now_ms() / 1000:.1f} s emulated in all",
    )

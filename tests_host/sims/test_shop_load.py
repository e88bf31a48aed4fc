"""Ten machines and a hundred jobs, while agents, broker, network and power fail: each job is drawn once. More: shop_load.py by hand."""

import pytest
import shop_load

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1200), pytest.mark.skipif(not shop_load.MOSQUITTO, reason="there is no Mosquitto: apt-get install mosquitto")]


def test_each_job_is_drawn_exactly_once(tmp_path):
    load = shop_load.Load(tmp_path, 10, 100, parted_s=15)
    try:
        faults = [load.kill_agent] * 10 + [load.kill_broker] * 3 + [load.part] + [load.cut_power] * 10
        load.random.shuffle(faults)
        load.run(1000, faults)
        twice = shop_load.check(load)
        assert twice <= 10 * 50 * shop_load.STEPS_MM  # behind each power cut a second's way at most
    finally:
        load.close()


@pytest.mark.parametrize("strokes, numbers, faults", [
    ([(50 + 30 * bit, 50, 150 if 5 >> bit & 1 else 100) for bit in range(10)], [5], 0),
    ([(50 + 30 * bit, 50, 100) for bit in range(9)], [0], 1),
    ([(50 + 30 * bit, 50, 100) for bit in (0, 1, 3)], [0], 1),
    ([(50 + 30 * bit, 50, 100) for bit in range(10)] * 2, [0, 0], 0),
    ([*[(50 + 30 * bit, 50, 100) for bit in range(5)], None, *[(50 + 30 * bit, 50, 100) for bit in range(3, 10)]], [0], 0),
    ([*[(50 + 30 * bit, 50, 100) for bit in range(5)], *[(50 + 30 * bit, 50, 100) for bit in range(3, 10)]], [0], 1),
    ([*[(50 + 30 * bit, 50, 100) for bit in range(5)], None, *[(50 + 30 * bit, 50, 150) for bit in range(3, 10)]], [1016], 1),
    ([*[(50 + 30 * bit, 50, 100) for bit in range(10)], None, *[(50 + 30 * bit, 50, 100) for bit in range(10)]], [0, 0], 0),
    ([*[(50 + 30 * bit, 50, 100) for bit in range(4)], (170, 50, 70), None, *[(50 + 30 * bit, 60, 150) for bit in range(4, 5)], *[(50 + 30 * bit, 50, 100) for bit in range(5, 10)]], [16], 0),
])  # fmt: skip
def test_the_counter_sees_what_is_missing_and_what_is_there_twice(strokes, numbers, faults):
    found = shop_load.read_numbers(strokes)
    assert found[0] == numbers and (len(found[2]) > 0) == bool(faults)

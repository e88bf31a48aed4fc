"""The code that runs in an interrupt, with integers as narrow as a board's: none of it may reach 2³⁰.

The rooms' arrays are replaced by lists that only hold and give `Small` integers, which raise where a board would
allocate memory.
"""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from passo.motion import line, planner
from passo.motion.line import MAX_STEPS
from passo.motion.planner import Block
from passo.options.independent import motion as independent
from passo.options.step_program import motion as step_program
from passo.options.step_program import motion_walker as step_program_walker
from passo.records import COUNT_MASK, ENDLESS, FEED_OLDEST, FEED_POSITION, FEED_TICKS, MARK_FIELDS, MARK_TICKS
from passo.steps import position, power, ring
from rig import DRIVES, LEAST_TICKS, Rig
from small_int import Small


class SmallList(list):
    """Stands for array("i") and array("I")."""

    def __init__(self, code, values):
        whole = [0] * (len(values) // 4) if isinstance(values, bytearray) else values
        super().__init__(Small(value) for value in whole)

    def __setitem__(self, index, value):
        super().__setitem__(index, Small(value))


class SmallView:
    """Stands for memoryview of a SmallList."""

    def __init__(self, items, first=0):
        self._items = items
        self._first = first

    def __getitem__(self, index):
        if isinstance(index, slice):
            return SmallView(self._items, self._first + index.start)
        return self._items[self._first + index]

    def __setitem__(self, index, value):
        self._items[self._first + index] = value


@pytest.fixture(autouse=True, scope="module")
def narrow():
    """Every array that the interrupt code reads or writes is narrow."""
    stands_in = {
        "array": SmallList,
        "zeros": lambda count: SmallList("i", [0] * count),
        "numbers": lambda count: SmallList("I", range(count)),
    }
    with pytest.MonkeyPatch.context() as patch:
        for module in (line, planner, position, power, ring, independent, step_program, step_program_walker):
            found = [name for name in stands_in if name in vars(module)]
            assert found, module
            for name in found:
                patch.setattr(module, name, stands_in[name])
        for module in (line, planner):
            patch.setattr(module, "memoryview", SmallView, raising=False)
        yield


def small_rig(drive, axes=3):
    rig = Rig(drive, axes)
    rig.planner._under_way.__class__ = SmallBlock
    return rig


class SmallBlock(Block):
    def __setattr__(self, name, value):
        super().__setattr__(name, Small(value) if type(value) is int else value)


def play(rig, milliseconds):
    """Fill and play as an interrupt would; the words themselves are Small."""
    rig.feeder.fill(Small(rig.played), Small(milliseconds * 12_500))
    words = 0
    while rig.played != rig.ring.head:
        assert rig.ring.words[rig.played & rig.ring.mask] >= 0
        rig.played = Small((rig.played + 1) & COUNT_MASK)
        words += 1
    return words


@given(
    st.sampled_from(sorted(DRIVES)),
    st.tuples(*[st.integers(-MAX_STEPS, MAX_STEPS)] * 3),
    st.integers(2 * LEAST_TICKS, 0x1FFFFFFE),
    st.integers(0, COUNT_MASK),
)
@settings(max_examples=60)
def test_no_line_reaches_a_wide_integer(drive, deltas, each, count):
    rig = small_rig(drive, 3 if drive == "step_dir" else 2)
    deltas = deltas[: rig.layout.axes]
    if not any(deltas):
        return
    rig.ring.head = rig.played = Small(count)
    rig.feeder._reset(Small(count))
    total = max(map(abs, deltas))
    rig.planner.line(deltas, total * each + total // 3, True)
    rig.planner.wait(0x1FFFFFFF, False)
    rig.planner.flush()
    for _ in range(20):
        play(rig, 10)


def test_counters_wrap():
    rig = small_rig("unipolar half", 2)
    rig.ring.head = rig.played = Small(COUNT_MASK - 40)
    rig.feeder._reset(rig.played)
    state, marks = rig.feeder.state, rig.feeder.marks
    state[FEED_TICKS] = COUNT_MASK - 5000
    marks[state[FEED_OLDEST] * (MARK_FIELDS + 2) + MARK_TICKS] = state[FEED_TICKS]
    state[FEED_POSITION] = (1 << 28) - 20
    rig.planner.line((100, -37), 100 * 3000, False)
    rig.planner.flush()
    words = 0
    while not rig.planner.empty():
        words += play(rig, 10)
        rig.feeder.retire(rig.played)
    assert words == 100
    assert list(rig.feeder.position(rig.played)) == [(1 << 28) - 20 + 100 - (1 << 29), -37]


def test_axes_that_turn_for_ever():
    rig = small_rig("unipolar half", 2)
    axes = independent.IndependentAxes(2, LEAST_TICKS)
    axes.run_axis(0, ENDLESS, 0x1FFFFFFE, 2, 3)
    axes.run_axis(1, ENDLESS, 2 * LEAST_TICKS, 5, 7, negative=True)
    rig.planner.walk(axes, False)
    rig.planner.flush()
    assert sum(play(rig, 10) for _ in range(60)) > 1000


@given(
    st.lists(
        st.one_of(
            st.builds(step_program.run, st.integers(1, 7), st.integers(0, 7), st.integers(1, step_program.MOST)),
            st.builds(step_program.make_mark, st.sampled_from((step_program.DWELL, step_program.TOOL, step_program.SPEED)), st.integers(1, step_program.MOST)),
        ),
        min_size=1,
        max_size=30,
    ),
    st.booleans(),
)
@settings(max_examples=40)
def test_no_step_program_reaches_a_wide_integer(items, backward):
    rig = small_rig("step_dir")
    path = step_program.StepProgram(3, 64)
    path.clear_items(1)
    for item in items:
        path.append(Small(item))
    lengths = SmallList("i", [0] + [0x3FC00000] * 7)
    walker = step_program_walker.StepProgramWalker(path, lengths, SmallList("i", [0x1FFFFFFF] * 2))
    walker.go_to_start()
    if backward:
        walker.cell = path.end
        walker.index = path.total
    for _ in range(4):
        walker.gap = Small(0)
        walker.begin(backward)
        rig.planner.clear()
        rig.planner.walk(walker, walker.tool)
        rig.planner.flush()
        for _ in range(5):
            play(rig, 10)
            walker.gap = Small(min(walker.gap, 3000))
        rig.feeder.cancel(rig.played)


def test_the_stand_in_would_notice():
    words = SmallList("I", [0])
    with pytest.raises(OverflowError):
        words[0] = 1 << 30
    with pytest.raises(OverflowError):
        words[0] = Small(1 << 20) * (1 << 12)
    from passo.options.drive_unipolar import drive as unipolar

    assert bytes(unipolar.MODES["half"])

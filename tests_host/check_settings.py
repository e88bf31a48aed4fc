"""Settings: bounds, defaults, and a power cut at every byte of a write."""

from boards.plotter_2014 import BOARD as PLOTTER
from boards.router_3axis import BOARD
from passo.control import settings as table
from passo.control.boardfile import check
from passo.control.journal import Journal, MemorySlots
from passo.control.settings import Settings
from passo.protocols import errors
from draws import Random

CASES = {
    "check_changes_come_back": (("changes", "list", 20, ("pick", 0, 40), ("value", -5, 1_000_000_000)),),
    "check_noise_in_both_slots": (("first", "bytes", 60), ("second", "bytes", 60)),
    "check_flipped_bits": (("seed", "seed"),),
}


class CutSlots(MemorySlots):
    """The power goes after `left` bytes of a write; what the slot holds then depends on the file system."""

    def __init__(self, slots, left, manner):
        MemorySlots.__init__(self)
        self.data = slots.data[:]
        self._left = left
        self._manner = manner

    def write(self, slot, data):
        old = self.data[slot]
        new = data[: self._left]
        if self._manner == "overwritten":  # the rest of the old bytes is still there
            new += old[self._left :]
        elif self._manner == "erased":  # room was made for all of it, as flash memory reads when empty
            new += b"\xff" * (len(data) - len(new))
        self.data[slot] = new


def make(slots, board=BOARD, fastest=1_000_000):
    return Settings(check(board), Journal(slots), fastest)


def state(settings):
    return [settings.value(number) for number in settings.numbers] + [settings.get("G54"), settings.get("N0")]


def check_power_cut_at_every_byte():
    """Old or new, never a mixture, never a failure to boot, and the machine can be set again afterwards."""
    slots = MemorySlots()
    settings = make(slots)
    for number, value, offset in ((110, 1_000_000, "1,2,3"), (111, 2_000_000, "4,5,6"), (110, 3_000_000, "7,8,9")):
        old = state(settings)
        settings.change(number, value)
        settings.put("G54", offset)
        new = state(settings)
        after = MemorySlots()
        after.data = slots.data[:]
        done = make(after)
        done.change(number, value)
        done.put("G54", offset)
        assert done.save() == 0
        length = max([len(data) for data in after.data]) + 1
        for manner in ("truncated", "overwritten", "erased"):
            for left in range(length):
                cut = CutSlots(slots, left, manner)
                writer = make(cut)
                writer.change(number, value)
                writer.put("G54", offset)
                writer.save()
                rest = MemorySlots()
                rest.data = cut.data
                booted = make(rest)
                assert state(booted) in (old, new), (manner, left)
                assert not booted.damaged or slots.data == [b"", b""]
                booted.change(112, 4_000_000 // 8)
                assert booted.save() == 0
                assert make(rest).value(112) == 500_000
        settings.save()
    assert state(make(slots)) == new


def check_noise_in_both_slots(first, second):
    slots = MemorySlots()
    slots.data = [first, second]
    settings = make(slots)
    assert settings.value(110) == 5_000_000
    assert settings.damaged == (len(first) + len(second) > 0)
    settings.change(110, 7_000)
    assert settings.save() == 0
    assert make(slots).value(110) == 7_000


def check_flipped_bits(seed):
    """One flipped bit in the newest slot: the one before it counts."""
    random = Random(seed)
    slots = MemorySlots()
    settings = make(slots)
    settings.change(110, 1_000)
    settings.save()
    settings.change(110, 2_000)
    settings.save()
    newest = 0 if b"=2000" in slots.data[0] else 1
    data = bytearray(slots.data[newest])
    data[random.between(0, len(data) - 1)] ^= 1 << random.between(0, 7)
    slots.data[newest] = bytes(data)
    assert make(slots).value(110) == 1_000


def check_changes_come_back(changes):
    slots = MemorySlots()
    settings = make(slots)
    for pick, value in changes:
        number = settings.numbers[pick % len(settings.numbers)]
        before = settings.value(number)
        error = settings.change(number, value)
        assert settings.value(number) == (before if error else value)
    assert settings.save() == 0
    assert state(make(slots)) == state(settings)


def check_refusals():
    settings = make(MemorySlots(), fastest=100_000)
    for number, value, error in (
        (7, 1, errors.STATEMENT), (103, 1, errors.STATEMENT), (110, -1, errors.NEGATIVE),
        (0, 2, errors.STEP_PULSE), (32, 1, errors.LASER_WITHOUT_PWM), (22, 2, errors.SETTING_RANGE),
        (100, 0, errors.SETTING_RANGE), (110, 50_000_000, errors.STEP_RATE), (100, 9_000_000, errors.STEP_RATE),
        (22, 0, 0), (20, 1, errors.LIMITS_NEED_HOMING), (20, 0, 0), (22, 1, 0), (20, 1, 0), (0, 10, 0),
    ):
        assert settings.change(number, value) == error, (number, value)
    board = check(PLOTTER)
    board["homing"] = None
    settings = Settings(board, Journal(MemorySlots()))
    assert settings.change(22, 1) == errors.NO_HOMING and settings.value(22) == 0


def check_the_board_follows():
    board = check(BOARD)
    settings = Settings(board, Journal(MemorySlots()))
    assert [axis["travel_steps"] for axis in board["axes"]] == [96000, 64000, 32000]
    assert settings.homing(0) == (8000, 400, 640)
    settings.change(100, 160_000)
    settings.change(130, 100_000)
    assert board["axes"][0]["steps_per_m"] == 160_000 and board["axes"][0]["travel_steps"] == 16_000
    settings.change(25, 600_000)
    settings.change(27, 2_000)
    assert settings.homing(0) == (1600, 400, 320) and settings.homing(2) == (4000, 400, 800)
    settings.restore(True, 0)
    assert board["axes"][0]["steps_per_m"] == 320_000 and board["axes"][0]["travel_steps"] == 96_000


def check_defaults_are_not_kept():
    slots = MemorySlots()
    settings = make(slots)
    settings.change(110, 1_000)
    settings.put("x_new", "of a later firmware")
    settings.save()
    assert make(slots, PLOTTER).value(110) == 1_000 and make(slots, PLOTTER).value(111) == 6_000_000
    again = make(slots)
    again.change(111, 2_000)
    again.save()
    assert make(slots).get("x_new") == "of a later firmware"
    again.restore(True, 2)
    again.save()
    assert make(slots).value(110) == 5_000_000 and make(slots).get("x_new") is None


def check_texts_are_bounded():
    settings = make(MemorySlots())
    for key, text in (("N0", "x" * 81), ("N0", "G0\nG1"), ("a=b", "c")):
        try:
            settings.put(key, text)
        except ValueError:
            continue
        raise AssertionError("kept")


def check_a_full_memory_is_told():
    class Full(MemorySlots):
        def write(self, slot, data):
            raise OSError(28)

    settings = make(Full())
    settings.change(110, 1_000)
    assert settings.save() == errors.MEMORY and settings.dirty


def check_every_setting_has_a_name():
    settings = make(MemorySlots())
    names = [settings.name(number) for number in settings.numbers]
    assert len(set(names)) == len(names) and settings.places(7) is None
    assert settings.name(table.SPEED + 2) == "z_max" and settings.places(table.LASER) == 0

"""Settings: bounds, defaults, and a power cut at every byte of a write."""

from boards.plotter_2014 import BOARD as PLOTTER
from boards.router_3axis import BOARD
from passo import errors, machine_builder
from passo.config import setting_numbers as table
from passo.config.boardfile import check
from passo.config.journal import Journal, MemorySlots
from passo.config.setting_numbers import longest_pulse_us
from passo.config.settings import MASKS, Settings
from passo.steps.wiring import inversion_mask
from passo.steps.word import TICKS_PER_S, Layout, us_to_ticks
from draws import Random

CASES = {
    "check_old_masks_are_converted": (("seed", "seed"),),
    "check_changes_come_back": (("changes", "list", 20, ("pick", 0, 40), ("value", -5, 1_000_000_000)),),
    "check_noise_in_both_slots": (("first", "bytes", 60), ("second", "bytes", 60)),
    "check_flipped_bits": (("seed", "seed"),),
}
NOT_QUICK = ("check_power_cut_at_every_byte", "check_a_pulse_leaves_room_for_the_speeds")


class CutSlots(MemorySlots):
    """The power goes after `left` bytes of a write; the slot's contents then depend on the file system."""

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
    return Settings(check(board), Journal(slots), steps_s=fastest)


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
        (22, 0, 0), (20, 1, errors.LIMITS_NEED_HOMING), (20, 0, 0), (22, 1, 0), (20, 1, 0), (0, 10, 0), (0, 100, errors.SETTING_RANGE),
    ):
        assert settings.change(number, value) == error, (number, value)
    board = check(PLOTTER)
    board["homing"] = None
    settings = Settings(board, Journal(MemorySlots()))
    assert settings.change(22, 1) == errors.NO_HOMING and settings.value(22) == 0


def check_a_pulse_leaves_room_for_the_speeds():
    """The board starts with the kept pulse, and all speeds are then within its reach. A kept pulse that is too long is forgotten."""
    longest = longest_pulse_us(check(BOARD))
    assert 10 < longest < 100
    for kept in range(3, 101):
        slots = MemorySlots()
        settings = make(slots)
        error = settings.change(0, kept)
        if not error:
            assert settings.save() == 0
        else:
            assert error == (errors.STEP_RATE if kept <= longest else errors.SETTING_RANGE)
            Journal(slots).write("0=%d" % kept)
        board = check(BOARD)
        started = Settings(board, Journal(slots))
        least = 2 * us_to_ticks(board["drive"]["pulse_us"])
        machine_builder.check_speed(board, least)
        if not error:
            assert board["drive"]["pulse_us"] == kept
            for axis in range(3):
                assert started.value(100 + axis) * started.value(110 + axis) <= TICKS_PER_S // least * 60_000_000, kept
    settings = make(MemorySlots())
    assert settings.change(0, longest) == errors.STEP_RATE and settings.change(110, 4_000_000) == settings.change(111, 4_000_000) == 0
    assert settings.change(0, longest) == 0, "slower axes have time for more"
    most_um_min = TICKS_PER_S // (2 * us_to_ticks(longest)) * 60_000_000 // settings.value(100)
    assert settings.change(110, most_um_min + 1) == errors.STEP_RATE, "a kept pulse counts with the next start"
    assert settings.change(110, most_um_min) == 0


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


LIMITS = ("limit_x", "limit_y", "limit_z")


def any_board(random):
    """A router wired, mounted and switched in any way."""
    board = check(BOARD)
    board["drive"]["step_active"] = random.between(0, 1)
    for axis in board["axes"]:
        axis["reversed"] = bool(random.between(0, 1))
    level = random.between(0, 1)
    for item in board["inputs"]:
        item["active"] = level if item["name"] in LIMITS else random.between(0, 1)
    for item in board["outputs"]:
        item["active"] = random.between(0, 1)
    board["homing"]["high_end"] = "".join([name for name in "xyz" if random.between(0, 1)])
    return board


def wired(board, settings):
    """Return the levels that count at the pins: (STEPs whose pulse is low, DIRs that are high in the positive direction, the active levels of enable,
    limits and probe, axes that home low), each from its own source.
    """
    layout = Layout("step_dir", 3, 6, [], 7)
    pins = inversion_mask(board, layout)
    named = {}
    for item in board["inputs"] + board["outputs"]:
        named[item["name"]] = item["active"]
    levels = []
    for number, name in ((table.ENABLE_INVERT, "enable"), (table.LIMIT_INVERT, "limit_x"), (table.PROBE_INVERT, "probe")):
        levels.append(named[name] ^ settings.mask_change(number))
    ends = 0
    for axis in range(3):
        ends |= (0 if "xyz"[axis] in board["homing"]["high_end"] else 1) << axis
    return (pins & 7, ~pins >> 3 & 7) + tuple(levels) + (ends,)


def check_masks_mean_what_they_mean_in_grbl():
    """For any board file: the mask reported is that of the pins, and a mask set is theirs from then on."""
    for seed in range(20):
        random = Random(seed)
        board = any_board(random)
        settings = Settings(board, Journal(MemorySlots()))
        for _ in range(3):
            assert tuple([settings.value(number) for number in MASKS]) == wired(board, settings)
            for number in MASKS:
                assert settings.change(number, random.between(0, 7) & settings._table[number][4]) == 0
    settings = Settings(check(BOARD), Journal(MemorySlots()))
    assert settings.masks() == [(2, 0), (3, 7), (4, 0), (5, 1), (6, 0), (23, 3)]
    settings = Settings(check(PLOTTER), Journal(MemorySlots()))
    assert [settings.value(number) for number in (2, 4, 5, 6, 23)] == [0, 0, 1, 0, 3]


def check_old_masks_are_converted(seed):
    """Settings that the first firmware has kept, which said what differs from the board file: nothing changes at the pins."""
    random = Random(seed)
    state = random.between(0, 1 << 20)
    board = any_board(Random(state))
    bare = Settings(any_board(Random(state)), Journal(MemorySlots()))
    before = wired(any_board(Random(state)), bare)
    old = [(number, random.between(0, 7) & bare._table[number][4]) for number in MASKS if random.between(0, 1)]
    slots = MemorySlots()
    Journal(slots).write("\n".join(["%d=%d" % item for item in old] + ["110=1234", "G54=1,2,3"]))
    changes = dict(old)
    wanted = tuple([before[at] ^ changes.get(MASKS[at], 0) for at in range(len(MASKS))])
    for _ in range(3):  # as it is read, as it has been written since, and with a change
        settings = Settings(board, Journal(slots))
        assert wired(board, settings) == wanted and settings.value(110) == 1234 and settings.get("G54") == "1,2,3"
        settings.save()
        board = any_board(Random(state))
    settings.change(111, 5_000)
    settings.save()
    again = Settings(board, Journal(slots))
    assert wired(board, again) == wanted and again.value(111) == 5_000
    assert not [line for line in Journal(slots).read().split("\n") if line.split("=")[0] in ("2", "3", "4", "5", "6", "23")]


def check_masks_of_both_firmwares():
    """A board that ran the old firmware again: its slot has the new masks, and the values that the old firmware wrote since count."""
    slots = MemorySlots()
    settings = make(slots)
    settings.change(23, 7)
    settings.change(3, 1)
    settings.save()
    text = Journal(slots).read()
    assert text == "2:3=1\n2:23=7"
    Journal(slots).write(text + "\n23=1")
    assert make(slots).value(23) == 2 and make(slots).value(3) == 1


def check_mixed_limits():
    """Switches of both kinds: $5 is the first one's, and turns all of them round."""
    board = check(BOARD)
    board["inputs"][1]["active"] = 0
    settings = Settings(board, Journal(MemorySlots()))
    assert settings.value(5) == 1 and settings.mask_change(5) == 0
    settings.change(5, 0)
    assert settings.mask_change(5) == 1


def check_the_release_is_told():
    board = check(BOARD)
    for ms, told in ((0, 255), (30, 30), (254, 254), (5000, 254)):
        board["idle_release_ms"] = ms
        settings = Settings(board, Journal(MemorySlots()))
        assert settings.value(1) == told and board["idle_release_ms"] == ms


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

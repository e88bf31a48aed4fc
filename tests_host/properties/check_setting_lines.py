"""Settings in the words of every language: set, the power off and on again: kept, and nothing of the documents' bytes has changed."""

from asked_settings import BOARDS, SettingBoard, frames_of
from draws import Random
from passo import errors
from passo.config.journal import Journal, MemorySlots
from passo.options.step_program.errors import NO_STEP_PROGRAM
from passo.protocols.setting_lines import decimal_text, parse_thousandths
from passo.protocols.torch import protocol as torch
from passo.protocols.typed_words import TypedWords, line_of

CASES = {
    "check_decimals": (("value", -999_999_999, 999_999_999),),
    "check_kept_over_power_off": (("seed", "seed"),),
    "check_a_lost_character_sets_nothing": (("seed", "seed"),),
    "check_noise_of_lines": (("noise", "bytes", 60),),
    "check_old_settings_are_taken_over": (("seed", "seed"),),
}
RUNS = {"check_kept_over_power_off": 6, "check_a_lost_character_sets_nothing": 10, "check_old_settings_are_taken_over": 6}
NAMES = tuple(sorted(BOARDS))
OWN = tuple([name for name in NAMES if name != "router_3axis"])  # boards without lines of their own


def check_decimals(value):
    assert parse_thousandths(decimal_text(value, 3)) == value
    assert parse_thousandths("%d" % value) == 1000 * value
    for wrong in ("", "-", ".", "1.2345", "1e3", " 1", "1 ", "--1", "+1", "0x1", "1.2.3", "1234567890"):
        assert parse_thousandths(wrong) is None, wrong


def check_every_board_tells_its_settings():
    for name in OWN:
        board = SettingBoard(name)
        numbers, ok = board.say("$")
        assert ok == "ok" and numbers == "[$:%s]" % ",".join([str(number) for number in board.settings.numbers])
        for number in board.settings.numbers:
            told = "$%d=%s" % (number, decimal_text(board.settings.value(number), board.settings.places(number)))
            assert board.say("$%d" % number) == [told, "ok"], (name, number)


def check_what_the_windows_had():
    """The documents' own numbers, by the board files."""
    for name, values in (
        ("torch_manipulator", ((100, "48.000"), (101, "83.000"), (150, "1.000"), (151, "1.000"), (170, "600.000"), (171, "600.000"))),
        ("plotter_2014", ((100, "10.000"), (150, "1.000"), (151, "1.000"), (180, "1000"))),
        ("lpt_router", ((100, "80.000"), (181, "312"), (182, "1200"))),
        ("two_motor_kit", ((100, "1.111"), (101, "1.111"))),
    ):
        board = SettingBoard(name)
        for number, value in values:
            assert board.say("$%d" % number) == ["$%d=%s" % (number, value), "ok"], (name, number)


def values_of(settings):
    return [settings.value(number) for number in settings.numbers]


def any_changes(board, random, most=6):
    """Lines that set some of a board's settings to values within their bounds."""
    for _ in range(random.between(1, most)):
        number = board.settings.numbers[random.between(0, len(board.settings.numbers) - 1)]
        _, places, default, least, highest = board.settings._table[number]
        value = max(least, min(highest, default + random.between(-default // 4 - 1, default // 4 + 1)))
        yield number, "$%d=%s" % (number, decimal_text(value, places))


def check_kept_over_power_off(seed):
    random = Random(seed)
    for name in NAMES:
        board = SettingBoard(name)
        for number, line in any_changes(board, random):
            before = values_of(board.settings)
            said = board.say(line)
            assert said[-1] == "ok" or said[-1][:6] == "error:" and values_of(board.settings) == before, (name, line, said)
            if said[-1] == "ok" and name in OWN:
                assert said == [line, "ok"], said
        after = values_of(board.settings)
        again = SettingBoard(name, board.slots)
        assert values_of(again.settings) == after, name
        if name in OWN:
            for number in board.settings.numbers:
                assert again.say("$%d=" % number)[-1] == "ok" or number in (20, 22, 100, 101, 102, 110, 111, 112), (name, number)


def check_the_board_files_value_again():
    for name in OWN:
        board = SettingBoard(name)
        old = board.say("$100")
        assert board.say("$100=77.125") == ["$100=77.125", "ok"] and board.say("$100=") == old
        assert SettingBoard(name, board.slots).say("$100") == old
        assert "100=" not in (Journal(board.slots).read() or "")


def check_refusals_are_numbered():
    for name in OWN:
        board = SettingBoard(name)
        before = values_of(board.settings)
        for line, error in (
            ("$999", errors.STATEMENT), ("$100=x", errors.NUMBER), ("$=", errors.STATEMENT), ("$100=0", errors.SETTING_RANGE),
            ("$26=1.5", errors.NOT_INTEGER), ("$0=2", errors.STEP_PULSE), ("$100=99999", errors.STEP_RATE), ("$100=-1", errors.NEGATIVE),
        ):  # fmt: skip
            if "x" in line and board.language in ("keys", "torch"):
                continue  # which have no such letter
            assert board.say(line) == ["error:%d" % error], (name, line)
        assert values_of(board.settings) == before


def check_position_is_lost_with_steps_mm():
    board = SettingBoard("plotter_2014")
    for line, known in (("$110=5000", True), ("$150=2", True), ("$100=10", True), ("$100=10.5", False), ("$101=9", False)):
        board.machine.homed, board.machine.known = True, 3
        assert board.say(line)[-1] == "ok" and board.machine.homed == known, line
    assert not board.machine.known


def check_only_at_a_stand_with_the_tool_off():
    board = SettingBoard("torch_manipulator")
    board.hear(torch.frame("CONNECT"), 200)
    board.hear(torch.move(4800, 480, 0, 0), 100)
    assert board.machine.state == "run"
    assert board.say("$100=48.5") == ["error:%d" % errors.BUSY] and board.say("$100") == ["$100=48.000", "ok"]
    board.hear(torch.frame("STOP"), 100)
    assert board.say("$100=48.5") == ["$100=48.500", "ok"]
    board = SettingBoard("lpt_router")
    board.hear(b"{tool on}", 100)
    assert board.say("$100=81") == ["error:%d" % errors.TOOL_ON]
    board.hear(b"{tool off}", 100)
    assert board.say("$100=81") == ["$100=81.000", "ok"]


def check_the_torchs_jogs():
    """The document's CONFIGURE is kept; steps a jog are steps/mm × mm a jog, as its window had it."""

    def jogs(board):
        command = board.app.links[0].protocol._jog_command(0, 1)
        return command.steps[0], command.rates[0][0]

    board = SettingBoard("torch_manipulator")
    assert jogs(board) == (48, 480)
    board.hear(torch.configure(31, 41, 300, 400), 100)
    assert jogs(board) == (31, 300)
    board = SettingBoard("torch_manipulator", board.slots)
    assert jogs(board) == (31, 300) and board.say("$171") == ["$171=289.157", "ok"]
    assert board.say("$150=2")[-1] == "ok" and jogs(board) == (96, 300)
    assert board.say("$100=50")[-1] == "ok" and jogs(board) == (100, 313)
    assert board.say("$150=")[-1] == "ok" and jogs(board) == (50, 313)


def check_the_plotters_jog_and_speed():
    board = SettingBoard("plotter_2014")
    drawing = board.app.controller.features["drawing"]
    assert drawing.speed == 1000 and board.say("$180=700")[-1] == "ok" and drawing.speed == 700
    assert board.say("$151=0.5")[-1] == "ok"
    board.hear(bytes((0x38, 0, 0, 0, 0, 0x38)), 500)  # UP
    assert board.app.controller.position() == [0, 5]
    board = SettingBoard("plotter_2014", board.slots)
    assert board.app.controller.features["drawing"].speed == 700


def check_pulses_follow():
    """Interval and steps/mm make the fastest speed; a program that is stored has speeds in it, and is forgotten."""
    board = SettingBoard("lpt_router")
    assert board.hear(b"{load}[$AAAA]{end}", 200).endswith(b"ok 7\n")
    step = board.app.controller.features["step_program"]
    assert step.fastest == 2403
    assert board.say("$26=6")[-1] == "ok"
    board.run_ms(20)
    assert step.program.total == 7
    assert board.say("$181=624")[-1] == "ok"
    assert board.hear(b"{run}") == b"error:%d\n" % NO_STEP_PROGRAM and step.fastest == 1201
    assert board.say("$100=160")[-1] == "ok" and board.say("$182=900")[-1] == "ok"
    assert board.hear(b"{load}[@A$A]{end}", 100).endswith(b"ok 6\n") and step.fastest == 600 and step._default == 600
    assert board.say("$100=0.05") == ["error:%d" % errors.SETTING_RANGE]


def check_a_lost_character_sets_nothing(seed):
    """Of the languages whose bytes have no answers: one character lost, doubled or changed, and the setting stays."""
    random = Random(seed)
    line = line_of("$100=48.125")
    at = random.between(1, len(line) - 2)  # a line that begins twice is that line, and so is one that ends twice
    for hurt in (line[:at] + line[at + 1 :], line[: at + 1] + line[at:], line[:at] + bytes((line[at] ^ 1 << random.between(0, 6),)) + line[at + 1 :]):
        kit, board = SettingBoard("two_motor_kit"), SettingBoard("torch_manipulator")
        kit.hear(hurt, 50)
        assert kit.settings.value(100) == 1111, hurt
        for byte in hurt:
            board.hear(torch.passo(torch.LINE_OF, byte), 10)
        assert board.settings.value(100) == 48_000, hurt
        assert board.say("$100") == ["$100=48.000", "ok"]
        kit.run_ms(2100)
        assert kit.say("$100") == ["$100=1.111", "ok"], hurt


def check_keys_stay_keys():
    """A line that has begun takes no task away; a task ends it. The kit of the document ignores the rest."""
    kit = SettingBoard("two_motor_kit")
    kit.hear(b"$10C", 100)
    protocol = kit.app.links[0].protocol
    assert protocol._is_turning(0) and not protocol.words.is_amid_line()
    kit.hear(b"$100A7", 100)
    assert protocol._speed[0] == 0x37
    assert not [byte for byte in line_of("$100=48.5") if 0x41 <= byte <= 0x4A or byte == 0x3F]


def check_noise_of_lines(noise):
    words = TypedWords()
    for byte in noise + b"$1":
        if words.takes_byte(byte):
            words.take_byte(byte)
        else:
            words.forget_line()
    assert words.is_amid_line() and len(words._text) <= 40


class CutSlots(MemorySlots):
    """The power goes after `left` bytes of a write; the rest of the slot is as it was."""

    def __init__(self, slots, left):
        MemorySlots.__init__(self)
        self.data = slots.data[:]
        self._left = left

    def write(self, slot, data):
        self.data[slot] = data[: self._left] + self.data[slot][self._left :] if self._left < len(data) else data


def check_power_cut_at_every_byte():
    """Of every language's board: the value before or the new one, all others as they were."""
    for name in NAMES:
        board = SettingBoard(name)
        lines = ("$110=1111", "$101=33.5")
        assert board.say(lines[0])[-1] == "ok"
        old = values_of(board.settings)
        kept = board.slots
        done = SettingBoard(name, CutSlots(kept, 1000))
        assert done.say(lines[1])[-1] == "ok"
        new = values_of(done.settings)
        length = max([len(data) for data in done.slots.data])
        seen = []
        for left in range(length + 1):
            slots = CutSlots(kept, left)
            SettingBoard(name, slots).say(lines[1])
            rest = MemorySlots()
            rest.data = slots.data
            after = SettingBoard(name, rest)
            found = values_of(after.settings)
            assert found in (old, new) and not after.settings.damaged, (name, left)
            if found not in seen:
                seen.append(found)
        assert seen == [old, new], name


def check_old_settings_are_taken_over(seed):
    """Settings in flash of the former format: its numbers, none of the new ones, and texts."""
    random = Random(seed)
    for name in NAMES:
        fresh = SettingBoard(name)
        values = {}
        for number in (1, 26, 100, 101, 110, 111, 120, 130):
            default = fresh.settings.value(number)
            values[number] = min(254, default) if number == 1 else max(1, min(default, 999_999_999) - random.between(0, default // 3))
        slots = MemorySlots()
        Journal(slots).write("\n".join(["%d=%d" % item for item in values.items()] + ["G54=1,2,3", "I=mine"]))
        board = SettingBoard(name, slots)
        for number in board.settings.numbers:
            wanted = values.get(number, fresh.settings.value(number))
            assert board.settings.value(number) == wanted, (name, number)
        assert board.settings.get("G54") == "1,2,3" and board.settings.get("I") == "mine"
        assert board.machine.steps_per_m[0] == values[100]


def check_a_line_is_its_frames():
    assert b"".join(frames_of("$100"))[:5] == bytes((0x77, 0x24, 0x24, 0x24 ^ 0x24 ^ 0x55, 0xFF))

"""Noise on the grbl link."""

from passo import error_texts
from check_gcode import ALPHABET, GOOD
from draws import Random
from router import Machine, answers

CASES = {
    "check_noise_is_answered_line_by_line": (("seed", "seed"),),
    "check_mutated_programmes": (("seed", "seed"),),
    "check_a_break_spoils_its_own_line": (("seed", "seed"),),
}
RUNS = {"check_noise_is_answered_line_by_line": 40, "check_mutated_programmes": 25, "check_a_break_spoils_its_own_line": 30}


def mutated(random):
    line = bytearray(random.choice(GOOD))
    for _ in range(random.between(0, 3)):
        at = random.between(0, len(line) - 1)
        line = line[:at] + bytes((random.choice(ALPHABET),)) * random.choice((1, 1, 1, 30)) + line[at + random.between(0, 1) :]
    return bytes(line)


def recover(machine):
    """Reset and unlock; the machine works again."""
    machine.put(b"\n\x18")
    machine.cycles(4)
    machine.said()
    machine.put(b"$X\nG21G90G94\n$J=G91X0.1F1000\n")
    said = []
    for _ in range(300):
        said += machine.cycles()
        if len(answers(said)) == 3:
            break
    assert answers(said) == ["ok"] * 3, said
    machine.settle()


def check_noise_is_answered_line_by_line(seed):
    """Any bytes without real-time ones among them: an answer a line, no exception; any bytes: a reset always helps."""
    random = Random(seed)
    machine = Machine().ready()
    quiet = bytes([byte for byte in random.bytes(300) if byte not in (0x3F, 0x21, 0x7E, 0x18) and byte < 0x80])
    for byte in b"\rMm$":  # pauses and settings apart
        quiet = quiet.replace(bytes((byte,)), b"")
    quiet = quiet[:110] + b"\n"
    machine.put(quiet)
    said = []
    for _ in range(40):
        said += machine.cycles()
    assert len(answers(said)) == quiet.count(b"\n")
    machine.put(random.bytes(400))
    machine.cycles(10)
    recover(machine)


def check_a_break_spoils_its_own_line(seed):
    """A byte 00 in any line, put in or in another byte's place: that line is an error and does nothing, and each other line is done."""
    random = Random(seed)
    machine = Machine().ready()
    kinds = (b"G1X%dY%dF3000", b"X%dY%d", b"G91", b"G10L2P1X%d", b"$10=%d", b"$J=G91X%dF3000", b"$N0=G21", b"S%d(laser %d)", b"G21;" + b"a" * 300, b"")
    kind = random.choice(kinds)
    line = kind % ((random.between(1, 9),) * kind.count(b"%d"))
    at = random.between(0, len(line))
    bad = line[:at] + b"\0" + line[at + random.between(0, 1) :]
    before = machine.controller.queue.target[:]
    machine.put(b"G90\n" + bad + b"\nG54\n")
    said = []
    for _ in range(400):
        said += machine.cycles()
        if len(answers(said)) == 3:
            break
    assert answers(said) == ["ok", "error:1", "ok"], (bad, said)
    assert machine.controller.queue.target == before and machine.status()["state"] == "Idle"


def check_mutated_programmes(seed):
    """Lines good and bad: one answer a line, no motion from a rejected line, and a reset brings everything back."""
    random = Random(seed)
    machine = Machine().ready()
    for _ in range(12):
        line = mutated(random)
        if b"M" in line.upper() and (b"0" in line or b"6" in line or b"1" in line) or b"P" in line.upper() or b"38" in line:
            continue  # pauses wait for the operator, dwells and probing may last
        before = machine.controller.queue.target[:]
        machine.put(line + b"\n")
        said = []
        for _ in range(400):
            said += machine.cycles()
            if answers(said):
                break
        if not answers(said) and machine.controller.state == "run":  # it waits for a slow motion
            recover(machine)
            continue
        assert len(answers(said)) == 1, (line, said)
        if answers(said)[0] != "ok" and "error:15" not in said:
            assert machine.controller.queue.target == before, line
        number = answers(said)[0][6:]
        assert not number or error_texts.text(int(number)) != "error " + number
        if random.between(0, 3) == 0 or machine.controller.machine.alarm:
            recover(machine)
    recover(machine)

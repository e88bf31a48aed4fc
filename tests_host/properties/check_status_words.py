"""A word of a status is one row of commands.STATUS_WORDS: grbl, pulses and the torch's /INFO all say it, where there is room for words."""

from array import array

from check_grbl_report import longest_report, say, _Longest
from passo import commands
from passo.protocols.grbl.report import Status
from passo.protocols.pulses.report import status, status_from
from passo.protocols.torch.forms import Forms

PROGRAM = {
    "index": 3, "total": 9, "pass": 1, "passes": 2, "backward": False, "speed": 10_002, "wait_ms": 0, "asked": False, "manual": 0,
    "tool": False, "drives": True, "moving": 0, "negative": 0, "room": 5,
}  # fmt: skip
PORT = {"port_bits": "--------", "port_invert": 0}
WANTED = {"SD": "12,PART.NC", "En": "-3,4", "RPM": "0", "Gl": "7"}


def report():
    made = dict(longest_report(), job="12,PART.NC", counts="-3,4", rpm=0, glitches=7, step_program=PROGRAM, error=0, ours=True)
    made["position"] = array("i", [0] * 4)
    return made


def without(made):
    for key, _ in commands.STATUS_WORDS:
        made[key] = None
    return made


def grbl(made):
    one = _Longest()
    return dict([field.split(":") for field in say(Status(one, one, one), made)["Ov"].strip("<>\r\n").split("|")[1:]])


def pulses(made):
    return status_from(status(made, PORT))


class Scale:
    settings = None
    steps_per_m = [1, 1]


def torch(made):
    return dict([(name, str(value)) for name, value in Forms(Scale)._more_fields(made)])


def check_every_language_with_words_says_them():
    for said in (grbl, pulses, torch):
        found = said(report())
        assert dict([(word, found[word]) for word in WANTED]) == WANTED, (said, found)


def check_what_a_machine_has_not_is_not_said():
    for said in (grbl, pulses, torch):
        assert not [word for word in WANTED if word in said(without(report()))], said


def check_a_new_word_is_a_row():
    rows = commands.STATUS_WORDS
    modules = [__import__("passo." + name, None, None, ("STATUS_WORDS",)) for name in ("protocols.grbl.report", "protocols.pulses.report", "protocols.torch.forms")]
    for module in modules:
        module.STATUS_WORDS = rows + [("up", "Up")]
    try:
        for said in (grbl, pulses, torch):
            assert said(dict(report(), up=41))["Up"] == "41", said
    finally:
        for module in modules:
            module.STATUS_WORDS = rows

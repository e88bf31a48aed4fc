"""Settings of the torch's language on the emulated Pico: set by its frames, the power off and on, kept in flash."""

import pytest
from emulated import make_machine, uf2  # noqa: F401

from host_tools.clients.answers import is_complete
from passo.protocols.torch import protocol as torch
from passo.protocols.typed_words import line_of

UP_LIMIT_MS = 8000
ANSWER = 17  # bytes of a frame of text

pytestmark = pytest.mark.slow


def until_up(machine):
    def answers():
        machine.send(torch.frame("INFO"))
        machine.run_ms(50)
        return machine.take()[:1] == torch.frame("INFO")[:1]

    machine.run_until(answers, UP_LIMIT_MS)
    machine.run_ms(30)
    machine.take()


def say(machine, line):
    """The lines of the answer."""
    machine.send(b"".join(torch.passo(torch.LINE_OF, byte) for byte in line_of(line)))
    said, text = b"", ""

    def told():
        nonlocal said, text
        said += machine.take()
        whole = range(0, len(said) // ANSWER * ANSWER, ANSWER)
        text = "".join(torch.answer_from(said[at : at + ANSWER])[1]["text"] for at in whole)
        return is_complete(text)

    machine.run_until(told, 3000)
    return text.splitlines()


def test_kept_in_flash(make_machine):  # noqa: F811
    machine = make_machine("torch_manipulator")
    until_up(machine)
    assert say(machine, "$100") == ["$100=48.000", "ok"]
    assert say(machine, "$100=49.218") == ["$100=49.218", "ok"]
    machine.send(torch.configure(98, 83, 480, 830))
    machine.run_ms(1500)
    assert say(machine, "$150") == ["$150=1.991", "ok"]
    kept = machine.pico.files()
    assert [name for name in kept if "settings." in name]
    machine.close()
    machine = make_machine("torch_manipulator", files=kept)  # the power off and on: the flash as it is
    until_up(machine)
    assert say(machine, "$100") == ["$100=49.218", "ok"] and say(machine, "$150") == ["$150=1.991", "ok"]
    assert say(machine, "$101") == ["$101=83.000", "ok"]

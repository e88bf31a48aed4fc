"""A G-code machine of an experiment, virtual or emulated: lines with their answers, and the words of its reports.

    wait_up(machine); ask(machine, b"$X\\n"); words_of(machine)["Fb"]
"""

import re

from host_tools.clients.grbl_wire import fields_of
from host_tools.failure import Failure

MOST_MS = 60_000
REPORTS = 45
RESET = b"\x18"


def wait_up(machine):
    """Wait until the machine says how it is unlocked. Raises TimeoutError."""
    machine.run_until(lambda: b"unlock" in machine.replies_so_far(), MOST_MS)
    machine.run_ms(60)


def ask_line(machine, line):
    """Return the machine's answer to a line, bytes. Raises Failure if it is not ok."""
    machine.take()
    machine.send(line)
    machine.run_until(lambda: any(end in machine.replies_so_far() for end in (b"ok\r\n", b"error", b"ALARM")), MOST_MS)
    said = machine.take()
    if b"ok" not in said:
        raise Failure("{!r} was answered by {!r}", line.decode().strip(), said.decode().strip())
    return said


def words_of(machine):
    """Return {word: value} of the next whole report: some words stand in each twelfth report only, beside Ov. Raises Failure."""
    for _again in range(REPORTS):
        machine.take()
        machine.send(b"?")
        machine.run_until(lambda: b">\r\n" in machine.replies_so_far(), MOST_MS)
        fields = fields_of(re.findall(rb"<.*?>", machine.take())[-1].decode())
        if "Ov" in fields:
            return fields
    raise Failure("no whole report in {}", REPORTS)

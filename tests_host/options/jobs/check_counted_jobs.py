"""Stored jobs and the journal of pulse programs, on a small machine: under CPython and MicroPython."""

import os
from binascii import b2a_base64, crc32

from check_jobs import BUTTON, folder, stored_form
from lpt import Lpt, Slots

CODES = b"[+2000(" + b"A" * 70 + b"G" * 40 + b"*20C)B]"


def make(path=None, pages=None, **changes):
    machine = Lpt(path or folder(), pages or Slots(), **changes)
    machine.folder = path or machine.board["jobs"]["folder"]
    return machine


def remove(machine):
    for name in os.listdir(machine.folder):
        os.remove(machine.folder + "/" + name)
    os.rmdir(machine.folder)


def store(machine, data):
    packed = stored_form(data)
    machine.tell("$FS=PART,pulses,%d,%08x,%d" % (len(data), crc32(data) & 0xFFFFFFFF, len(packed)))
    for first in range(0, len(packed), 54):
        machine.tell("$F:" + b2a_base64(packed[first : first + 54]).decode().strip())
    machine.tell("$FE")


def journal(machine):
    """[job, line, flags, places] as {$JR} says."""
    said = [line for line in machine.tell("$JR") if line[:9] == "[JOURNAL:"][0]
    job, line, flags, place = said[9:-1].split("|")
    return int(job, 16), int(line), int(flags), [int(part) for part in place.split(",")]


def check_a_stored_job_makes_the_steps_of_its_file():
    machine = make()
    store(machine, CODES)
    assert "LANGUAGE:pulses" in machine.tell("$F")[0]
    machine.tell("$F=PART")
    assert "[JOB:PART|0]" in machine.tell("$F?")
    machine.until("[MSG:Job PART done]")
    assert "[ENDED:PART|0|%d]" % (len(CODES) + 1) in machine.tell("$F?")
    made = machine.picture()
    job, line, flags, place = journal(machine)
    assert job == crc32(CODES) & 0xFFFFFFFF and line == 118 and flags & 3 == 3 and place == [109, 41, 0], (line, flags, place)
    remove(machine)
    machine = Lpt()
    machine.play(CODES)
    assert made == machine.picture() and len(made) == 112


def check_a_start_and_a_button():
    """The board file's job runs when the board is switched on, and again when the button is pressed."""
    machine = make()
    store(machine, b"[+2000AAA]")
    folder = machine.folder
    machine = make(folder, jobs={"start": "PART", "button": "PART"}, more=[BUTTON])
    for count in (1, 2):
        machine.until("[MSG:Job PART done]")
        assert machine.world.place == [3 * count, 0, 0], machine.world.place
        machine.world.switches["job"] = 0
        machine.run_ms(100)
        machine.world.switches["job"] = 1
        machine.run_ms(10)
    machine.until("[MSG:Job PART done]")
    remove(machine)


def check_what_is_not_announced_is_not_written_down():
    machine = make()
    machine.tell("$JR=1234")
    machine.play("[AAAA]")
    before = journal(machine)
    assert before[:2] == (0x1234, 6), before
    machine.play("[CCCCCC]")
    assert journal(machine) == before
    assert machine.ask("$JR=0") == "error:3" and machine.ask("$JR=1,2") == "error:3" and machine.ask("$X") == "error:3"
    remove(machine)


def check_each_command_that_a_stop_or_a_pause_ends_at():
    """The place in the journal is that of the pins, backward and forward."""
    pages = Slots()
    machine = make(None, pages)
    machine.tell("$JR=77")
    machine.load("[+600" + "A" * 300 + "C" * 300 + "]")
    backward = False
    for word, ms in (("run", 400), ("pause", 20), ("back", 100), ("pause", 20), ("run", 100), ("stop", 20)):
        machine.tell(word)
        machine.run_ms(ms)
        if word in ("pause", "stop"):
            job, line, flags, place = journal(machine)
            x, y, z = machine.world.place
            assert place == [x, y, z] and job == 0x77 and 0 < line == 2 + x + y < 602, (line, place, machine.world.place)
            assert bool(flags & 4) == backward, (word, flags)
        else:
            backward = word == "back"
    remove(machine)
    again = make(None, pages)  # switched on again: the journal is there, the position is not known
    assert journal(again) == (0x77, line, flags & ~2, place)
    remove(again)

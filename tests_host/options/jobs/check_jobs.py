"""Stored jobs on a small machine: under CPython and MicroPython."""

import os
from time import time_ns
from binascii import b2a_base64, crc32

from passo.options.jobs.config import WINDOW_BITS, first_line
from router import BOARD, Machine, answers, home

JOB = b"G21\nG90\nM3S1000\nG1X5Y2F1200\n\nG2X9Y2I2J0\nG0Z-1\nM5\nM30\n"
BUTTON = {"name": "job", "pin": 28, "active": 0, "pull": "up"}
CASES = {
    "check_a_bit_that_is_wrong": (("at", 0, 200), ("bit", 0, 7), ("card", 0, 1)), "check_a_job_that_changes_as_it_runs": (("piece", 0, 12),),
}  # fmt: skip
RUNS = {"check_a_bit_that_is_wrong": 12, "check_a_job_that_changes_as_it_runs": 4}
NOT_QUICK = (
    "check_a_bit_that_is_wrong", "check_a_job_that_changes_as_it_runs", "check_a_file_that_goes_between_proof_and_run",
    "check_files_of_strangers", "check_a_start", "check_a_folder_of_hundreds_of_jobs",
    "check_a_change_that_makes_a_line_wrong", "check_a_card_that_goes_as_its_job_runs", "check_a_button", "check_a_damaged_job_stays_on_the_card",
)  # fmt: skip
CARD = {"spi": 0, "sck": 22, "mosi": 19, "miso": 20, "cs": 21}
SQUARE = b"F3000\n" + "".join(["G1X%d.%dY%d\n" % (number % 9, number % 7, number % 5) for number in range(200)]).encode()


def stored_form(data):
    """Return `data` as a deflate stream of stored blocks, which any decoder reads, and which needs no encoder."""
    blocks = b""
    for first in range(0, len(data), 1000):
        part = data[first : first + 1000]
        count = len(part)
        last = first + 1000 >= len(data)
        blocks += bytes((1 if last else 0, count & 255, count >> 8, ~count & 255, (~count >> 8) & 255)) + part
    return blocks


def folder():
    """A folder of its own: both interpreters may be at it at once."""
    return "%s/passo-jobs-%d" % (os.getenv("TMPDIR") or "/tmp", time_ns())


def make(where=None, card=False, changes=None, **jobs):
    """`changes`: of the board file; `jobs`: of its key "jobs"."""
    config = {"language": "grbl", "folder": where or folder(), "button": "", "start": ""}
    config.update(jobs)
    machine = Machine(jobs=config, card=CARD if card else None, **(changes or {}))
    machine.folder = config["folder"]
    return machine


def remove(machine):
    for name in os.listdir(machine.folder):
        os.remove(machine.folder + "/" + name)
    os.rmdir(machine.folder)


def store(machine, name, data, packed=None, crc=None):
    """Upload as a PC does; the answer to each line must be ok. Returns the answer to the last."""
    packed = stored_form(data) if packed is None else packed
    machine.do("$FS=%s,grbl,%d,%08x,%d" % (name, len(data), (crc32(data) if crc is None else crc) & 0xFFFFFFFF, len(packed)))
    for first in range(0, len(packed), 54):
        machine.do("$F:" + b2a_base64(packed[first : first + 54]).decode().strip())
    return answers(machine.ask("$FE"))[0]


def run(machine, said=(), turns=200_000):
    """Cycle until the job has ended; return the lines, after `said`."""
    said = list(said)
    while turns:
        turns -= 1
        if [line for line in said if line.startswith("[MSG:Job")]:
            return said
        said += machine.cycles()
    raise AssertionError("the job does not end: %r" % said)


def ended(said):
    return [line for line in said if line.startswith("[MSG:Job")][0]


def check_window():
    assert WINDOW_BITS == 10


def check_store_and_run():
    """A job run from the board makes the same steps as its lines sent over a link."""
    machine = home(make().ready())
    assert store(machine, "PART.NC", JOB) == "ok"
    listed = machine.do("$F")
    assert listed[0] == "[FILE:PART.NC|SIZE:%d|STORED:%d|CRC:%08x|LANGUAGE:grbl]" % (
        len(JOB), len(JOB) + 5, crc32(JOB) & 0xFFFFFFFF), listed  # fmt: skip
    assert listed[1].startswith("[FREE:"), listed
    machine.world.path = []
    machine.do("$F=PART.NC")
    assert ended(run(machine)) == "[MSG:Job PART.NC done]"
    first = list(machine.world.path)
    assert first
    machine.do("G90", "G53G0X0Y0Z0")
    machine.settle()
    machine.world.path = []
    machine.do("$F=PART.NC")
    run(machine)
    again = machine.world.path
    assert [row[1:] for row in first] == [row[1:] for row in again]
    sent = home(make().ready())
    sent.world.path = []
    sent.put(JOB)
    sent.cycles(50)
    sent.settle()
    assert [row[1:] for row in sent.world.path] == [row[1:] for row in first]
    begin, other = sent.world.path[0][0], first[0][0]
    assert [row[0] - begin for row in sent.world.path] == [row[0] - other for row in first]
    remove(machine)
    remove(sent)


def check_who_commands():
    """While it runs lines from the PC are refused; hold, resume, overrides and the report are not."""
    machine = home(make().ready())
    assert store(machine, "LONG", SQUARE) == "ok"
    machine.do("$F=LONG")
    machine.cycles(20)
    machine.said()
    assert answers(machine.ask("G1X1F100")) == ["error:112"]
    assert answers(machine.ask("$F=LONG")) == ["error:112"]
    machine.put("!")
    machine.cycles(200)
    assert machine.status()["state"] == "Hold:0"
    machine.put(b"~\x91")
    machine.cycles(5)
    assert machine.status()["state"] == "Run"
    text = "".join([machine.status()["text"] for _ in range(40)])
    assert "|SD:" in text and ",LONG" in text and "|Ov:110," in text, text
    assert answers(machine.ask("$FD=LONG")) == ["error:112"]
    machine.put("\x18")
    said = machine.cycles(20)
    assert "[MSG:Job LONG: error 157 in line" in "".join(said), said
    machine.do("$X", "G4P0", "$F")
    assert "|SD:" not in "".join([machine.status()["text"] for _ in range(40)])
    remove(machine)


def check_a_refused_line_ends_it():
    """The lines after the refused one are dropped; spindle and coolant are off."""
    machine = home(make().ready())
    bad = b"M3S1000\nM8\nG1X2F600\nG1X4\nG1X5G7\nG1X9\nG1X11\n"
    assert store(machine, "BAD", bad) == "ok"
    machine.do("$F=BAD")
    assert ended(run(machine)) == "[MSG:Job BAD: error 20 in line 5]"
    machine.settle()
    assert machine.world.place[0] <= 4 * 320 + 640 + 3000, machine.world.place
    assert machine.world.tool == 0 and machine.world.outputs["flood"] == 0
    before = list(machine.world.place)
    machine.cycles(100)
    assert machine.world.place == before
    machine.do("G1X1F600")
    remove(machine)


def check_no_byte_of_a_job_acts_at_once():
    """Letters beyond ASCII, `!` and Ctrl-X cost nothing in comments; elsewhere they are error 1 of their line."""
    machine = home(make().ready())
    assert store(machine, "LETTERS", b"G21 (\xd0\x97\xc2\xa0 ! ~ \x18 \x84)\nG1X2F600 ; \xe2\x88\x92\nG1X4\nM30\n") == "ok"
    machine.do("$F=LETTERS")
    assert ended(run(machine)) == "[MSG:Job LETTERS done]"
    machine.settle()
    assert machine.controller.position()[0] == 4 * 320 and machine.controller.machine.overrides == [100, 100, 100]
    for at, line in enumerate((b"X\xe2\x88\x925", b"X!5", b"X\x185", b"X1\xc2\xb75", b"\xc2\xa0X9")):
        name = "ODD%d" % at
        assert store(machine, name, b"G1X5F600\n" + line + b"\nX9\n") == "ok"
        machine.do("$F=" + name)
        assert ended(run(machine)) == "[MSG:Job %s: error 1 in line 2]" % name, line
        machine.settle()
        assert machine.controller.position()[0] <= 5 * 320, line
        assert machine.controller.machine.overrides == [100, 100, 100] and machine.world.outputs["flood"] == 0
    remove(machine)


def check_uploads_that_are_wrong():
    """Each leaves what was there: a byte wrong, too few, too many, no deflate stream, another language, a name."""
    machine = home(make().ready())
    assert store(machine, "A", JOB) == "ok"
    packed = stored_form(JOB)
    bent = packed[:20] + bytes((packed[20] ^ 1,)) + packed[21:]
    assert store(machine, "A", JOB, bent) == "error:151"
    assert store(machine, "A", JOB, packed[:-9] + b"\xff" * 9) == "error:151"
    assert store(machine, "A", JOB, b"\xff" * 40) == "error:151"
    machine.do("$FS=A,grbl,10,0,300")
    assert answers(machine.ask("$FE")) == ["error:156"]
    machine.do("$FS=A,grbl,10,0,2")
    assert answers(machine.ask("$F:AAAAAA==")) == ["error:156"]
    assert answers(machine.ask("$FS=A,plotter,10,0,2")) == ["error:155"]
    assert answers(machine.ask("$FS=../B,grbl,10,0,2")) == ["error:154"]
    assert answers(machine.ask("$FS=A,grbl,10")) == ["error:3"]
    assert answers(machine.ask("$F=B")) == ["error:150"]
    assert answers(machine.ask("$FD=B")) == ["error:150"]
    beside = machine.folder + "-beside.job"
    write(beside, b"no job of this folder")
    assert answers(machine.ask("$FD=../" + beside.rsplit("/", 1)[1][:-4].upper())) == ["error:150"]
    assert answers(machine.ask("$FD=../" + beside.rsplit("/", 1)[1][:-4])) == ["error:150"]
    os.remove(beside)
    assert machine.do("$F")[0].startswith("[FILE:A|SIZE:%d|" % len(JOB))
    machine.do("$FS=A,grbl,10,0,300")
    again = make(machine.folder).ready()
    assert os.listdir(machine.folder) == ["A.job"]
    again.do("$FD=A")
    assert again.do("$F")[0].startswith("[FREE:")
    remove(again)


def check_torn_files():
    """A file cut off anywhere is never run: it is damaged, or its job ends with an error."""
    machine = home(make().ready())
    assert store(machine, "A", JOB) == "ok"
    path = machine.folder + "/A.job"
    with open(path, "rb") as file:
        whole = file.read()
    for length in range(0, len(whole), 7):
        with open(path, "wb") as file:
            file.write(whole[:length])
        said = machine.ask("$F=A")
        if answers(said) == ["ok"]:
            assert "error 151" in ended(run(machine, said))
        else:
            assert answers(said) == ["error:151"], (length, said)
        assert machine.do("$F")[0].startswith("[FILE:A|")
    with open(path, "wb") as file:
        file.write(whole)
    machine.do("G90", "G53G0X0Y0Z0", "$F=A")
    assert ended(run(machine)) == "[MSG:Job A done]"
    remove(machine)


def stored(machine, name, data=JOB):
    """(path, bytes) of a job's file."""
    assert store(machine, name, data) == "ok"
    path = machine.folder + "/" + [each for each in os.listdir(machine.folder) if each.split(".")[0] == name][0]
    with open(path, "rb") as file:
        return path, file.read()


def write(path, data):
    with open(path, "wb") as file:
        file.write(data)


def check_a_bit_that_is_wrong(at, bit, card):
    """Nothing moves and the job does not end as done, whatever bit of the file is wrong; each time it is run, from flash or card."""
    machine = home(make(card=card).ready())
    path, whole = stored(machine, "A")
    at %= len(whole) - 1 if card else len(whole)
    if whole[at - 1] == 10 and whole[:at].count(b"\n") == 1 and bit >= 3:
        remove(machine)
        return  # up to a byte's end behind the three bits that begin a block of bytes as they are: of no meaning
    machine.do("G90", "G53G0X0Y0Z0", "$F=A")
    assert ended(run(machine)) == "[MSG:Job A done]"
    machine.do("G90", "G53G0X0Y0Z0")
    machine.settle()
    write(path, whole[:at] + bytes((whole[at] ^ 1 << bit,)) + whole[at + 1 :])
    machine.world.path = []
    for _ in range(2):
        said = machine.ask("$F=A")
        if answers(said) == ["ok"]:
            assert "error 151" in ended(run(machine, said))
        else:
            assert answers(said)[0] == "error:151", (at, bit, said)
    machine.cycles(50)
    assert machine.world.path == [] and machine.world.tool == 0
    remove(machine)


def check_a_job_that_changes_as_it_runs(piece):
    """It ends in an alarm, at a stand, and is not done."""
    machine = home(make().ready())
    stored(machine, "A", SQUARE)
    machine.do("$F=A")
    while machine.controller.features["jobs"]._proving:
        machine.cycles(1)
    file = machine.controller.features["jobs"]._file
    read = file._stream.readinto
    count = [0]

    class Bent:
        def readinto(self, view):
            got = read(view)
            count[0] += 1
            if count[0] == piece + 1:
                view[got - 2] ^= 1
            return got

        def close(self):
            pass

    file._stream = Bent()
    said = run(machine)
    said += machine.cycles(20)
    assert "error 151" in ended(said) and "ALARM:52" in said and machine.status()["state"] == "Alarm", said
    remove(machine)


def check_a_card_that_goes_as_its_job_runs():
    """The job ends at a stand with the tool off, error 158 says that no card answers, and there is no alarm: the bytes read were right."""
    for card in (True, False):
        machine = home(make(card=card).ready())
        stored(machine, "A", b"M3S1000\n" + SQUARE)
        machine.world.path = []
        machine.do("$F=A")
        while machine.controller.features["jobs"]._proving:
            machine.cycles(1)
        file = machine.controller.features["jobs"]._file
        read = file._stream.readinto

        class Gone:
            def readinto(self, view):
                if file.done > 1000:
                    raise OSError(5)
                return read(view)

            def close(self):
                pass

        file._stream = Gone()
        said = run(machine) + machine.cycles(20)
        assert machine.world.path and machine.world.tool == 0
        if card:
            assert "error 158" in ended(said) and "ALARM" not in "".join(said) and machine.status()["state"] == "Idle", said
            machine.do("$F=A")
            assert ended(run(machine)) == "[MSG:Job A done]"
        else:
            assert "error 151" in ended(said) and machine.status()["state"] == "Alarm", said  # flash that does not answer is broken
        remove(machine)


def check_a_change_that_makes_a_line_wrong():
    """The error is that of the change, with an alarm. For an unchanged job it is that of the line, as ever."""
    long = b"G1X1F3000\n" + b"F3000\n" * 2500
    for data, said_of_it in ((long, "error 151"), (long[:2000] + b"G1X5G7\n" + long[2000:], "error 20 ")):
        machine = home(make().ready())
        path, whole = stored(machine, "A", data)
        machine.do("$F=A")
        while machine.controller.features["jobs"]._proving:
            machine.cycles(1)
        if data is long:
            write(path, whole[:12_000] + b"W" * 9 + whole[12_009:])
        said = run(machine) + machine.cycles(20)
        assert said_of_it in ended(said) and ("ALARM:52" in said) == (data is long), said
        remove(machine)


def check_a_file_that_goes_between_proof_and_run():
    """Nothing moves, and the next job runs: whether the file is gone, is another one, or its first line has changed."""
    for card in (False, True):
        for change in ("gone", "first line", "another"):
            machine = home(make(card=card).ready())
            path, whole = stored(machine, "A")
            stored(machine, "B", JOB + b"G4P0\n")
            store_ = machine.controller.features["jobs"]._store
            close = store_.close

            def closed(job):
                close(job)
                store_.close = close
                if change == "gone":
                    os.remove(path)
                elif change == "another":
                    with open(path[: -len("A.job")] + "B.job", "rb") as file:
                        write(path, file.read())
                else:
                    write(path, b"jab" + whole[3:])

            store_.close = closed
            machine.do("G90", "G53G0X0Y0Z0")
            machine.settle()
            machine.world.path = []
            said = machine.ask("$F=A")
            assert "error 15" in ended(run(machine, said)) and machine.world.path == []
            machine.do("$F=B")
            assert ended(run(machine)) == "[MSG:Job B done]"
            remove(machine)


def first_lines():
    """Of files that nobody uploaded: no numbers, numbers below zero, no text; with the right CRC-32 behind."""
    right = first_line("grbl", 5, 0xF7, 5)
    for bent in (b"job grbl x 000000f7 5", b"job grbl 5 zz 5", b"job \xff\xfe 5 f7 5", b"job grbl -5 f7 5", b"job grbl 5 f7 -1", b"job grbl 5"):
        yield bent + b" %08x\n" % (crc32(bent) & 0xFFFFFFFF) + b"G1X1\n\n"
    for bent in (b"j" * 100_000, right[:9] + b"?" + right[10:] + b"G1X1\n\n", b"\n", b"job \n" * 40):
        yield bent


def check_files_of_strangers():
    """They are listed as damaged, cannot run, can be deleted, and are in nobody's way; a folder and names that $F cannot write, too."""
    for card in (False, True):
        machine = home(make(card=card).ready())
        stored(machine, "A")
        for name in ("a b.job", "[]|\n.job", "x.job", ".job", "X" * 25 + ".job", "UNI\u00e7.job", "NOTES.txt"):
            write(machine.folder + "/" + name, b"G1X1\n")
        os.mkdir(machine.folder + "/DIR.job")
        for data in first_lines():
            write(machine.folder + "/X.job", data)
            listed = machine.do("$F")
            assert [line.split("|")[0] for line in listed[:-2]] == ["[FILE:A", "[FILE:DIR", "[FILE:X"], listed
            assert "damaged" in listed[1] and "damaged" in listed[2], listed
            assert answers(machine.ask("$F=X")) == ["error:151"] and answers(machine.ask("$F=DIR"))[0] in ("error:150", "error:151")
            assert answers(machine.ask("$FD=DIR")) == ["error:150"]
            machine.do("$FD=X")
        machine.do("$F=A")
        assert ended(run(machine)) == "[MSG:Job A done]"
        os.rmdir(machine.folder + "/DIR.job")
        remove(machine)


def check_a_damaged_job_stays_on_the_card():
    """A fault in its first line is reported, not removed as an upload that was cut off; the next upload takes its place."""
    machine = home(make(card=True).ready())
    path, whole = stored(machine, "A")
    for at in range(whole.index(b"\n")):
        write(path, whole[:at] + bytes((whole[at] ^ 1,)) + whole[at + 1 :])
        assert answers(machine.ask("$F=A")) == ["error:151"], at
    assert os.listdir(machine.folder) == ["A.job"]
    for _ in range(2):
        assert store(machine, "A", JOB) == "ok" and len(os.listdir(machine.folder)) == 1
        machine.do("$F=A")
        assert ended(run(machine)) == "[MSG:Job A done]"
    remove(machine)


def check_a_reset_ends_the_proof():
    """A job of half a megabyte is read for a while: the report shows the progress, a reset ends it, and it can be run again."""
    machine = home(make().ready())
    long = SQUARE * 200
    packed = stored_form(long)
    write(machine.folder + "/A.job", first_line("grbl", len(long), crc32(long) & 0xFFFFFFFF, len(packed)) + packed)
    machine.do("$F=A")
    text = "".join([machine.status()["text"] for _ in range(3)])
    assert "|SD:" in text and ",A?" in text, text
    before = list(machine.world.place)
    machine.put("\x18")
    said = machine.cycles(20)
    assert "error 157" in ended(said) and machine.world.place == before
    machine.do("$X", "$F=A")
    while ",A?" in machine.status()["text"]:
        machine.cycles(1)
    assert ",A" in machine.status()["text"]
    machine.put("\x18")
    machine.cycles(20)
    remove(machine)


def check_a_button():
    """It runs the board file's job, and again; where there is none it says so."""
    machine = make(button="PART", changes={"inputs": BOARD["inputs"] + [BUTTON]})
    switches = machine.world.switches

    def press():
        said = []
        for level in (0, 1):
            switches["job"] = level
            said += machine.cycles(20)
        return said

    switches["job"] = 1
    machine.ready()
    assert "[MSG:Job PART: error 150]" in press()
    home(machine)
    assert store(machine, "PART", b"G91\nG1X1F3000\n") == "ok"
    before = machine.controller.position()[0]
    for count in (1, 2):
        assert "PART" in ended(run(machine, press())) and machine.controller.position()[0] == before + 320 * count
    remove(machine)


def check_a_start():
    """The board file's job runs when the board is switched on; it may home first."""
    machine = home(make().ready())
    assert store(machine, "AUTO", b"$H\nG90\nG53G0X5\n") == "ok"
    machine = make(machine.folder, start="AUTO")
    assert ended(run(machine)) == "[MSG:Job AUTO done]"
    assert machine.controller.position()[0] == 1600
    said = make(machine.folder, start="NONE").cycles(20)
    assert "[MSG:Job NONE: error 150]" in said, said
    remove(machine)


def check_memory_card():
    """Jobs on a card: stored, replaced, deleted; one that is taken out loses nothing, and its upload only."""
    machine = home(make(card=True).ready())
    card = machine.controller.features["jobs"]._card
    assert store(machine, "A", JOB) == "ok"
    assert store(machine, "A", SQUARE) == "ok" and store(machine, "B", JOB) == "ok"
    assert sorted(os.listdir(machine.folder)) == ["A.alt", "B.job"]
    listed = machine.do("$F")
    assert len(listed) == 4 and listed[0].startswith("[FILE:A|SIZE:%d|" % len(SQUARE)), listed
    card.inside = False
    for line in ("$F", "$F=A", "$FD=A", "$FS=A,grbl,10,0,20"):
        assert answers(machine.ask(line)) == ["error:158"], line
    card.inside = True
    machine.do("$FS=A,grbl,10,0,20")
    store_ = machine.controller.features["jobs"]._store

    class Gone:
        def write(self, data):
            raise OSError(5)

        def close(self):
            kept.close()
            raise OSError(5)

    kept, store_._file = store_._file, Gone()
    card.inside = False
    assert answers(machine.ask("$F:AAAA")) == ["error:158"] and answers(machine.ask("$FE")) == ["error:156"]
    card.inside = True
    machine.do("$FS=A,grbl,10,0,20", "$F:AAAA")
    again = home(make(machine.folder, card=True).ready())
    assert again.do("$F")[0].startswith("[FILE:A|SIZE:%d|" % len(SQUARE))
    assert sorted(os.listdir(machine.folder)) == ["A.alt", "B.job"]
    again.do("$F=B")
    assert ended(run(again)) == "[MSG:Job B done]"
    again.do("$FD=A")
    assert answers(again.ask("$F=A")) == ["error:150"]
    assert os.listdir(machine.folder) == ["B.job"]
    remove(machine)


def check_a_folder_of_hundreds_of_jobs():
    """The list leaves out what would take too long and too much memory, and says how many; each is run and deleted by its name. On a card
    no more than two files a job are opened for a list, and none of the others for a run."""
    for card in (True, False):
        machine = home(make(card=card).ready())
        path, whole = stored(machine, "J000")
        for number in range(1, 300):
            write(machine.folder + "/J%03d.job" % number, whole)
        if card:
            write(machine.folder + "/J002.job", whole[:20])
        store = machine.controller.features["jobs"]._store
        opened = []
        from passo.options.card import config as card_store

        before = card_store._file_state
        card_store._file_state = lambda path: (opened.append(path), before(path))[1]
        try:
            listed = machine.do("$F")
            assert len(opened) <= 2 * 64
            assert 0 < len(listed) - 3 <= 64 and listed[-3].startswith("[MORE:"), listed[-3:]
            assert 300 - int(card) <= len(listed) - 3 + int(listed[-3][6:-1]) <= 300
            del opened[:]
            machine.do("$F=J299")
            assert ended(run(machine)) == "[MSG:Job J299 done]"
            assert len(opened) <= 4, opened
        finally:
            card_store._file_state = before
        assert store.more and answers(machine.ask("$FD=J298")) == ["ok"] and answers(machine.ask("$F=J298")) == ["error:150"]
        if card:
            assert answers(machine.ask("$F=J002")) == ["error:150"], "it was cut off"
        remove(machine)


class Flash:
    """littlefs of 212 blocks as MicroPython tells of it: its folders are counted twice."""

    TREE = {"/": ("jobs", "passo"), "/passo/": ("app.mpy", "web", "steps"), "/passo/web/": ("page",)}

    def __init__(self, used):
        self._free = 212 - used - 2 * 5

    def statvfs(self, folder):
        return (4096, 4096, 212, self._free & 0xFFFFFFFF, self._free & 0xFFFFFFFF, 0, 0, 0, 0, 255)

    def ilistdir(self, path):
        return [(name, 0x8000 if "." in name else 0x4000, 0, 0) for name in self.TREE.get(path, ())]


def check_free_flash():
    """Also where MicroPython counts less than nothing."""
    from passo.options.jobs import config as job_store

    before = job_store.os
    try:
        for used, blocks in ((201, 9), (209, 1), (210, 0), (212, 0), (100, 110)):
            job_store.os = Flash(used)
            assert job_store.JobStore("/jobs").free_bytes() == blocks * 4096, used
    finally:
        job_store.os = before


def check_only_links_of_such_boards_know_its_notices():
    machine = make()
    assert machine.app.links[0].protocol.notices and not type(machine.app.links[0].protocol).notices
    remove(machine)

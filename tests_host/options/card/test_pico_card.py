"""Stored jobs on a memory card: MicroPython's driver and FAT on the emulated Pico, a card of sd_card.py on its SPI."""

import base64
import os
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from dense_job import StepDigest, dense_job, fast_router
from emulated import make_machine, uf2  # noqa: F401
from test_micropython import MICROPYTHON, needs_micropython
from test_pico_jobs import ask, ready, streamed

from host_tools.build.tree import compile_module
from host_tools.emulator.binary import CACHE
from host_tools.emulator.machine import files_of
from host_tools.emulator.sd_card import SdCard
from host_tools.programs import stored_job

pytestmark = [pytest.mark.slow, needs_micropython]
CARD = {"spi": 0, "sck": 18, "mosi": 19, "miso": 20, "cs": 21}
CARD_BYTES = 4 << 20
DRIVER_URL = "https://raw.githubusercontent.com/micropython/micropython-lib/master/micropython/drivers/storage/sdcard/sdcard.py"
# MicroPython on the PC formats a card and reads what is on it.
ON_CARD = """
import os, sys, vfs
class Card:
    def __init__(self, path):
        self.file = open(path, "r+b")
    def readblocks(self, number, view):
        self.file.seek(512 * number)
        self.file.readinto(view)
    def writeblocks(self, number, data):
        self.file.seek(512 * number)
        self.file.write(data)
    def ioctl(self, what, number):
        if what == 3 or what == 2:
            self.file.flush()
        return {4: %d, 5: 512}.get(what, 0)
card = Card(sys.argv[1])
if sys.argv[2] == "put":
    vfs.VfsFat.mkfs(card)
vfs.mount(vfs.VfsFat(card), "/sd")
if sys.argv[2] == "put":
    os.mkdir("/sd/jobs")
    for path in sys.argv[3:]:
        with open(path, "rb") as source:
            with open("/sd/jobs/" + path.split("/")[-1], "wb") as file:
                file.write(source.read())
else:
    for name in sorted(os.listdir("/sd/jobs")):
        print(name, os.stat("/sd/jobs/" + name)[6])
vfs.umount("/sd")
card.file.close()
""" % (CARD_BYTES // 512)


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    """The compiled driver. It is micropython-lib's: fetched once; without the internet the test skips, loudly."""
    source = CACHE / "sdcard.py"
    if not source.exists():
        try:
            with urllib.request.urlopen(DRIVER_URL, timeout=20) as answer:
                source.write_bytes(answer.read())
        except OSError as error:
            print(f"NOT TESTED: the driver of memory cards cannot be fetched: {error}", file=sys.__stderr__)
            pytest.skip("no driver")
    made = tmp_path_factory.mktemp("driver") / "sdcard.mpy"
    compile_module(source, made, "armv6m", Path("sdcard.mpy"))
    return made.read_bytes()


def on_card(image, what, *paths):
    done = subprocess.run([MICROPYTHON, "-c", ON_CARD, image, what, *paths], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()


@pytest.fixture
def carded(make_machine, driver, tmp_path):
    """`carded(jobs)`: (machine, card) with jobs {name: bytes} on the card."""

    def make(jobs, **changes):
        for name, data in jobs.items():
            stored_job.write_on_card(tmp_path, name, "grbl", data)
        image = tmp_path / "card.img"
        image.write_bytes(bytes(CARD_BYTES))
        on_card(image, "put", *sorted((tmp_path / "jobs").glob("*")) if jobs else ())
        board = {**fast_router(), "card": CARD, **changes}
        machine = make_machine(board, files={**files_of(board), "lib/sdcard.mpy": driver}, trace=None)
        card = SdCard(machine.pico, CARD, bytearray(image.read_bytes()))
        return ready(machine), card

    return make


def test_a_job_runs_from_a_card_at_50_khz(carded, show):
    data = dense_job(int(os.environ.get("PASSO_JOB_BYTES", "8000")))
    wanted, count, _, seconds = streamed(data)
    machine, card = carded({"BIG": data})
    listed = ask(machine, b"$F")
    assert b"[FILE:BIG|SIZE:%d|" % len(data) in listed, listed
    machine.pico.charge_flash(50)
    steps = StepDigest(machine.plant)
    ask(machine, b"$F=BIG")
    machine.run_until(lambda: b"[MSG:Job BIG" in machine.replies_so_far(), 1000 * (2 * seconds + 10), slice_us=10_000)
    machine.settle()
    assert machine.take().endswith(b"[MSG:Job BIG done]\r\n")
    assert b"x109" not in ask(machine, b"$LOG")
    show("a job from a memory card", f"{count} words in {seconds:.1f} s, 0 late, {card.reads} sectors read")
    assert steps.digest() == wanted


def test_a_card_is_put_in_filled_taken_out_and_put_back(carded, tmp_path, show):
    data = dense_job(6000)
    machine, card = carded({})
    card.inside = False
    assert ask(machine, b"$F") == b"error:158\r\n"
    card.inside = True
    packed = stored_job.pack_job(data)
    begun = machine.now_ms()
    for _ in range(2):
        assert ask(machine, b"$FS=A,grbl,%d,%08x,%d" % (len(data), stored_job.crc_of(data), len(packed))) == b"ok\r\n"
        for first in range(0, len(packed), 54):
            assert ask(machine, b"$F:" + base64.b64encode(packed[first : first + 54])) == b"ok\r\n"
        assert ask(machine, b"$FE") == b"ok\r\n"
    show("an upload to a memory card", f"{2 * len(packed)} bytes in {machine.now_ms() - begun:.0f} ms, {card.writes} sectors written")
    image = tmp_path / "after.img"
    image.write_bytes(card.data)
    assert on_card(image, "list") == [f"A.alt {len(stored_job.job_file('grbl', data)) + 1}"]
    ask(machine, b"$F=A")
    machine.run_ms(250)
    card.inside = False
    machine.run_until(lambda: b"[MSG:Job A: error 158" in machine.replies_so_far())
    machine.settle()
    assert b"ALARM" not in machine.take() and b"<Idle|" in ask(machine, b"?")
    assert ask(machine, b"$F=A") == b"error:158\r\n"
    card.inside = True
    assert b"[FILE:A|SIZE:%d|" % len(data) in ask(machine, b"$F")
    assert ask(machine, b"$FS=A,grbl,%d,%08x,%d" % (len(data), stored_job.crc_of(data), len(packed))) == b"ok\r\n"
    card.inside = False
    for first in range(0, len(packed), 54):
        said = ask(machine, b"$F:" + base64.b64encode(packed[first : first + 54]))
        if said != b"ok\r\n":
            break
    assert said == b"error:158\r\n"  # the upload is lost, and nothing else
    card.inside = True
    assert b"[FILE:A|SIZE:%d|" % len(data) in ask(machine, b"$F")
    ask(machine, b"$F=A")
    machine.run_until(lambda: b"[MSG:Job A done]" in machine.replies_so_far())

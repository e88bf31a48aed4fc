"""Stored jobs and pulse files in frames, at 1 % of bytes lost, doubled or flipped: each command ends, and does what it should."""

import contextlib
import os
import select
import subprocess
import threading
import time
import tty

import pytest

import framed_uploads
from host_tools import interpreter
from host_tools.programs import stored_job
from host_tools.resources import ROOT
from noisy_wire import NoisyWire

LANGUAGES = tuple(framed_uploads.BOARDS)


@pytest.mark.parametrize("language", LANGUAGES)
def test_jobs_are_stored_listed_run_and_deleted(language, tmp_path):
    for seed in (0, 112) if language == "grbl" else range(4):  # 112: AGAIN came behind LEAVE, and a byte of it was grbl's door
        framed_uploads.round_of(language, tmp_path, seed)


@pytest.mark.parametrize("language", LANGUAGES)
def test_an_upload_that_is_broken_off_is_begun_again(language, tmp_path):
    """By a PC's program that is killed, and whose session is still open."""
    assert 2 <= sum(framed_uploads.killed_in(language, tmp_path, seed) for seed in range(47, 53))


def test_a_pulse_file_is_played_step_by_step(tmp_path):
    framed_uploads.played("pulses", tmp_path, 0)


@pytest.mark.slow
@pytest.mark.parametrize("language", LANGUAGES)
def test_jobs_a_hundred_times(language, tmp_path):
    for seed in range(100, 200):
        framed_uploads.round_of(language, tmp_path, seed)
        framed_uploads.killed_in(language, tmp_path, seed)


class Relay(threading.Thread):
    """A pty through which bytes go to a board's and back, with faults."""

    def __init__(self, board):
        super().__init__(daemon=True)
        self._here, self._other = os.openpty()
        self.name_of_port = os.ttyname(self._other)
        self._there = os.open(board, os.O_RDWR | os.O_NOCTTY)
        for descriptor in (self._other, self._there):
            tty.setraw(descriptor)
        self.wires = {self._here: NoisyWire(1, framed_uploads.SHARE), self._there: NoisyWire(2, framed_uploads.SHARE)}
        self._ended = False

    def run(self):
        while not self._ended:
            for source in select.select(list(self.wires), [], [], 0.05)[0]:
                target = self._there if source == self._here else self._here
                wire = self.wires[source]
                wire.put(os.read(source, 4096))
                while data := wire.take(0):
                    os.write(target, data)

    def close(self):
        self._ended = True
        self.join()
        for descriptor in (self._here, self._other, self._there):
            os.close(descriptor)


@pytest.mark.slow
@pytest.mark.unmeasured
@pytest.mark.parametrize("language", LANGUAGES)
def test_passo_itself_over_a_noisy_cable(language, tmp_path):
    """`passo board` and `passo --frames jobs …`, each a process; the second one is killed amid an upload."""
    board = tmp_path / "board.py"
    board.write_text(f"BOARD = {framed_uploads.board(language)!r}\n")
    link = tmp_path / "port"
    passo = interpreter.passo()
    flash = tmp_path / "flash"
    process = subprocess.Popen([*passo, "board", "--board", str(board), "--link", str(link), "--flash", str(flash)], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    relay = None
    try:
        assert process.stdout.readline().startswith("port:")
        relay = Relay(str(link))
        relay.start()
        made = framed_uploads.Round(language, tmp_path, 7)
        command = [*passo, "--frames", "jobs"]
        at = ["--port", relay.name_of_port, "--protocol", language]

        def call(*words):
            done = subprocess.run([*command, *words, *at], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60)
            return done.stdout

        broken = subprocess.Popen([*command, "store", str(made.file), "--name", "PART", "--no-check", *at], cwd=ROOT)
        time.sleep(1.2)
        broken.kill()
        broken.wait()
        assert "PART" in call("store", str(made.file), "--name", "PART", "--no-check")
        data = stored_job.KINDS[language][0](made.file)
        assert f"{len(data)} bytes" in call("list")
        assert "PART: done" in call("run", "PART", *(["--home"] if language != "pulses" else []))
        call("delete", "PART")
        assert "0 jobs" in call("list")
        assert sum(wire.faults for wire in relay.wires.values()) > 5
    finally:
        process.terminate()
        process.wait(20)
        if relay:
            with contextlib.suppress(OSError):
                relay.close()

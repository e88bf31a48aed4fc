"""`passo prove --analyser`: a Pico as a logic analyser of eight channels, which writes its capture as VCD or in sigrok's format.

    Wanted(Path("seen.vcd"), 2, 25_000_000, trigger_of("rise:5", 2)).record_to_file(board, raw, False)      # GPIO2 to GPIO9; or seen.sr

The samples are taken on the chip, by a state machine of the second PIO block (board_analyser.py): their clock is the chip's.
"""

import zipfile
from dataclasses import dataclass
from pathlib import Path

from host_tools.failure import Failure
from host_tools.language import _
from host_tools.prove import pins
from host_tools.prove.proof import Proof
from host_tools.prove.row import number_text

CHANNELS = 8
FASTEST_HZ = 25_000_000
SLOWEST = 65_535  # cycles of the system clock to a sample
SAMPLES, PLAYED = 98_304, 16_384  # kept: of pins as they are, and beside a machine
PROGRAMS = "board_witness.py", "board_analyser.py"
_KINDS = {"fall": 0, "rise": 1, "word": 2}


@dataclass
class Capture:
    clock_hz: int
    divider: int  # of the clock, to a sample
    samples: bytes

    @property
    def hz(self):
        """The samples a second."""
        return self.clock_hz / self.divider

    @property
    def period_ps(self):
        return round(self.divider * 10**12 / self.clock_hz)


@dataclass
class Wanted:
    path: Path  # .vcd or .sr
    base: int  # the pin of channel 0
    hz: int  # at most
    trigger: tuple = ()
    play: bool = False  # the board file's axes move there and back, as the proof lets them; else the pins are looked at as they are
    wait_s: float = 30

    @classmethod
    def from_words(cls, path, base, mhz, trigger, play):
        """Make a Wanted of the options of a command: file, first GPIO, MHz, trigger ("rise:5"). Raises Failure if one is wrong."""
        if path.suffix not in WRITERS:
            raise Failure("a capture is a file .vcd or .sr (PulseView, sigrok-cli), not {}", path.name)
        return cls(path, base, round(mhz * 1e6), trigger_of(trigger, base), play)

    def record_to_file(self, board, raw, drive_pins):
        """Record, write the file, and return a sentence with its figures. Raises Failure if there is nothing to record."""
        if self.play and not drive_pins:
            raise Failure("nothing is played: no pins are driven")
        capture = self.capture_samples(Proof(board, raw, drive_pins))
        WRITERS[self.path.suffix](self.path, capture, names_of(raw, self.base))
        count = len(capture.samples)
        return _("{}: {} samples at {} MHz, {} ms", self.path, count, number_text(capture.hz / 1e6), number_text(1000 * count / capture.hz))

    def capture_samples(self, proof):
        """Record on the board; returns a Capture. Raises Failure if the rate is too low, or the trigger does not come in `wait_s`."""
        board = proof.board
        if self.play:
            changes = pins.without_ramps(proof)
            proof.begin("make", changes, more=(f"samples = bytearray({PLAYED})", *PROGRAMS))
            pins.check_enable(proof)
            order = f"play({pins.there_and_back(proof.machine(changes), pins.OWN_S)!r}, analyser)"
        else:
            board.restart_interpreter()
            proof.load(f"samples = bytearray({SAMPLES})", *PROGRAMS)
            order = f"record(analyser, {round(self.wait_s * 1000)})"
        clock = int(board.exec("import machine\nprint(machine.freq())"))
        divider = -(-clock // self.hz)
        if divider > SLOWEST:
            raise Failure("{} samples a second at least, not {}", -(-clock // SLOWEST), self.hz)
        board.exec(f"analyser = Analyser({self.base}, samples, {divider}, {self.trigger!r})\ngc.collect()")
        (_late, taken, _finished), rows = pins.run_on_board(proof, order, self.wait_s + 120)
        if self.play:
            pins.check_enable(proof)
        if not taken:
            raise Failure("the trigger did not come within {} s", self.wait_s) if self.trigger else Failure("the analyser has seen nothing: its DMA carries nothing")
        return Capture(clock, divider, pins.bytes_printed(rows[:-1]))


def trigger_of(given, base):
    """Return (kind, pin or word, channels) for the board of `rise:PIN`, `fall:PIN`, `word:LEVELS` or None. Raises Failure."""
    if not given:
        return ()
    kind, _colon, rest = given.partition(":")
    if kind in ("rise", "fall") and rest.isdecimal() and int(rest) < 30:
        return _KINDS[kind], int(rest)
    if kind == "word" and 1 <= len(rest) <= CHANNELS and set(rest) <= set("01"):
        return _KINDS[kind], sum(1 << bit for bit, level in enumerate(rest) if level == "1"), len(rest)
    raise Failure("a trigger is rise:PIN, fall:PIN or word:LEVELS, as many as 8 of 0 and 1 from GPIO{} on, not {!r}", base, given)


def names_of(raw, base):
    """Return a name for each channel: that of the output, input or motor that the board file has on its pin, or GPIOn."""
    names = {pin: f"GPIO{pin}" for pin in range(base, base + CHANNELS)}
    for item in (*raw.get("outputs", ()), *raw.get("inputs", ())):
        names[item["pin"]] = item["name"]
    if raw.get("drive", {}).get("kind") == "step_dir":
        for axis, letter in zip(raw["axes"], "xyza"):
            for pin, what in zip(axis["pins"], ("step", "dir")):
                names[pin] = f"{what}_{letter}"
    return [names[pin] for pin in range(base, base + CHANNELS)]


def _write_vcd(path, capture, names):
    """Write a capture to `path` as VCD, one wire for each name, bit 0 first. The time unit is the largest power of ten that divides the sample's
    period."""
    from vcd import VCDWriter

    # The largest unit that divides a sample's period: programs that sample a VCD anew use the file's unit as their period.
    unit = next(unit for unit in (10**power for power in range(8, -1, -1)) if capture.period_ps % unit == 0)
    scale = next(f"{unit // size} {name}" for name, size in (("us", 10**6), ("ns", 1000), ("ps", 1)) if unit >= size)
    step = capture.period_ps // unit
    with open(path, "w", encoding="ascii", newline="\n") as file, VCDWriter(file, timescale=scale, date="", version="passo prove", check_values=False) as writer:
        wires = [writer.register_var("passo", name, "wire", size=1, init=capture.samples[0] >> bit & 1) for bit, name in enumerate(names)]
        before = capture.samples[0]
        for number, levels in enumerate(capture.samples):
            for bit, wire in enumerate(wires):
                if (levels ^ before) >> bit & 1:
                    writer.change(wire, number * step, levels >> bit & 1)
            before = levels
        writer.close(len(capture.samples) * step)


def _write_sigrok(path, capture, names):
    """Write a capture to `path` in sigrok's session format (.sr): a zip of version, metadata and samples, a byte each."""
    probes = "".join(f"probe{number}={name}\n" for number, name in enumerate(names, 1))
    metadata = f"[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\ntotal probes={CHANNELS}\nsamplerate={capture.hz:.0f} Hz\ntotal analog=0\n{probes}unitsize=1\n"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("version", "2")
        file.writestr("metadata", metadata)
        file.writestr("logic-1-1", capture.samples)


WRITERS = {".vcd": _write_vcd, ".sr": _write_sigrok}

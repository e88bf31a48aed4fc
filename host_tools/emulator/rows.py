"""Streams to the emulated Pico as senders send them: lines of 0.2 mm, and a laser's dots as lines, as clusters and packed.

    machine = fast_laser(200)                                   # booted; boards/laser_fast.py with 200 m/s²
    run = on_a_copy(lambda: measure_stream(machine, "usb", "packed", 1000))
    run["rate"], run["late"], run["stands"], run["asked_ms"]    # dots a second, words late, standstills, of each `?`

A sender has `WINDOW` bytes under way, which `$I` tells, and takes `think_us` to hear an answer and to send what that makes room for.
"""

import copy

from host_tools import boards
from host_tools.drawings.engraving import pack_power
from host_tools.emulator import gcode
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.queries import Asking
from passo.protocols.grbl.lines import RX_BYTES

WINDOW = RX_BYTES - 1
BAUD = 921_600
KINDS = {"dots": (0.1, 350, 1), "clusters": (0.08, 480, 16), "packed": (0.04, 500, 100)}  # mm of a dot, mm/s, dots a line
DOTS = {"dots": 3000, "clusters": 8000, "packed": 12_000}
LINES = 1600
LINE_MM, LINE_MM_S = 0.2, 490
ROW_MM = 40
STAND_MS = 10  # without a step: longer than any turn of a row at 200 m/s²
ASK_MS = 9.3
LIMIT_MS = 60_000


def fast_laser(clock_mhz):
    """Boot a laser_fast whose axes are faster than any link."""
    board = {**copy.deepcopy(boards.load("laser_fast")), "clock_mhz": clock_mhz, "journal": None}
    for axis in board["axes"]:
        axis.update(max_mm_min=30_000, accel_mm_s2=200_000)
    return _boot_board(board)


def fast_router(clock_mhz):
    """Boot a router_3axis whose axes are faster than any link, its serial link at BAUD."""
    board = copy.deepcopy(gcode.fast_board((), clock_mhz=clock_mhz, mm_s=500, mm_s2=300_000)[0])
    return _boot_board({**board, "journal": None})


def _boot_board(board):
    """Boot a machine of `board` without frames, its UART links at BAUD."""
    board["links"] = [{key: value for key, value in link.items() if key != "lost"} for link in board["links"]]
    for link in board["links"]:
        if link["port"] != "usb":
            link["baud"] = BAUD
    machine = gcode.boot_router(board)
    gcode.talk_to(machine)
    return machine


def dots(kind, times=1):
    """Return (head, lines, dots) of rows there and back, of powers that all differ; `times` as many."""
    dot_mm, mm_s, each = KINDS[kind]
    count = round(ROW_MM / dot_mm / each) * each
    powers = [0 if dot % 7 == 6 else dot * 397 % 999 + 1 for dot in range(count)]
    lines = []
    for sign in (1, -1):
        lines.append(f"G0Y{sign * 0.1:g}")
        for first in range(0, count, each):
            part = powers[first : first + each]
            row = "=" + "".join(pack_power(power / 1000) for power in part) if kind == "packed" else ":".join(map(str, part))
            lines.append(f"{'' if first else 'G1'}X{sign * dot_mm * each:.2f}S{row}")
    rows = -(-DOTS[kind] * times // count)
    return ["$X", "G21G91G94", f"M4S0F{60 * mm_s}", "G0"], (lines * rows)[: rows * (len(lines) // 2)], rows * count


def _count_oks(asking):
    return asking.said.count(b"ok\r\n")


def measure_stream(machine, link, kind, think_us, times=1):
    """Stream lines or dots; return {"rate": lines or dots a second without the first quarter, "late": words late, "stands", "asked_ms", …}.
    `think_us`: time that the sender takes to read an answer; `times`: how many times as long."""
    if kind == "lines":
        start, text = gcode.chords(LINE_MM)
        lines = [line.decode().strip() for line in text.splitlines()]
        count = LINES * times
        lines = (lines * (count // len(lines) + 1))[:count]
        head = ["$X", "G21G90G94", f"G92X{start}Y50Z-20", f"G1F{60 * LINE_MM_S}"]
    else:
        head, lines, count = dots(kind, times)
    if link != machine.board["links"][0]["name"]:
        head = ["$LINK=0", *head]
    asking = Asking(machine, link, think_us, WINDOW)
    edges = machine.pico.record_edges(machine.board["axes"][0]["pins"][0])
    asking.stream_lines([line.encode() + b"\n" for line in head])
    machine.run_until(lambda: _count_oks(asking) >= len(head), 5000)
    asking.ask_status()  # as every sender does first; it makes the buffers
    asking.stream_lines([line.encode() + b"\n" for line in (*lines, "G4P0.01", "$LOG")])
    begun, asked_ms = [], []
    for wanted in (len(lines) // 4, len(lines)):
        until = wanted + len(head)
        while _count_oks(asking) < until:
            asked_ms.append(asking.ask_status())
            machine.pico.run_until(lambda: _count_oks(asking) >= until, ASK_MS * 1000, 100)
            assert len(asked_ms) * ASK_MS < LIMIT_MS
        begun.append(machine.pico.cycle)
    machine.run_until(lambda: _count_oks(asking) >= len(lines) + len(head) + 2, LIMIT_MS)
    assert b"error" not in asking.said, bytes(asking.said[-200:])
    lost = getattr(machine.wire(link), "overruns", 0)  # USB loses none
    assert not lost, f"{lost} bytes came while the UART's FIFO was full"
    rises = [cycle / CYCLES_PER_US / 1000 for cycle, state in edges if state == 1]
    return {
        "rate": (count - count // 4) * 1000 * gcode.CYCLES_PER_MS / (begun[1] - begun[0]),
        "late": asking.said.count(b"[LOG:"),
        "stands": sum(after - before > STAND_MS for before, after in zip(rises, rises[1:])),
        "asked_ms": sorted(asked_ms),
    }

"""Runs on the board, in the raw REPL after a soft reset: the machine of its board file without what it is wired to.

    make({"journal": None, …}, ["outputs", …])      # changes, and keys left out
    words({…}, […])                                 # the same machine on a port without pins: see board_words.py
"""

import gc
import sys
from binascii import crc32
from time import sleep_ms, ticks_diff, ticks_ms, ticks_us

import machine
import micropython
from machine import mem32

import passo
from board import BOARD
from passo.ports.safe import outputs, safe

safe(outputs(BOARD))  # first of all: the motors' current is off, and stays so
try:
    import passo_image as image
except ImportError:
    image = None
if image and image.choose_package():
    from passo.ports.rp2.start import Start
else:
    from passo.ports.rp2.stock.start import Start


def deep_copy(value):
    """Return a copy of lists and dicts: MicroPython has no copy.deepcopy."""
    if isinstance(value, dict):
        return {key: deep_copy(value[key]) for key in value}
    return [deep_copy(each) for each in value] if isinstance(value, list) else value


def _check_board(changes, without):
    """Check BOARD with `changes` and without the keys `without`, and keep it in `board`, before the app is loaded."""
    global start, board
    raw = deep_copy(BOARD)
    for key in without:
        raw.pop(key, None)
    raw.update(changes)
    start = Start(BOARD)
    start.begin_loading()
    from passo.config.boardfile import check

    board = check(raw)
    start.load(board)


def _load_app():
    """Import all modules that the board wants. Returns App."""
    from passo.app import App
    from passo.machine_builder import load_all

    load_all(board)
    start.finish_loading()
    return App


def _make_app(App, made):
    """Build the app on the port `made`, and keep its parts in globals. The collector then runs only when asked or when memory is full."""
    global port, app, planner, feeder, player
    port = made
    app = App(board, port, None, None)
    planner, feeder, player = app.planner, app.feeder, app.player
    start.settle(app)


def make(changes, without):
    _check_board(changes, without)
    App = _load_app()
    _make_app(App, start.port(board))


def words(changes, without):
    _check_board(changes, without)
    _make_app(_load_app(), Words())


def time_collection():
    """Return microseconds of a collection, bytes free, and the largest piece."""
    begun = ticks_us()
    gc.collect()
    took = ticks_diff(ticks_us(), begun)
    low, high = 0, gc.mem_free()
    free = high
    while high - low > 64:
        middle = (low + high) // 2
        try:
            bytearray(middle)
            low = middle
        except MemoryError:
            high = middle
        gc.collect()
    return took, free, low


def pin_level(pin):
    return mem32[0xD0000004] >> pin & 1


def set_pull(pin, up):
    """Let the pad's own resistor pull; whatever is wired to the pin is stronger."""
    at = pad_address(pin)
    mem32[at] = mem32[at] & ~12 | (8 if up else 4)


def queue_lines(lines):
    """Queue lines, [(steps of each axis, ticks)], for the next cycle to play."""
    feeder.open = False  # until a cycle opens it: if the interrupt set out first, the motors would not count as ready before all of it was played
    for deltas, ticks in lines:
        planner.line(deltas, ticks, False)
    planner.flush()
    app.controller.machine.awake = True


def play(lines, witness):
    """Play lines to their end under the witness's eyes."""
    queue_lines(lines)
    witness.start()
    end = ticks_ms() + 5000
    while (not planner.empty() or player.busy()) and ticks_diff(end, ticks_ms()) > 0:
        app.cycle()
    witness.stop()
    print("\n=", feeder.late, witness.taken, 1 if planner.empty() else 0)
    witness.print_records()


def clear_stop():
    """Forget a stop: its input has been let go."""
    for _ in range(3):
        app.cycle()
    planner.clear()
    state = app.controller.machine
    state.abort()
    state.alarm = 0
    feeder.open = True
    app.cycle()


def halt(lines, witness, other, pin, active, after_ms):
    """Start lines, pull the input to its active level after `after_ms`, then release it and clear the alarm."""
    queue_lines(lines)
    witness.start(other)
    end = ticks_ms() + after_ms
    while ticks_diff(end, ticks_ms()) > 0:
        app.cycle()
    set_pull(pin, active)
    end = ticks_ms() + 20
    while ticks_diff(end, ticks_ms()) > 0:
        app.cycle()
    witness.stop()
    other.stop()
    reached = pin_level(pin) == active
    where = feeder.position(player.words_played())
    set_pull(pin, not active)
    sleep_ms(1)
    clear_stop()
    print("\n=", 1 if reached else 0, *where)
    witness.print_records()
    other.print_records()


def echo_bytes(count):
    """Read bytes of the link, and then send as many back. Prints how many came and their checksum."""
    line = app.links[0].serial
    micropython.kbd_intr(-1)
    came = sum = 0
    last = ticks_ms()
    while came < count and ticks_diff(ticks_ms(), last) < 1000:
        data = line.read()
        if data:
            came += len(data)
            sum = crc32(data, sum)
            last = ticks_ms()
    micropython.kbd_intr(3)
    print("took", came, sum)
    out = bytes(range(128, 256))
    for _ in range(count // 128):
        sys.stdout.buffer.write(out)


def serve(silent_ms):
    """Run the machine's main loop until no byte has come for `silent_ms`."""
    micropython.kbd_intr(-1)
    line = app.links[0].serial
    print("ready")
    last = ticks_ms()
    while ticks_diff(ticks_ms(), last) < silent_ms:
        if line.any():
            last = ticks_ms()
        app.cycle()
    micropython.kbd_intr(3)
    print("\nserved", feeder.late)

"""The surroundings of the app on a chip: a safe start, ways back to the REPL, and the traces of a crash.

    start = Start(board)            # a raw board file: outputs go safe here, whatever else may be wrong with it
    if start.ready():               # no: the chip's button, or the input named "repl", is held
        port = start.port(board)    # now a checked one
        ...

A chip's own Start knows its button and its port.
"""

import gc
import os
import sys
from io import StringIO
from time import ticks_diff, ticks_ms

import machine
from machine import Pin
from micropython import alloc_emergency_exception_buf, const

from passo.ports.safe import entries, outputs, safe

FROZEN = str(sys.modules["passo"].__path__).startswith(".frozen")  # into the UF2: nothing is loaded into memory but the kernels
if not FROZEN and __file__.endswith(".py") and (1, 26) <= sys.implementation.version[:2] < (1, 28):
    # Their own compiler for viper overwrites the index in `words[i] = …` (MicroPython #18800).
    raise RuntimeError("source files want MicroPython 1.28; with 1.26 and 1.27 use passo flash, which sends compiled ones")

GRACE_MS = const(2000)  # after a reset, in which Ctrl-C still gives the REPL
REPORT = "crash.txt"
_PULLS = {"up": Pin.PULL_UP, "down": Pin.PULL_DOWN}


class Start:
    def __init__(self, board):
        alloc_emergency_exception_buf(100)
        self._outputs = outputs(board)
        self._ways_out = [entry for entry in entries(board, "inputs") if isinstance(entry, dict) and entry.get("name") == "repl"]
        self._since_ms = ticks_ms()
        safe(self._outputs)

    def ready(self):
        """Return False if the REPL is asked for instead of the app: the button, or the input "repl", is held. Prints which."""
        button = self.button()
        if button:
            print("%s is held: no app, the REPL" % button)
            return False
        for entry in self._ways_out:
            pin = Pin(entry["pin"], Pin.IN, _PULLS.get(entry.get("pull", "up")))
            if pin.value() == entry.get("active", 1):
                print("input repl is active: no app, the REPL")
                return False
        return True

    def button(self):
        """Return the name of the chip's button if it is held; else None."""
        return None

    def begin_loading(self):
        """Make ready for the imports of the app: called before them."""

    def load(self, board):
        """Import what port() will ask for: called before the app is imported, when `board` has been checked."""

    def finish_loading(self):
        """End what begin_loading() began: called when all is loaded, or the start has failed. Returns a line for people: where the code lies."""
        return ""

    def history(self):
        """Print why the last run ended, if it did not end well."""
        try:
            with open(REPORT) as file:
                print("the last run ended by:")
                print(file.read())
            os.rename(REPORT, "last_" + REPORT)
        except OSError:
            if machine.reset_cause() == machine.WDT_RESET:
                print("the last run ended by: reset, by program or by the watchdog")

    def settle(self, app):
        """Collect what the making of the app has left: called when it is about to run."""
        gc.collect()

    def run(self, app, port):
        """Run for ever; after the grace period the watchdog minds it."""
        self.settle(app)
        guarded = False
        while True:
            if app.poll():  # app.cycle() would cost stack, of which interrupts want theirs
                app.rest()
            if not guarded and ticks_diff(ticks_ms(), self._since_ms) > GRACE_MS:
                guarded = True
                port.guard()

    def end(self, app, port, error=None):
        """Stop the machine, make all safe, and leave a report where there was an error. Nothing moves any more."""
        try:
            said = self.finish_loading()
            if said and error is not None:
                print(said)
            if app is not None:
                app.stop()
        finally:
            if port is not None:
                port.close()
            safe(self._outputs)
        if error is None:
            return
        text = StringIO()
        sys.print_exception(error, text)
        print(text.getvalue())
        try:
            with open(REPORT, "w") as file:
                file.write(text.getvalue())
        except (OSError, MemoryError) as full:
            print("no report written:", full)

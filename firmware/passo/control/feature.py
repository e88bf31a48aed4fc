"""The methods of a feature of the machine: its class overrides those that it needs.

    class Beeper(Feature):
        def handlers(self):
            return {commands.BEEP: self._beep}

A feature sees the record of state.py and the queue, and no other feature: it asks another one with a command.
The methods of a cycle and of a report are called only where a class has its own, see overriding(). Methods that do nothing share
one function: on stock MicroPython each function takes 60 bytes of memory.
"""

from micropython import const

# Events of the whole machine, masks:
QUEUE_GONE = const(1)  # a hold has come to its stand, and the commands queued after it are gone
WORK_GONE = const(2)  # all work is dropped
HOMING = const(4)  # homing begins
SAFE = const(8)  # the safe state, at once
OFF = const(16)  # outputs off until the next reset
HANDED_OVER = const(32)  # another link commands: switch the tool off; outputs stay, one may hold the work
ANEW = const(64)  # as after power-up
BY_HAND = const(128)  # a jog begins
REFUSAL = const(256)  # a line of the link that commands is refused


def _do_nothing(self, _=None):
    """Do nothing. The None returned also answers a question: no, none."""


class Feature:
    def __init__(self, board, machine, queue):
        self._machine = machine
        self._queue = queue

    handlers = _do_nothing  # handlers(): {kind of command: handler}; a handler returns as Controller.accept()
    guard = _do_nothing  # guard(handlers): all features' are in `handlers`; put your own before those of others
    batches = _do_nothing  # batches(): {kind of batch: (open, accept, close)}: see Controller.batches()

    # Once a cycle of the main loop:
    look = _do_nothing  # look(now_ms): look at what comes from outside, whatever the machine does: inputs, other sensors
    poll = _do_nothing  # poll(now_ms), only while the machine is awake: go on with the work; sets `machine.awake` if there will be more of it
    poll_hold = _do_nothing  # poll_hold(), behind poll(): the same, while a hold or what drops the rest is on its way or stands
    poll_end = _do_nothing  # poll_end(still), behind poll(); `still`: nothing is queued or plays

    # Questions:
    owns_axes = _do_nothing  # owns_axes(): while the axes are this feature's alone "run", or "hold" if it stands amid its work until somebody says what next
    may_change = _do_nothing  # may_change(): True while what is under way may change at any moment: few words should lie ahead
    ready = _do_nothing  # ready(): True if words may be played; only a feature that overrides it has a say
    busy = _do_nothing  # busy(): True while it is about to move, though nothing is queued
    report = _do_nothing  # report(report): adds to a status report; report["link"] has asked for it, None: nobody has

    # Events:
    claim_stop = _do_nothing  # claim_stop(name): `name` has stopped the player; True if it was this feature's affair, and an alarm has been raised
    halt = _do_nothing  # halt(): the pins have stopped; the queue is dropped next
    event_mask = 0  # of the masks above: those that on_events() is for
    on_events = _do_nothing  # on_events(what): all events of one moment, as masks
    show_outputs = _do_nothing  # show_outputs(on): False: the door holds the machine; True: it goes on


def overriding(features, name):
    """Return the methods `name` of those features whose class overrides it, in order."""
    return tuple([getattr(feature, name) for feature in features if getattr(type(feature), name) is not _do_nothing])

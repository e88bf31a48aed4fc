"""The composition root: builds the machine of a board file on a port, and runs its main loop.

    app = App(BOARD, port)
    while True:
        app.turn()

Bytes from each link become commands, commands become motion, events become the bytes of answers. The only module that
knows every room.
"""

import gc
from micropython import const

from passo.control.boardfile import BoardError, check
from passo.control.controller import LATER, Controller
from passo.control.motors import Motors
from passo.drives import pbl3770a, step_dir, unipolar
from passo.drives.coils import CoilDrive
from passo.motion.planner import Planner
from passo.protocols import errors
from passo.protocols.commands import IMMEDIATE
from passo.steps.feeder import Feeder
from passo.steps.ring import Ring
from passo.steps.word import TICKS_PER_S, Layout, us_to_ticks

LEAD_TICKS = const(30 * 12_500)  # from a main loop
_WAITING = const(64)  # commands of one link that may wait for their turn

PROTOCOLS = ("plotter",)


def open_protocol(link, board):
    """The protocol of a link of the board file; only what is named is loaded."""
    name = link["protocol"]
    if name == "plotter":
        from passo.protocols.plotter import Plotter

        sign = 1 if board["jog"]["up"][1] == "+" else -1
        return Plotter(link["idle_gap_ms"], (0, sign) if board["jog"]["up"][0] == "y" else (sign, 0))
    raise BoardError("link %s: unknown protocol %r; known are %s" % (link["name"], name, ", ".join(PROTOCOLS)))


def make_drive(board):
    """(layout, drive, levels without current) of the board's motors; drive is None where the step form will do."""
    kind = board["drive"]["kind"]
    names = [axis["name"] for axis in board["axes"]]
    count = len(names)
    if kind == "step_dir":
        return Layout(kind, count, 2 * count, step_dir.pin_names(names), (1 << count) - 1), None, 0
    motors = unipolar if kind == "unipolar" else pbl3770a
    mode = board["drive"]["mode"]
    backwards = 0
    for axis in range(count):
        backwards |= board["axes"][axis]["reversed"] << axis
    hold = motors.HOLD[mode] if kind == "pbl3770a" else None
    drive = CoilDrive(count, motors.MODES[mode], motors.WIDTH, hold, backwards)
    pins = [name + "_" + pin for name in names for pin in motors.PINS]
    off = 0
    for axis in range(count):
        off |= motors.OFF << axis * motors.WIDTH
    return Layout("coils", count, count * motors.WIDTH, pins, 0), drive, off


class Link:
    """One serial line: its protocol, and the commands that wait for their turn."""

    def __init__(self, config, serial, protocol):
        self.name = config["name"]
        self.serial = serial
        self.protocol = protocol
        self.waiting = []


class App:
    def __init__(self, board, port, protocols=None):
        """`protocols` may name another protocol for a link: {link name: protocol}. Raises BoardError."""
        self.board = board = check(board)
        for link in board["links"]:
            link["protocol"] = (protocols or {}).get(link["name"], link["protocol"])
        self.port = port
        self.layout, drive, off_levels = make_drive(board)
        self.ring = Ring()
        self.player = port.player(self.ring, self.layout)
        gc.collect()  # so that what is small fills the gaps and leaves room in one piece for what is large
        self.planner = Planner(self.layout.axes)
        least = self.player.min_word_ticks
        self._check_speed(least)
        setup = us_to_ticks(board["drive"]["setup_us"]) if drive is None else 0
        self.feeder = Feeder(self.ring, self.layout, self.planner, drive, setup and max(setup, least), least)
        self.interrupt = port.feed_from_interrupt(self.feeder, self.player)
        motors = Motors(port, self.player, self.layout, drive, off_levels, board)
        motors.release()
        gc.collect()
        self.controller = Controller(board, self.planner, self.feeder, self.player, motors, port)
        self.links = [Link(link, port.serial(link), open_protocol(link, board)) for link in board["links"]]

    def _check_speed(self, least):
        """Every speed the board file allows must leave the player its shortest word."""
        speed = self.board["speed"]
        fastest = us_to_ticks(2 * speed["min"]) if speed["unit"] == "half_period_us" else TICKS_PER_S // speed["max"]
        if fastest < least:
            raise BoardError("speed: steps every %d ticks of 80 ns; the drive needs %d" % (fastest, least))

    def poll(self):
        """Links, then machine, then answers, then words for the player."""
        now_ms = self.port.link_ms()
        for link in self.links:
            self._receive(link, now_ms)
        tripped = self.port.tripped()
        if tripped and not self.controller.alarm:
            self.controller.fail(errors.ALARM_HALT_INPUT, tripped)
        self.controller.poll()
        for event in self.controller.take_events():
            link = event.command.link
            answer = link.protocol.reply(event)
            if answer:
                link.serial.write(answer)
        self.feeder.open = self.controller.may_feed()
        if not self.interrupt and self.feeder.open:
            self.feeder.fill(self.player.played(), LEAD_TICKS)
            self.player.start()

    def turn(self):
        """poll(), then let time pass."""
        self.poll()
        controller = self.controller
        self.port.wait(controller.busy(), controller.state == "home")

    def _receive(self, link, now_ms):
        for command in link.protocol.feed(link.serial.read(), now_ms):
            command.link = link
            if command.kind in IMMEDIATE:
                self.controller.accept(command)
            elif len(link.waiting) < _WAITING:
                link.waiting.append(command)
            else:
                self.controller.refuse(command, errors.TOO_MANY_WAITING)
        while link.waiting and self.controller.accept(link.waiting[0]) != LATER:
            link.waiting.pop(0)

    def stop(self):
        """Halt, tool off, motors without current."""
        self.controller.shut_down()

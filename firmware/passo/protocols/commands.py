"""The vocabulary that all languages share: what a command asks of the machine, and what the machine answers.

A protocol turns bytes into Commands and Events into bytes; the controller turns Commands into Events. What a protocol
could not understand is a Command too, BAD with the number of the error, so that it is logged and answered like others.
"""

from micropython import const

BAD = const(0)  # `error`: why the bytes were no command
HELLO = const(1)  # is the controller there?
STATUS = const(2)  # state, last error, position
STOP = const(3)  # stop now, tool off, drop what was stored
HOME = const(4)
SPEED = const(5)  # `value`: drawing speed, in the unit of the board file
POINT = const(6)  # `target` in steps from the origin, `tool`: append to the stored object
DRAW = const(7)  # draw the stored object to its end, then clear it
JOG = const(8)  # `target`: direction of each axis, −1, 0 or +1; the distance is the board file's

IMMEDIATE = (BAD, HELLO, STATUS, STOP)  # never wait behind another command

ACCEPTED = const(0)
REFUSED = const(1)  # `error` says why; nothing moved
FINISHED = const(2)  # a command that takes time has done what it was asked


class Command:
    def __init__(self, kind, target=None, value=0, tool=False, error=0):
        self.kind = kind
        self.target = target
        self.value = value
        self.tool = tool
        self.error = error
        self.link = None  # set by the app: where the answer goes


class Event:
    def __init__(self, kind, command, error=0, value=None):
        self.kind = kind
        self.command = command
        self.error = error
        self.value = value  # STATUS: the report

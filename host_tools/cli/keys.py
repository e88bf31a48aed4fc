"""`passo keys`: the two-motor kit from the terminal, key by key."""

import re
import sys
import time
from contextlib import contextmanager
from typing import Annotated, Optional

import typer

from host_tools.cli.options import Baud, Port
from host_tools.failure import Failure
from host_tools.language import _

_TOKEN = re.compile(r"([ABab])\s*(\d+)|([C-Jc-j])|(\d+(?:\.\d+)?)\s*(ms|s)\b|(\S+)")
_LEAVE = ("q", "\x03", "\x04", "\x1b")


def keys(
    send: Annotated[
        Optional[str], typer.Option(metavar="KEYS", help="Send these keys and end: \"A5 C 2s J\".")
    ] = None,
    port: Port = None,
    baud: Baud = 9600,
):
    """Drive the two-motor kit: send keys as they are pressed, and show the state of the motors.

    A n and B n set the speed of motor 1 and 2 (n = 1 … 127, a step every n × 4 ms, then Enter), C and D switch motor 1 and
    2 on, E and F off, G and H reverse them, I switches both on and J both off. q or Ctrl-C switches both off and leaves.
    The kit never answers: the state shown is computed from the keys sent.

    With --send, or from a pipe, keys are words, and 2s or 500ms wait; at the end the motors stay as they are.

    Examples:

        passo keys --port /dev/ttyUSB0
        passo keys --send "A1 C"
        passo keys --send "A5 B10 I 2s G 500ms J" --port /tmp/kit

        echo "I 10s J" | passo keys
    """
    from host_tools.cli import ports
    from host_tools.clients.serial_port import open_port

    items = parse_keys(send) if send is not None else None
    kit = Kit(open_port(port or ports.only_port(), baud))
    try:
        if items is not None:
            kit.press_all(items)
            print(kit)
        elif sys.stdin.isatty():
            _press_live(kit)
        else:
            for line in sys.stdin:
                kit.press_all(parse_keys(line.split("#")[0]))
                print(kit)
    finally:
        kit.close()


def parse_keys(text):
    """Convert words to a list of bytes to send and seconds to wait. Raises Failure at the first that is neither."""
    from passo.protocols.keys.kit import KIT_SLOWEST

    items = []
    for speed, number, key, amount, unit, other in _TOKEN.findall(text):
        if other:
            raise Failure("{!r} is no key: A n, B n with n = 1 … {}, C … J, or a wait such as 2s or 500ms", other, KIT_SLOWEST)
        if amount:
            items.append(float(amount) / (1000 if unit == "ms" else 1))
        elif key:
            items.append(key.upper().encode())
        elif not 1 <= int(number) <= KIT_SLOWEST:
            raise Failure("{} {}: the speed is 1 (fastest) … {}", speed.upper(), number, KIT_SLOWEST)
        else:
            items.append(bytes([ord(speed.upper()), int(number)]))
    return items


class Kit:
    """A serial port with the kit at its other end, and the state that follows from the keys sent."""

    def __init__(self, serial):
        self._serial = serial
        self.on = [False, False]
        self.speed = [1, 1]
        self.reverse = [False, False]

    def close(self):
        """Close the port; the motors stay as they are."""
        self._serial.close()

    def press_all(self, items):
        """Send keys (bytes) and wait (seconds, floats) in turn. Raises LinkError if the port is lost."""
        for item in items:
            if isinstance(item, float):
                time.sleep(item)
            else:
                self.press_key(item)

    def press_key(self, data):
        """Send one task: a byte, or two for a speed. Raises LinkError if the port is lost."""
        from host_tools.clients.serial_port import port_error

        try:
            self._serial.write(data)
            self._serial.flush()
        except (OSError, ValueError) as error:
            raise port_error(self._serial.port, error) from error
        self._note_state(data)

    def _note_state(self, data):
        """Note the state of the motors that follows from a task, as the firmware's protocol has it."""
        from passo.protocols.keys.protocol import OFF, ON, REVERSE, SPEED

        key = data[0]
        if key in SPEED:
            self.speed[SPEED[key]] = data[1]
        if key in REVERSE:
            self.reverse[REVERSE[key]] = not self.reverse[REVERSE[key]]
        for motor in range(2):
            if ON.get(key, 0) >> motor & 1:
                self.on[motor] = True
            if OFF.get(key, 0) >> motor & 1:
                self.on[motor] = False

    def __str__(self):
        from passo.protocols.keys.kit import KIT_STEP_MS

        motors = []
        for motor in range(2):
            state = _("off")
            if self.on[motor]:
                way = _("anticlockwise") if self.reverse[motor] else _("clockwise")
                state = _("{}, {:.1f} steps/s (speed {})", way, 1000 / (KIT_STEP_MS * self.speed[motor]), self.speed[motor])
            motors.append(_("motor {}: {}", motor + 1, state))
        return "   ".join(motors)


def _press_live(kit):
    """Send keys as they are pressed, and show the motors' state, until q or Ctrl-C switches both off."""
    print(_("A n, B n: speed    C D I: on    E F J: off    G H: reverse    q: both off, and leave"))
    with _raw_terminal():
        while True:
            print(f"\r\x1b[K{kit}", end="", flush=True)
            character = sys.stdin.read(1)
            if not character or character in _LEAVE:
                kit.press_key(b"J")
                print(f"\r\x1b[K{kit}\r")
                return
            key = character.upper()
            if key in "AB":
                _read_speed(kit, key)
            elif key in "CDEFGHIJ":
                kit.press_key(key.encode())


def _read_speed(kit, key):
    """Read the digits of a speed up to Enter, and send it; print why a wrong one is not sent."""
    digits = ""
    while True:
        print("\r\x1b[K" + _("speed of motor {}: {}", 1 + (key == "B"), digits), end="", flush=True)
        character = sys.stdin.read(1)
        if character.isdigit():
            digits += character
        elif character in "\x7f\b":
            digits = digits[:-1]
        else:
            break
    if character in "\r\n " and digits:
        try:
            kit.press_all(parse_keys(f"{key}{digits}"))
        except Failure as failure:
            print(f"\r\x1b[K{failure.message()}\r")


@contextmanager
def _raw_terminal():
    """Have the terminal give each character as it is pressed, Ctrl-C too, within the block. Raises Failure on Windows."""
    try:
        import termios
        import tty
    except ImportError:
        raise Failure("keys cannot be read one by one on this system: use --send, or a pipe") from None
    before = termios.tcgetattr(sys.stdin)
    tty.setraw(sys.stdin)
    try:
        yield
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)

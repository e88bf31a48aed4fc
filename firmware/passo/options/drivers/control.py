"""TMC2209 and TMC2226 drivers on one UART wire: set up and read back at the start, watched from then on.

    "drivers": {"port": "uart1", "tx": 8, "rx": 9, "motors": [{"axis": "x", "address": 0, "current_ma": 800}]}

One telegram at a time is on its way. The main loop looks for its reply once a cycle and never waits; without a good reply the telegram is
sent three times. Nothing moves before each driver has confirmed its set-up: the number of telegrams it has taken, and the two registers
that can be read. A failure raises an alarm, whose log entry names the axis; it stops the machine at once and takes the current off:

    221 no answer, or garbled     222 another chip, or registers that differ     223 a short, or overheated     224 the power failed

Unlocking sets the drivers up anew. While the machine is in one of these alarms it asks no more. Heat of 120 °C and open coils, which an idle motor
shows too, are only told: `Dr:x-hot,y-open` in a report. From a fault to its alarm: some 50 ms a driver, of a dead wire 0.2 s.
"""

from micropython import const

from passo.commands import STATUS_WORDS
from passo.control.feature import Feature
from passo.options.drivers import config as chip
from passo.options.drivers.errors import ALARM_DRIVER_DIFFERS, ALARM_DRIVER_FAULT, ALARM_DRIVER_POWER, ALARM_DRIVER_SILENT
from passo.records import COUNT_HALF, COUNT_MASK

_WORD = ("drives", "Dr")  # warnings by axis, in reports
ASKS = const(3)
_WAIT_MS = const(20)  # for a reply
PERIOD_MS = const(50)  # between two looks at a driver that is set up
_REPLY = const(8)  # bytes


class Motors(Feature):
    def __init__(self, board, machine, queue):
        config = board["additions"].drives
        Feature.__init__(self, board, machine, queue)
        if _WORD not in STATUS_WORDS:
            STATUS_WORDS.append(_WORD)
        self._motors = config["motors"]
        self._open_line(config)
        self._told = [""] * len(self._motors)  # warnings of each
        self._text = None  # all of it
        self._failed = 0  # the alarm that was raised
        self._due_ms = machine.port.machine_ms()
        self._begin_set_up()

    def _open_line(self, config):
        """Open the UART, and compute the registers of each driver."""
        line = dict(config)
        line["name"] = "drivers"
        self._line = self._machine.port.serial(line)
        self._registers = [chip.register_rows(motor, config["sense_mohm"]) for motor in self._motors]

    def _begin_set_up(self):
        """Begin to set all drivers up anew."""
        self._set = 0  # how many are
        self._number = 0  # of the driver that is asked
        self._stage = 0
        self._count = 0  # telegrams that it had taken
        self._tries = 0
        self._register = -1  # asked for, and its reply is awaited
        self._reply = b""

    def ready(self):
        """Return whether all drivers have confirmed their set-up: before, no word may be played."""
        return self._set == len(self._motors)

    def report(self, report):
        report["drives"] = self._text

    def look(self, now_ms):
        """Go on with the drivers, unless an alarm of theirs holds; once it is unlocked set them up anew."""
        if self._failed:
            if self._machine.alarm == self._failed:
                return
            self._failed = 0
            self._begin_set_up()
        self._poll_driver(now_ms)

    def _poll_driver(self, now_ms):
        """Read the reply that is awaited, or send the next request once it is due."""
        if self._register >= 0:
            self._read_reply(now_ms)
        elif (now_ms - self._due_ms) & COUNT_MASK < COUNT_HALF:
            self._send_request(now_ms)

    # --- telegrams

    def _send_request(self, now_ms):
        """Send the telegrams of this stage; the last one asks for a register."""
        self._line.read()  # bytes that no request asked for
        address = self._motors[self._number]["address"]
        stage = self._stage
        data = b""
        if self._set == len(self._motors):
            register = chip.DRV_STATUS if stage else chip.GSTAT
        else:
            register = (chip.IOIN, chip.IFCNT, chip.IFCNT, chip.GCONF, chip.CHOPCONF)[stage]
            if stage == 2:
                for row in self._registers[self._number]:
                    data += chip.make_telegram(address, *row)
        data += chip.make_telegram(address, register)
        self._sent = len(data)  # which the wire may give back
        self._line.write(data)
        self._register = register
        self._reply = b""
        self._due_ms = now_ms + _WAIT_MS + self._sent // 4

    def _read_reply(self, now_ms):
        """Take a whole reply. After _WAIT_MS without one ask again; after ASKS requests raise an alarm."""
        self._reply += bytes(self._line.read())
        found = chip.reply_value(self._reply[-_REPLY:], self._register)
        if found is not None and len(self._reply) in (_REPLY, _REPLY + self._sent):
            self._register = -1
            self._due_ms = now_ms
            self._tries = 0
            self._take_reply(found, now_ms)
        elif (now_ms - self._due_ms) & COUNT_MASK < COUNT_HALF:
            self._register = -1
            self._tries += 1
            if self._tries == ASKS:
                self._raise_alarm(ALARM_DRIVER_SILENT, "no answer")
            elif self._set < len(self._motors) and self._stage == 2:
                self._stage = 1  # they may have been taken: count anew

    def _take_reply(self, found, now_ms):
        """Compare the register `found` with the one expected at this stage: go on to the next stage, or raise an alarm."""
        if self._set == len(self._motors):
            if self._stage:
                self._judge_status(found, now_ms)
            else:
                self._stage = self._check_power(found)
            return
        rows = self._registers[self._number]
        stage = self._stage
        if stage == 0 and found >> 24 != chip.VERSION:
            self._raise_alarm(ALARM_DRIVER_DIFFERS, "version %02x" % (found >> 24))
        elif stage == 2 and (found - self._count) & 255 != len(rows):
            self._raise_alarm(ALARM_DRIVER_DIFFERS, "%d of %d registers taken" % ((found - self._count) & 255, len(rows)))
        elif stage > 2 and found != rows[stage - 5][1]:
            self._raise_alarm(ALARM_DRIVER_DIFFERS, "register %02x is %x, not %x" % (rows[stage - 5][0], found, rows[stage - 5][1]))
        else:
            self._count = found
            self._stage = stage + 1
            if self._stage == 5:
                self._stage = 0
                self._set += 1
                self._number = self._set % len(self._motors)

    def _check_power(self, state):
        """Return 1 if GSTAT says that the power has not failed. Else raise the alarm, and return 0."""
        if state & (chip.RESET | chip.UNDERVOLTAGE):
            self._raise_alarm(ALARM_DRIVER_POWER, "reset" if state & chip.RESET else "undervoltage")
            return 0
        return 1

    def _judge_status(self, found, now_ms):
        """Raise an alarm if DRV_STATUS says short or overheated; show hot and open coils in reports; go on to the next driver."""
        if found & (chip.OVERHEATED | chip.SHORTED):
            self._raise_alarm(ALARM_DRIVER_FAULT, "short" if found & chip.SHORTED else "overheated")
            return
        told = "-hot" if found & chip.WARNED else ""
        if found & chip.OPEN:
            told += "-open"
        if told != self._told[self._number]:
            self._told[self._number] = told
            texts = [motor["axis"] + text for motor, text in zip(self._motors, self._told) if text]
            self._text = ",".join(texts) or None
        self._stage = 0
        self._number = (self._number + 1) % len(self._motors)
        self._due_ms = now_ms + PERIOD_MS // len(self._motors)

    def _raise_alarm(self, number, why):
        """Raise an alarm of the driver that is asked. All have to be set up anew behind it."""
        self._failed = number
        self._set = 0
        self._machine.raise_alarm(number, "driver of %s: %s" % (self._motors[self._number]["axis"], why))

"""The spindle's frequency inverter over Modbus RTU: it turns as the tool's pin and the programme say, and has to prove it.

    "inverter": {"make": "delta", "port": "uart1", "tx": 20, "rx": 21, "baud": 9600}

The tool's pin leads. While it is on, the inverter gets the order to run at S; as soon as it is off, or the machine is in an alarm, the
order to stop, whatever has switched it off. A cut begins only when the inverter says that it is at speed. One request at a time goes out,
once a cycle of the main loop it is looked at, nothing waits: a request that has no good reply is sent three times. A third failure while
the spindle turns, or should stop, is an alarm that brings the axes to a stand, the position kept, and switches the tool's pin off:

    240 silence     241 garbled replies     242 a fault of the inverter     243 a request refused     244 not at speed
    245 late replies

Replies come in the order of their requests, but one to a read does not say which register it has. So behind a read without a reply in time,
a write goes out before the next read: once it is echoed, nothing older can come. Replies to older requests are dropped.

From a failure of the line to the alarm: 100 ms and three time-outs, 0.5 s as the board file has them by default. After it, stop
is sent every second until the inverter confirms it. While nothing turns a silent inverter is only logged.
The transceiver has to switch its direction by itself.
"""

from micropython import const

from passo import errors
from passo.commands import SPINDLE_OFF
from passo.control.spindle_speed import PERIOD_MS, SpindleSpeed
from passo.options.inverter import control_modbus as modbus
from passo.options.inverter.config import MAKES
from passo.options.inverter.errors import ALARM_INVERTER_FAULT, ALARM_INVERTER_GARBLED, ALARM_INVERTER_LATE, ALARM_INVERTER_REFUSED, ALARM_INVERTER_SILENT
from passo.records import COUNT_HALF, COUNT_MASK

_UNKNOWN = const(-1)
_ATTEMPTS = const(3)
_QUIET_MS = const(5)  # between two frames: 3.5 characters at 9600 baud are 4 ms
_AGAIN_MS = const(1000)  # to the next try, after the last of _ATTEMPTS
_LONGEST = const(8)  # bytes of a reply
_FRAMES_BITS = const(20 * 11)  # of a request and its reply, at most
_STANDING = const(200)  # hundredths of a hertz: the other way round only below it
# The topics of requests.
_STOP = const(0)
_FREQUENCY = const(1)
_START = const(2)
_OUTPUT = const(3)
_FAULT = const(4)


class Inverter(SpindleSpeed):
    def __init__(self, board, machine, queue):
        config = board["inverter"]
        SpindleSpeed.__init__(self, board, machine, queue, config)
        for alarm in (ALARM_INVERTER_SILENT, ALARM_INVERTER_GARBLED, ALARM_INVERTER_FAULT, ALARM_INVERTER_REFUSED, ALARM_INVERTER_LATE):
            errors.ALARMS[alarm] = errors.AT_STAND | errors.OUTPUTS_OFF
        self._make = MAKES[config["make"]]
        self._address = config["address"]
        self._poles = config["poles"]
        self._timeout_ms = config["timeout_ms"] + _FRAMES_BITS * 1000 // config["baud"]
        line = dict(config)
        line["name"] = "inverter"
        self._line = machine.port.serial(line)
        self._way = 0  # wanted: 3 clockwise, 4 counter-clockwise, 0 stop
        self._hz = 0  # and hundredths of a hertz
        self._told_way = self._told_hz = _UNKNOWN  # as the inverter has confirmed
        self._turned = 0  # the way it turned last
        self.output = 0  # hundredths of a hertz, as it said last
        self._about = _STOP
        self._request = None  # on its way
        self._reply = bytearray()
        self._owed = []  # requests that had no reply in time, the newest _ATTEMPTS
        self._unread = False  # a read had no reply in time, and none has had one since
        self._late = False  # the reply to one of them has come since the last good one
        self._sent_ms = 0
        self._due_ms = machine.port.machine_ms()  # the next request not before
        self._tries = 0
        self._noted = False  # that it does not answer, while nothing turns
        self._asks = _OUTPUT  # the topic of the next request

    def look(self, now_ms):
        """Read a reply, or send the next request; raise an alarm if the spindle is late."""
        self._update_order(now_ms)
        if self._request is not None:
            self._read_reply(now_ms)
        elif (now_ms - self._due_ms) & COUNT_MASK < COUNT_HALF:
            self._send_next(now_ms)
        if self._way and self.late(now_ms):
            self._raise_alarm(errors.ALARM_SPINDLE_SPEED, "inverter at %d.%02d Hz" % divmod(self.output, 100))

    # --- what it is to do

    def _update_order(self, now_ms):
        """Take over direction and frequency from the tool's pin, M3 or M4, and S; 0 in an alarm."""
        machine = self._machine
        way = machine.spindle
        if way == SPINDLE_OFF or machine.alarm or not self._queue.lit():
            way = hz = 0
        else:
            hz = min(self.target_rpm() * self._poles // 1200, 0xFFFF)
            if not hz:
                way = 0
                self.at_speed = True
        if way != self._way or hz != self._hz:
            self._way = way
            self._hz = hz
            self.begin(now_ms)
            if self._request is None:
                self._due_ms = (now_ms + _QUIET_MS) & COUNT_MASK

    def _send_next(self, now_ms):
        """Send the most important request now, if any: stop, frequency, start, then the readings in turn."""
        make = self._make
        way = self._way
        if self._told_way and self._told_way != way:
            self._send_request(now_ms, _STOP, make["stop"], 0)
        elif not way:
            return
        elif self._turned and self._turned != way and self.output > _STANDING:
            self._send_request(now_ms, _OUTPUT, make["output"], 0)  # until it stands: then the other way round
        elif self._told_hz != self._hz:
            self._send_request(now_ms, _FREQUENCY, make["frequency"], self._hz)
        elif self._told_way != way:
            self._send_request(now_ms, _START, make["forward" if way == 3 else "reverse"], 0)
        else:
            self._asks = _OUTPUT if self._asks == _FAULT or not make["fault"] else _FAULT
            self._send_request(now_ms, self._asks, make["output" if self._asks == _OUTPUT else "fault"], 0)

    def _send_request(self, now_ms, about, entry, hz):
        """Send a request; `about`: its topic, `entry`: function, register and value of the make, `hz`: hundredths of a hertz."""
        value = entry[2]
        if about == _FREQUENCY:
            value = min(hz * value // 100, 0xFFFF)
        self._about = about
        self._request = modbus.make_request(self._address, entry[0], entry[1], value)
        self._of = self._way, self._hz
        self._drop_late(bytearray(self._line.read() or b""), None)
        self._reply = bytearray()
        self._line.write(self._request)
        self._sent_ms = now_ms

    # --- what it says

    def _read_reply(self, now_ms):
        """Take the reply to the request under way, or count a failure if it is wrong or timeout_ms are over."""
        data = self._line.read()
        if data:
            self._reply.extend(data)
        reply = self._reply = self._drop_late(self._reply, self._request)
        wrong = modbus.fault_of(self._request, reply) if len(reply) >= _expect_bytes(self._request, reply) else None
        if wrong == modbus.WRONG and self._owed and len(reply) < _LONGEST:
            wrong = None  # it may be a late one, and not whole yet
        if wrong is not None:
            if not wrong:
                self._due_ms = (now_ms + _QUIET_MS) & COUNT_MASK
                self._take_reply(now_ms)
            elif wrong == modbus.REFUSED:
                self._tries = _ATTEMPTS
                self._count_failure(now_ms, ALARM_INVERTER_REFUSED, "inverter: exception %d" % reply[2])
            else:
                self._count_failure(now_ms, ALARM_INVERTER_GARBLED, "inverter")
        elif (now_ms - self._sent_ms) & COUNT_MASK > self._timeout_ms:
            number = ALARM_INVERTER_GARBLED if reply else ALARM_INVERTER_SILENT
            self._owed = self._owed[1 - _ATTEMPTS :] + [self._request]
            if self._about >= _OUTPUT:
                self._unread = True
                self._told_hz = _UNKNOWN  # the write before the next read
            self._count_failure(now_ms, number, "inverter")

    def _drop_late(self, reply, request):
        """Return `reply` without a reply to an older request than `request`."""
        for index, owed in enumerate(self._owed):
            end = _expect_bytes(owed, reply)
            frame = reply[:end]
            if len(reply) < end or modbus.fault_of(owed, frame) == modbus.WRONG:
                continue
            if request is None or modbus.fault_of(request, frame) == modbus.WRONG:
                self._late = True
                self._owed = self._owed[index + 1 :]
                return reply[end:]
        return reply

    def _take_reply(self, now_ms):
        """Take a good reply: note what the inverter has confirmed, or read."""
        request = self._request
        about = self._about
        self._request = None
        self._noted = False
        if about >= _OUTPUT or not self._unread:  # a write's echo may be that of the one before
            self._tries = 0
            self._unread = self._late = False
        way, hz = self._of
        if about == _STOP:
            self._told_way = 0
            if self._turned:
                self.output = max(self.output, _STANDING + 1)  # it takes its time
        elif about == _FREQUENCY:
            self._told_hz = hz
        elif about == _START:
            self._told_way = self._turned = way
        else:
            self._due_ms = (now_ms + PERIOD_MS) & COUNT_MASK
            value = modbus.value_of(self._reply)
            if about == _OUTPUT:
                self.output = value * 100 // self._make["output"][3]
                if self.output <= _STANDING and not self._told_way:
                    self._turned = 0
                self._judge_speed()
            elif value & self._make["fault"][3] and self._way:
                self._raise_alarm(ALARM_INVERTER_FAULT, "inverter: fault %d" % (value & self._make["fault"][3]))

    def _judge_speed(self):
        """Raise an alarm if the speed just read falls behind."""
        if not self._way or self._told_way != self._way or self._told_hz != self._hz:
            return
        if self.falls_behind(self.output, self._hz):
            self._raise_alarm(errors.ALARM_SPINDLE_SPEED, "inverter at %d.%02d Hz" % divmod(self.output, 100))

    def _count_failure(self, now_ms, number, who):
        """Count a request without a good reply. After _ATTEMPTS raise an alarm while the spindle turns; else log it once."""
        self._request = None
        self._due_ms = (now_ms + _QUIET_MS) & COUNT_MASK
        self._tries += 1
        if self._tries < _ATTEMPTS:
            return
        self._tries = 0
        self._unread = False
        if self._late:
            number = ALARM_INVERTER_LATE
        turns = self._way or self._told_way > 0
        self._told_way = self._told_hz = _UNKNOWN
        self._due_ms = (now_ms + _AGAIN_MS) & COUNT_MASK
        if turns and not self._machine.alarm:
            self._due_ms = (now_ms + _QUIET_MS) & COUNT_MASK
            self._raise_alarm(number, who)
        elif not self._noted:
            self._noted = True
            self._machine.note(number, who)

    def _raise_alarm(self, number, who):
        """Raise an alarm, unless there is one, and have the stop go out with the next cycle."""
        if self._machine.alarm:
            return
        self._machine.raise_alarm(number, who)
        self._update_order(self._machine.port.machine_ms())  # stop: it goes out with the next cycle


def _expect_bytes(request, reply):
    """Return the length of the reply to a request, shorter if `reply` begins as an exception."""
    return modbus.ERROR_LENGTH if len(reply) > 1 and reply[1] & 0x80 else modbus.reply_length(request)

"""Patch: the PC's end of the USB serial port.

rp2040py answers each OUT buffer that the chip arms at once, with 0 bytes if there are none; the firmware arms it again,
and most of the processor's time goes into that. Here the buffer stays armed until the PC has something to say, and a
packet takes 53 µs, the pace of a full-speed bus.

    port.write(b"print(1)\\r")
    port.heard = callback          # callback(bytes) with what the chip says
    port.up, port.connections      # whether it is enumerated now, and how often it has been
"""

PACKET_US = 53


class UsbPort:
    def __init__(self, cdc, quiet=True):
        self.heard = lambda data: None
        self.up = False
        self.connections = 0
        self.on_reset = lambda: None
        self._to_send = bytearray()
        self._cdc = cdc
        self._usb = cdc.usb
        self._quiet = quiet
        self._armed = None  # bytes that the waiting OUT buffer has room for
        self._stock_read, self._stock_reset = self._usb.on_endpoint_read, self._usb.on_reset
        self._usb.on_endpoint_read = self._on_read
        self._usb.on_reset = self._on_reset
        cdc.on_serial_data = lambda data: self.heard(bytes(data))
        cdc.on_device_connected = self._on_connect

    def write(self, data):
        self._to_send += data
        self._serve_buffer()

    @property
    def unsent(self):
        """Bytes that the chip has not yet taken."""
        return len(self._to_send)

    def _serve_buffer(self):
        """Send the PC's next bytes into the armed OUT buffer, if there are both."""
        if self._armed is None or not self._to_send:
            return
        size, self._armed = self._armed, None
        data, self._to_send = self._to_send[:size], self._to_send[size:]
        self._usb.endpoint_read_done(self._cdc._out_endpoint, bytes(data), PACKET_US)

    def _on_read(self, endpoint, size):
        """Keep the OUT buffer that the chip arms until the PC has bytes for it; not `quiet`: answer it at once with 0 bytes, as rp2040py does."""
        if endpoint != self._cdc._out_endpoint:
            self._stock_read(endpoint, size)
        elif self._to_send or self._quiet:
            self._armed = size
            self._serve_buffer()
        else:
            self._usb.endpoint_read_done(endpoint, b"")

    def _on_reset(self):
        """Forget armed buffer and bytes to send at a bus reset, then reset the stock port and call `on_reset`."""
        self._armed = None
        self._to_send.clear()
        self.up = False
        self._stock_reset()
        self.on_reset()

    def _on_connect(self):
        self.up = True
        self.connections += 1

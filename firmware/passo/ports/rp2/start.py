"""The start on a Raspberry Pi Pico and its like."""

import gc

import rp2

from passo.ports import start


class Start(start.Start):
    _code = None
    _said = ""

    def loading(self):
        from passo.ports.rp2.flash_code import FlashCode

        self._code = code = FlashCode()
        code.begin()
        if code.why:
            self._said = code.text()
            self._code = code = None
            start.forget("passo.ports.rp2.flash_code")
            gc.collect()
        return bool(code)

    def loaded(self):
        code, self._code = self._code, None
        if code:
            code.finish()
            self._said = code.text()
        return self._said

    def button(self):
        return "BOOTSEL" if rp2.bootsel_button() else None

    def port(self, board):
        """Raises RuntimeError where the chip does not take the board file's clock."""
        from passo.ports.rp2 import clock

        clock.set_mhz(board["clock_mhz"])
        start.forget("passo.ports.rp2.clock")
        from passo.ports.rp2.port import Port

        return Port(board)

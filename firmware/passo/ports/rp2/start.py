"""The start on a Raspberry Pi Pico and its like."""

import rp2

from passo.ports import start


class Start(start.Start):
    def button(self):
        return "BOOTSEL" if rp2.bootsel_button() else None

    def port(self, board):
        from passo.ports.rp2.port import Port

        return Port(board)

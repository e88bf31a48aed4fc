"""The start on an ESP32. It has no button that a program may read at any time: name an input "repl"."""

from passo.ports import start


class Start(start.Start):
    def port(self, board):
        from passo.ports.esp32.port import Port

        return Port(board)

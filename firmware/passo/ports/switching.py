"""Outputs that change with a step: whether a chip's player can do that.

    port.make("switching", switches)    # True: from here on the player shows what is asked of Switches; False: the main loop is to
"""

from sys import platform


def make(port, switches):
    player = port._player
    if platform != "rp2" or port.interlock is not None or port.registers is not None or hasattr(player, "close"):  # which the timer player has
        return False
    from passo.ports.rp2.switching import PinSwitches  # here: other chips have no such folder

    PinSwitches(player, switches)
    return True

"""The fields of the player's state, by name: each is the index of a field in its array. As in passo/records.py.

    state[PIO_PLAYED]           # PioPlayer
"""

from micropython import const

# How far ahead of the player words are made. An arc's segment of 6 ms counts whole until it has been played.
LEAD_TICKS = const(21 * 12_500 // 2)  # 10.5 ms

# The flash, and its file system's requests.
FLASH_BLOCK = const(4096)
FLASH_PAGE = const(256)
IOCTL_COUNT = const(4)
IOCTL_ERASE = const(6)

# The state of the RP2040's waveform player, an array('I'). First what does not change: addresses of registers and tables.
PIO_BLOCK = const(0)
PIO_MACHINE = const(1)
PIO_A = const(2)  # DMA channels
PIO_B = const(3)
PIO_C = const(4)
PIO_D = const(5)  # of a player that has a fourth; else A's again
PIO_COUNTS = const(6)  # tables of runs
PIO_ADDRESSES = const(7)
PIO_WORDS = const(8)  # the ring's
PIO_ABORT = const(9)  # DMA's CHAN_ABORT
PIO_MASK = const(10)  # the ring's size − 1
PIO_NUMBER = const(11)  # of the state machine in its block
PIO_FIRST = const(12)  # address of the program
PIO_PULSE = const(13)  # pulse ticks − 2, for the program's ISR; −1: no pulses
PIO_PINS = const(14)  # pin control: words' pins and pulse pins
PIO_TOOL = const(15)  # pin control: the tool's pin as the one to set
PIO_BITS = const(16)  # of a word's levels
PIO_CHANNELS = const(17)  # mask of the DMA channels, for PIO_ABORT
PIO_BUSY = const(18)  # bit of a channel's control register
PIO_PLAYING = const(19)  # 0 still, 1 playing, 2 the last word ends
PIO_ARMED = const(20)  # words of the ring that stand in the tables, modulo 2²⁹
PIO_SLOT = const(21)  # the tables' end mark
PIO_PLAYED = const(22)  # words played, while not playing, modulo 2²⁹
PIO_HELD = const(23)  # 1: start() does nothing
PIO_STUCK = const(24)  # 1: a register that was waited for never came to its value
PIO_CYCLES = const(25)  # of the processor, that a pulse lasts
PIO_LAST = const(26)  # entries of each table of runs − 1
PIO_FIELDS = const(27)

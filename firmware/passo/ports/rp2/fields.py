"""The fields of the players' state, by name: each is the index of a field in its array. As in passo/records.py.

    state[PIO_PLAYED]           # PioPlayer, LaserPlayer
    state[TIMER_PLAYED]         # TimerPlayer
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

# The state of the RP2040's timer player, an array('I'). First what does not change.
TIMER_BLOCK = const(0)  # addresses: PIO block, state machine
TIMER_MACHINE = const(1)
TIMER_NUMBER = const(2)  # of the state machine in its block
TIMER_FIRST = const(3)  # address of the program
TIMER_WORDS = const(4)  # address of the ring's words
TIMER_MASK = const(5)  # the ring's size − 1
TIMER_BITS = const(6)  # of a word's levels
TIMER_TABLES = const(7)  # address: from levels to pins: 128 entries for the low seven bits, 128 for those above
TIMER_ALL = const(8)  # mask of the pins of all levels
TIMER_STEPS = const(9)  # of the pulses
TIMER_TOOL = const(10)  # of the tool
TIMER_INVERT = const(11)  # of those whose level is the opposite of the word's
TIMER_CYCLES = const(12)  # of the processor, that a pulse lasts
TIMER_PLAYING = const(13)  # as PIO_PLAYING
TIMER_GIVEN = const(14)  # words given to the state machine, modulo 2²⁹
TIMER_PLAYED = const(15)  # words whose levels have appeared, modulo 2²⁹
TIMER_HELD = const(16)  # 1: start() does nothing
TIMER_TOGGLE = const(17)  # address of the register that turns pins over
TIMER_HEAD = const(18)  # words of the ring that are published, modulo 2²⁹
TIMER_FIELDS = const(19)

"""Registers of PIO blocks, state machines and DMA channels, as words from the address of each; the same on the RP2040 and the
RP2350. Datasheets: 3.7 (PIO) and 2.5.7 (DMA) of the RP2040's, 11.7 and 12.6.10 of the RP2350's.

    block = ptr32(programs.PIO_0)
    block[BLOCK_TXF + machine] = word
    ptr32(programs.PIO_0 + ALIAS_CLEAR)[BLOCK_CTRL] = 1 << machine
"""

from micropython import const

# Bytes to the aliases of a register that change only the bits written.
ALIAS_XOR = const(0x1000)
ALIAS_SET = const(0x2000)
ALIAS_CLEAR = const(0x3000)

BLOCK_CTRL = const(0)  # low four bits: state machines that run; then restart; then clock restart
BLOCK_FLEVEL = const(3)  # words in the FIFOs: four bits of TX and four of RX a state machine
BLOCK_TXF = const(4)  # the TX FIFOs of state machines 0 … 3
BLOCK_IRQ = const(12)

MACHINE_EXECCTRL = const(1)  # bits 7 to 11: wrap bottom, which is where its program begins
MACHINE_SHIFTCTRL = const(2)  # bit 31: the RX FIFO joins the TX FIFO
MACHINE_ADDR = const(3)  # of the instruction under way
MACHINE_INSTR = const(4)  # written: carried out at once
MACHINE_PINCTRL = const(5)

CHANNEL_READ = const(0)  # address that it reads next
CHANNEL_CTRL_TRIG = const(3)
CHANNEL_CTRL = const(4)  # AL1_CTRL: without setting it going
CHANNEL_READ_TRIG = const(15)  # AL3_READ_ADDR_TRIG: written, it is set going

SYSTICK_NOW = const(2)  # of SysTick: cycles that it still counts

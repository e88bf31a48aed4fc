"""The inner loops of lines as Thumb code: motion.line_viper.walk and steps.pace_viper.pace, bit for bit.

Cycles a step at 125 MHz, code in RAM: walk 7, and 9 to 14 for each axis but the dominant one; pace 14.
"""
# ruff: noqa: F821

import micropython


@micropython.asm_thumb
def walk(r0, r1, r2, r3):
    # r0 out, then out[at:]   r1 at, then steps of an axis   r2 count   r3 state
    mov(r4, r8)  # the caller's
    mov(r5, r9)
    mov(r6, r10)
    mov(r7, r11)
    push({r4, r5, r6, r7})
    lsl(r1, r1, 2)
    add(r0, r0, r1)
    ldr(r4, [r3, 4])  # dominant
    mov(r5, 1)
    lsl(r5, r4)
    mov(r6, r2)
    label(FIRST)
    str(r5, [r0, 0])
    add(r0, 4)
    sub(r6, 1)
    bne(FIRST)
    mov(r8, r3)
    ldr(r7, [r3, 0])  # axes, then the axis under way: last to first
    label(AXIS)
    sub(r7, 1)
    blt(DONE)
    mov(r3, r8)
    mov(r1, r2)
    ldr(r4, [r3, 4])
    cmp(r4, r7)
    beq(MADE)
    lsl(r6, r7, 2)
    add(r6, r6, r3)
    ldr(r5, [r6, 20])  # rise
    mov(r1, 0)
    cmp(r5, 0)
    beq(MADE)
    mov(r9, r5)
    ldr(r4, [r3, 0])
    lsl(r4, r4, 2)
    add(r6, r6, r4)
    mov(r10, r6)
    ldr(r6, [r6, 20])  # decision
    ldr(r4, [r3, 8])  # fall
    mov(r3, 1)
    lsl(r3, r7)
    mov(r11, r7)
    lsl(r7, r2, 2)
    sub(r0, r0, r7)
    mov(r12, r2)
    mov(r7, r9)
    label(STEP)
    cmp(r6, r4)
    ble(NONE)
    ldr(r5, [r0, 0])
    orr(r5, r3)
    str(r5, [r0, 0])
    sub(r6, r6, r4)
    add(r1, 1)
    label(NONE)
    add(r6, r6, r7)
    add(r0, 4)
    sub(r2, 1)
    bne(STEP)
    mov(r2, r12)
    mov(r7, r11)
    mov(r5, r10)
    str(r6, [r5, 20])
    label(MADE)
    mov(r3, r8)
    ldr(r4, [r3, 12])  # negative
    lsr(r4, r7)
    lsl(r4, r4, 31)
    bpl(FORTH)
    neg(r1, r1)
    label(FORTH)
    ldr(r4, [r3, 0])
    lsl(r4, r4, 1)
    add(r4, r4, r7)
    lsl(r4, r4, 2)
    add(r4, r4, r3)
    ldr(r5, [r4, 20])  # made
    add(r5, r5, r1)
    str(r5, [r4, 20])
    b(AXIS)
    label(DONE)
    pop({r4, r5, r6, r7})
    mov(r8, r4)
    mov(r9, r5)
    mov(r10, r6)
    mov(r11, r7)


@micropython.asm_thumb
def pace(r0, r1, r2, r3):
    # r0 words, then words[at:]   r1 at, then carry   r2 count   r3 terms
    lsl(r1, r1, 2)
    add(r0, r0, r1)
    ldr(r4, [r3, 0])  # short
    ldr(r5, [r3, 8])  # rest
    ldr(r6, [r3, 12])  # over
    ldr(r1, [r3, 16])  # carry
    label(WORD)
    ldr(r7, [r0, 0])
    orr(r7, r4)
    add(r1, r1, r5)
    cmp(r1, r6)
    blt(SHORT)
    sub(r1, r1, r6)
    mov(r12, r5)
    ldr(r5, [r3, 4])  # tick
    add(r7, r7, r5)
    mov(r5, r12)
    label(SHORT)
    str(r7, [r0, 0])
    add(r0, 4)
    sub(r2, 1)
    bne(WORD)
    str(r1, [r3, 16])

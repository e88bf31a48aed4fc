"""The requests of inverters of several makes, from their public documentation.

    forward, reverse, stop      (function, register, value) that start and stop the motor
    frequency                   (function, register, counts a hertz) of the speed asked for
    output                      (function, register, registers to read, counts a hertz) of the speed as it is
    fault                       (function, register, registers to read, mask): not 0 if it has a fault; None: it does not tell

delta       Delta VFD-B, VFD-E, VFD-EL, VFD-M: manuals, "communication address" (2000H, 2001H, 2100H, 2103H)
yl620       Yalang YL620: 2000H, 2001H in tenths of a hertz, 200BH; no register of faults is documented
h100        Huanyang H100, GT: coils 49H, 4AH, 4BH, register 0201H in tenths, input 0; no register of faults is documented
teco        TECO A510, E510, L510 (T-Verter): 2501H, bit 0 run and bit 1 reverse, 2502H and 2524H in hundredths, 2521H
nowforever  Nowforever D100, E100: 0900H, 0901H in hundredths, 0502H, 0300H

Left out: the older Huanyang inverters (HY series), whose frames look like Modbus and are not: their function codes 1 to 6 mean
other things.
"""

_NAMES = ("forward", "reverse", "stop", "frequency", "output", "fault")
MAKES = {
    row[0]: dict(zip(_NAMES, row[1:]))
    for row in (
        ("delta", (6, 0x2000, 0x12), (6, 0x2000, 0x22), (6, 0x2000, 0x01), (6, 0x2001, 100), (3, 0x2103, 1, 100), (3, 0x2100, 1, 0xFF)),
        ("yl620", (6, 0x2000, 0x12), (6, 0x2000, 0x22), (6, 0x2000, 0x01), (6, 0x2001, 10), (3, 0x200B, 1, 10), None),
        ("h100", (5, 0x0049, 0xFF00), (5, 0x004A, 0xFF00), (5, 0x004B, 0xFF00), (6, 0x0201, 10), (4, 0x0000, 2, 10), None),
        ("teco", (6, 0x2501, 1), (6, 0x2501, 3), (6, 0x2501, 0), (6, 0x2502, 100), (3, 0x2524, 1, 100), (3, 0x2521, 1, 0xFFFF)),
        ("nowforever", (16, 0x0900, 1), (16, 0x0900, 3), (16, 0x0900, 0), (16, 0x0901, 100), (3, 0x0502, 1, 100), (3, 0x0300, 1, 0xFFFF)),
    )
}

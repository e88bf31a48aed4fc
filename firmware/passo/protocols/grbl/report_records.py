"""The fields of the array that text_viper.py makes a status report of: room for nine numbers, the unit of positions, then three
integers an axis."""

from micropython import const

REPORT_NUMBER = const(0)  # nine numbers: of up to four axes; and these
REPORT_BLOCKS = const(12)
REPORT_ROOM = const(15)
REPORT_LINE = const(18)
REPORT_SPEED = const(21)
REPORT_RPM = const(24)
REPORT_UNIT = const(27)  # tenths of a millimetre
REPORT_DECIMAL = const(28)  # nanometres of the last decimal
REPORT_FIRST = const(29)  # worth of the first decimal: 100 or 1000
REPORT_AXIS = const(30)
REPORT_LONGEST = const(336)  # bytes of a report without its end: fields beyond are left out, one by one
NUMBER_WHOLE = const(0)
NUMBER_DECIMALS = const(1)
NUMBER_FIRST = const(2)  # worth of the first decimal, 0: none; plus NUMBER_NEGATIVE
NUMBER_FIELDS = const(3)
NUMBER_NEGATIVE = const(0x10000)
REPORT_STEPS_PER_M = const(0)  # of an axis
REPORT_OFFSET_MM = const(1)  # 100 000 000 + its offset in whole millimetres, and nanometres above them
REPORT_OFFSET_NM = const(2)
REPORT_FIELDS = const(3)

"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

NO_JOB = const(150)
JOB_DAMAGED = const(151)
JOB_SPACE = const(152)
JOB_RUNS = const(153)
STORED_NAME = const(154)
JOB_LANGUAGE = const(155)
JOB_UPLOAD = const(156)
JOB_STOPPED = const(157)
NO_CARD = const(158)
JOB_MEMORY = const(159)
ALARM_JOB_CHANGED = const(252)

NOTICE_JOB_ENDED = const(15)  # with (name, error or 0, line)

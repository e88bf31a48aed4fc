"""The commands of this option, by number, behind those of passo/commands.py."""

from micropython import const

JOB = const(50)  # a stored job: `value` is one of JOB_RUN …, `target` its name or what else it needs

JOB_RUN = const(0)  # without a name the button's
JOB_LIST = const(1)
JOB_DELETE = const(2)
JOB_OPEN = const(3)  # an upload begins: `target` is (name, language, bytes, their CRC-32, bytes that come)
JOB_DATA = const(4)  # some of its bytes
JOB_CLOSE = const(5)  # it is complete; FINISHED once it has been read back
JOB_STATE = const(6)  # the job that runs, or the end of the last one

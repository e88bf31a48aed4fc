"""The virtual machine: the firmware on the virtual port, the plant at its pins, serial lines, and traces of its motions."""

"""The pins that a program may use on each chip, and the ports of its serial lines. From the chips' datasheets; pins that
the flash memory takes are left out.

    check_pin("esp32", 34, "tool", output=True)     # raises BoardError: pin 34 of an esp32 can only be an input
"""

from passo.config.board_error import BoardError

PIN = (int, ..., 0, 48)  # the rule of a key whose value is a pin, in the notation of boardfile.py

# (first, last) of each run of pins, and the first of those at the end that can only be inputs
_PINS = {
    "rp2040": (((0, 29),), 30),
    "rp2350": (((0, 29),), 30),  # those from 30 on, of an RP2350B, have other registers
    "esp32": (((0, 5), (12, 19), (21, 23), (25, 27), (32, 39)), 34),
    "esp32s2": (((0, 21), (33, 46)), 46),
    "esp32s3": (((0, 21), (33, 48)), 49),
    "esp32c3": (((0, 10), (18, 21)), 22),
    "esp32c6": (((0, 23),), 24),
}
_UARTS = {"esp32": 3, "esp32s3": 3}  # 2 where not named


def check_pin(chip, pin, who, output):
    """Raise BoardError if `chip` has no such pin, or one that can only be an input and `output` is True."""
    runs, inputs_from = _PINS[chip]
    if not any([first <= pin <= last for first, last in runs]):
        free = ", ".join(["%d … %d" % run for run in runs])
        raise BoardError("%s: an %s has no pin %d for it; it has %s" % (who, chip, pin, free))
    if output and pin >= inputs_from:
        raise BoardError("%s: pin %d of an %s can only be an input" % (who, pin, chip))


def check_link(chip, link, ports=()):
    """Raise BoardError if `chip` has no such port, or not on these pins. `ports`: others than cables."""
    port = link["port"]
    where = "link %s: " % link["name"]
    if port == "usb" or port in ports:
        return
    count = _UARTS.get(chip, 2)
    if port not in ["uart%d" % number for number in range(count)]:
        raise BoardError("%sthere is no port %r on an %s; 'usb' or 'uart0' … 'uart%d'" % (where, port, chip, count - 1))
    if chip.startswith("esp32"):
        if port == "uart0":
            raise BoardError("%suart0 is the console of an %s: 'usb' speaks on it; or take another" % (where, chip))
        return
    number = int(port[4:])
    for key, rest in (("tx", 0), ("rx", 1)):  # RP2040 datasheet 1.4.3
        pins = [str(pin) for pin in range(_PINS[chip][1]) if pin & 3 == rest and (pin + 4 & 8) >> 3 == number]
        if str(link[key]) not in pins:
            right = ", ".join(pins[:-1]) + " or " + pins[-1]
            raise BoardError("%s%s of %s is on pin %s, not %d" % (where, key, port, right, link[key]))

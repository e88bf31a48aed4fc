"""The parts that a board file names, and which pin goes to which of their terminals.

    for part in parts_of(check(boards.load("router_3axis"))):
        print(part.title, [(terminal.label, terminal.pin) for terminal in part.terminals])

A pin is a number of the chip, or a bit of a shift register: ("in", 100) of a 74HC165, ("out", 100) of a 74HC595. The output `enable`
goes to a terminal of each driver if neither lies behind a register; every other pin has one terminal.
"""

from dataclasses import dataclass, field
from importlib import import_module

from host_tools.language import _

REGISTER_BIT = 100
# Inputs by the beginning of their names; the others are plain signals.
_BUTTONS = ("door", "repl", "hold", "resume", "reset", "job", "admit", "jog_", "start")


@dataclass
class Terminal:
    """A terminal of a part, and the pin that it goes to."""

    label: str
    pin: object


@dataclass
class Part:
    """`name` is unique, `kind` chooses symbol and colour, `supply` is a set of "M+", "3V3", "5V", "GND"; "M+" is behind the emergency
    stop; `opens`: a switch that opens when hit."""

    name: str
    kind: str
    title: str
    terminals: list
    notes: list = field(default_factory=list)
    supply: tuple = ("GND",)
    opens: bool = False


_ONE_BELT = {"x": "A (X + Y)", "y": "B (X − Y)"}  # CoreXY: axes that each motor moves


def parts_of(board):
    """Return all parts of a checked board file, motors first."""
    found = [*_motor_parts(board), *_tool_parts(board), *_input_parts(board), *_output_parts(board), *_encoder_parts(board), *_serial_parts(board), *_register_parts(board)]
    return found


def pin_of(number, way):
    """Return the pin of a number of the board file; `way`: "in" or "out"."""
    return (way, number) if number >= REGISTER_BIT else number


def motors_of(board):
    """Return (name, pins) of all motors, a gantry's second one too."""
    found = [(axis["name"], axis["pins"]) for axis in board["axes"]]
    gantry = board.get("gantry")
    return found + ([(gantry["axis"] + "2", gantry["pins"])] if gantry else [])


def _motor_parts(board):
    """Yield a driver and motor, or a motor with coils, for each motor."""
    drive = board["drive"]
    enable = None if drive["kind"] != "step_dir" else common_enable(board)
    for name, pins in motors_of(board):
        title = _ONE_BELT.get(name, name.upper()) if board.get("kinematics") == "corexy" else name.upper()
        if drive["kind"] == "step_dir":
            mark = "" if drive["step_active"] else "−"
            terminals = [Terminal(label + mark, pin_of(pin, "out")) for label, pin in zip(("STEP", "DIR"), pins)]
            terminals += [Terminal("EN", enable)] if enable is not None else []
            notes = [_("pulse {} µs, DIR {} µs ahead", drive["pulse_us"], drive["setup_us"])]
            if not drive["step_active"]:
                notes.append(_("a low pin is active"))
            yield Part(f"motor_{name}", "driver", _("{} driver and motor", title), terminals, notes, ("M+", "GND"))
        else:
            terminals = [Terminal(label.upper(), pin) for label, pin in zip(motor_pins(drive["kind"]), pins)]
            notes = {
                "unipolar": [_("unipolar, through 4 channels"), _("of a ULN2803A, COM to M+")],
                "pbl3770a": [_("bipolar, two PBL3770A,"), _("one a winding")],
            }.get(drive["kind"], [])
            yield Part(f"motor_{name}", "coils", _("{} motor", title), terminals, notes, ("M+", "GND"))


def motor_pins(kind):
    """Return the names of a motor's pins, in the order of the board file."""
    return ("step", "dir") if kind == "step_dir" else import_module(f"passo.options.drive_{kind}.drive").PINS


def common_enable(board):
    """Return the pin that goes to EN of all drivers, if they and it are on the chip's own pins; None otherwise."""
    for item in board["outputs"]:
        if item["name"] == "enable" and max(item["pin"], *(pin for _, pins in motors_of(board) for pin in pins)) < REGISTER_BIT:
            return item["pin"]
    return None


def _tool_parts(board):
    """Yield the tool, a pen's servo, and the output that follows the tool's bit."""
    pin, spindle = board["tool"]["pin"], board["spindle"]
    follower = board["registers"]["tool"] if board.get("registers") else -1
    kind, title, notes = _describe_tool(board)
    power = [Terminal("PWM", spindle["pin"])] if spindle["pwm"] else []
    level = _("active high") if board["tool"]["active"] else _("active low")
    if board.get("servo"):
        notes = [_("pulses of {} to {} µs", board["servo"]["up_us"], board["servo"]["down_us"])]
        yield Part("servo", "coils", _("pen's servo"), [Terminal("PWM", board["servo"]["pin"])], notes, ("5V", "GND"))
    if follower >= 0:
        yield Part("tool", "none", _("tool's bit"), [Terminal("", pin)], [_("no wire: the output tool follows it")], ())
        yield Part("tool_out", kind, title, [Terminal("on", ("out", follower))], [_("tool, {}", level)], ("M+", "GND"))
    elif power and pin >= REGISTER_BIT:
        yield Part("tool", "lamp", _("tool: on while it works"), [Terminal("on", ("out", pin))], [level])
        yield Part("power", kind, title, power, notes, ("M+", "GND"))
    else:
        terminals = [Terminal("on", pin_of(pin, "out")), *power]
        yield Part("tool", kind, title, terminals, [*notes, _("tool, {}", level)], ("M+", "GND"))


def _describe_tool(board):
    """Return (kind, title, notes) of the machine's tool."""
    languages = {link["protocol"] for link in board["links"]}
    if board["spindle"]["laser"]:
        return "laser", _("Laser"), [_("PWM {} Hz, 10 kΩ to GND each", board["spindle"]["pwm_hz"])]
    if board["spindle"]["pwm"]:
        return "spindle", _("Spindle with PWM"), [f"PWM {board['spindle']['pwm_hz']} Hz → 0 … 10 V"]
    if board.get("servo"):
        return "lamp", _("tool: on while it works"), []
    if "plotter" in languages:
        return "coil", _("Pen solenoid"), [_("transistor, diode across the coil")]
    if "torch" in languages:
        return "contact", _("Torch contact"), []
    if "keys" in languages:
        return "contact", _("Tool output"), []
    return "contact", _("Spindle relay or inverter"), []


def _input_parts(board):
    """Yield a part for each input."""
    for item in board["inputs"]:
        kind, title = _describe_input(board, item)
        pin = pin_of(item["pin"], "in")
        supply = ("5V", "GND") if kind == "barrier" else ("GND",)
        yield Part(f"in_{item['name']}", kind, f"{item['name']}: {title}", [Terminal("", pin)], [_contact_text(item, kind)], supply, bool(item["active"]))


def _describe_input(board, item):
    """Return (kind, title) of an input by its name and use."""
    name = item["name"]
    homed = {sensor: axis for axis, sensor in (board["homing"] or {"sensors": {}})["sensors"].items()}
    ends = {sensor: end for end, sensor in (getattr(board.get("additions"), "limits", None) or {}).items()}
    if item["halt"]:
        return "stop", _("2nd contact of E-STOP")
    if name.startswith("barrier"):
        return "barrier", _("optical, TCST1103")
    if name == "probe":
        return "probe", _("tool and plate")
    if name in ends:
        return "switch", _("limit {}", ends[name].replace("-", "−").upper())
    if name in homed and homed[name] in getattr(board.get("additions"), "stalls", ""):
        return "signal", _("DIAG of the {} driver", homed[name].upper())
    if name in homed or name.startswith("limit_"):
        return "switch", _("limit {}", homed.get(name, name[-1]).upper())
    if name.startswith(_BUTTONS):
        return "switch", {"door": _("door switch"), "repl": _("held at the start")}.get(name, _("button"))
    return "signal", _("active high") if item["active"] else _("active low")


def _contact_text(item, kind):
    """Return how an input is wired, in a few words."""
    pull = {"up": _("pull-up inside"), "down": _("pull-down inside"), "none": _("pull-up outside")}[item["pull"]]
    if item["pin"] >= REGISTER_BIT:
        pull = _("own pull resistor")
    if kind == "barrier":
        return f"LED: 5 V, 330 Ω; {pull}"
    if kind == "probe":
        return _("tool to GND, plate to the pin")
    if kind == "signal":
        return pull
    return _("opens when hit, {}", pull) if item["active"] else _("closes to GND, {}", pull)


_PURPOSES = {
    "reverse": lambda: _("spindle runs backwards"), "flood": lambda: _("coolant pump or air"), "mist": lambda: _("mist valve"),
    "vacuum": lambda: _("pump or valve"), "clamp": lambda: _("holds the work"), "enable": lambda: _("EN of all drivers"), "led": lambda: _("lamp"),
}  # fmt: skip


def _output_parts(board):
    """Yield a part for each output; not for an enable that goes to all drivers."""
    for item in board["outputs"]:
        name = item["name"]
        if name == "enable" and common_enable(board) is not None:
            continue
        if name[:7] == "enable_":
            yield Part(f"out_{name}", "lamp", f"{name}: {_('EN of this driver')}", [Terminal("", pin_of(item["pin"], "out"))], [])
            continue
        role = {"ours": _("on: motors are this board's"), "theirs": _("on: motors are the other's"), "none": None}[item["role"]]
        purpose = _PURPOSES[name]() if name in _PURPOSES else role or _("relay")
        level = _("active high") if item["active"] else _("active low")
        kind = "lamp" if name == "led" else "relay"
        yield Part(f"out_{name}", kind, f"{name}: {purpose}", [Terminal("", pin_of(item["pin"], "out"))], [_("transistor and diode, {}", level)])


def _encoder_parts(board):
    """Yield a part for each encoder."""
    for item in board.get("encoders", ()):
        terminals = [Terminal(wire, pin) for wire, pin in zip("AB", item["pins"])]
        notes = [_("{} pulses a turn, 3.3 V", item["pulses"])]
        yield Part(f"encoder_{item['motor']}", "encoder", _("{} encoder", item["motor"].upper()), terminals, notes, ("3V3", "GND"))


def _serial_parts(board):
    """Yield serial lines, the inverter, drivers on UART or SPI, and the memory card."""
    for link in board["links"]:
        if link["port"].startswith("uart"):
            terminals = [Terminal("RX", link["tx"]), Terminal("TX", link["rx"])]
            notes = [_("USB adapter of 3.3 V, or a"), _("controller: {}, {} baud", link["protocol"], link["baud"])]
            yield Part(f"link_{link['name']}", "serial", _("serial line {}", link["name"]), terminals, notes)
    inverter, card = board.get("inverter"), board.get("card")
    if inverter:
        terminals = [Terminal("DI", inverter["tx"]), Terminal("RO", inverter["rx"])]
        notes = [_("RS-485 transceiver that"), _("switches itself; {} baud", inverter["baud"])]
        yield Part("inverter", "serial", _("spindle's inverter"), terminals, notes, ("3V3", "GND"))
    drivers = board.get("drivers")
    if drivers:
        terminals = [Terminal("PDN", drivers["tx"]), Terminal("PDN", drivers["rx"])]
        addresses = ", ".join(f"{motor['axis'].upper()} {motor['address']}" for motor in drivers["motors"])
        notes = [_("1 kΩ from TX to the wire; RX on it"), _("addresses (MS1, MS2): {}", addresses)]
        yield Part("drivers", "serial", _("drivers' UART"), terminals, notes, ("GND",))
    spi = board.get("spi_drivers")
    if spi:
        terminals = [Terminal("SCK", spi["sck"]), Terminal("SDI", spi["tx"]), Terminal("SDO", spi["rx"])]
        chains = {}
        for motor in spi["motors"]:
            chains.setdefault(motor["cs"], []).append(motor["axis"].upper())
        terminals += [Terminal("CS " + " ".join(axes), cs) for cs, axes in chains.items()]
        notes = [_("3.3 V at VCC_IO of each driver")]
        if any(len(axes) > 1 for axes in chains.values()):
            notes.append(_("of a chain SDO goes to the next SDI"))
        yield Part("drivers", "serial", _("drivers' SPI"), terminals, notes, ("3V3", "GND"))
    if card:
        terminals = [Terminal(label, card[key]) for label, key in (("CLK", "sck"), ("DI", "mosi"), ("DO", "miso"), ("CS", "cs"))]
        yield Part("card", "serial", _("memory card"), terminals, [_("10 kΩ from DO to 3V3")], ("3V3", "GND"))


def _register_parts(board):
    """Yield the bank of shift registers, and the diodes that join inputs behind them."""
    registers, shift = board.get("registers"), board.get("shift")
    if registers:
        keys = (("CLK", "clock"), ("LATCH", "latch"), ("QH", "in"), ("SER", "out"))
        chips = f"{registers['inputs']} × 74HC165, {registers['outputs']} × 74HC595"
        yield Part("registers", "registers", chips, [Terminal(label, registers[key]) for label, key in keys], [], ("3V3", "GND"))
        for item in registers["edges"]:
            names = item["inputs"].replace(" ", ", ")
            title = _("diodes of {}", names)
            yield Part(f"edge_{item['pin']}", "diodes", title, [Terminal("", item["pin"])], [_("1N4148 each, 10 kΩ to GND")])
    if shift:
        keys = (("CLK", "clock"), ("LATCH", "latch"), ("SER", "data"), ("OE", "enable"))
        terminals = [Terminal(label, shift[key]) for label, key in keys if shift[key] >= 0]
        yield Part("registers", "registers", f"{chips_of(board)['out']} × 74HC595", terminals, [], ("3V3", "GND"))


def chips_of(board):
    """Return {"in": 74HC165, "out": 74HC595}: how many of each there are."""
    if board.get("registers"):
        return {"in": board["registers"]["inputs"], "out": board["registers"]["outputs"]}
    if not board.get("shift"):
        return {"in": 0, "out": 0}
    bits = [pin for _, pins in motors_of(board) for pin in pins] + [board["tool"]["pin"]] + [item["pin"] for item in board["outputs"]]
    return {"in": 0, "out": (max(bits) - REGISTER_BIT) // 8 + 1}

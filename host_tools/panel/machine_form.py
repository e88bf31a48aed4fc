"""The fields of a board file on the page's card of machines, and their values in the file.

    form = Form(text, "mine.py")
    form.groups()                                       # [{"what": "speeds", "rows": [{"name": "", "fields": [{"key": …, "value": …}]}]}]
    form.path_values({"axes.z.used": False, "inputs.stop.pin": "16"})     # {"axes.z": None, "inputs.stop.pin": 16}, for board_edit.set_values()

The page knows no key of a board file: it shows the groups, and returns the fields that were changed. `what` is a word of its own
(card_board.js). Bounds are the firmware's: its check decides what is written. Values come as text, of a box as True or False.
"""

import re

from host_tools import boards
from host_tools.failure import Failure
from passo.config.board_error import BoardError
from passo.config.boardfile import CLOCKS_MHZ
from passo.config.chip_pins import PIN, check_pin

_SPEEDS = (("step_program", "interval_us", "interval"), ("step_program", "default_mm_min", "default_mm_min"), ("speed", "default", "default"))
_BITS = ("drives", "z_step", "z_dir", "y_step", "y_dir", "x_step", "x_dir", "tool")  # bits 7 to 0 of the parallel port
_TURNING = "abc"  # axes that count degrees
_ABSENT = "-"
_INPUTS = ("probe", "door", "hold", "resume", "reset", "limit_x", "limit_y", "limit_z", "repl")  # functions that the page proposes; any name may be given
_OUTPUTS = ("enable", "reverse", "flood", "mist", "vacuum", "clamp")
_NEW = re.compile(r"(inputs|outputs)\.([\w+-]{1,16})\.pin")


class Form:
    def __init__(self, text, found):
        """`text` of the board file `found`. Raises Failure."""
        own = boards.own_table(text, found)
        self._board = boards.merge_into_base(own, found)
        base = own.get(boards.LIKE)
        self._base = boards.load(base) if base else {}
        self._fields = {}  # key: its field
        self._absent = {f"{section}.{item['name']}" for section in ("axes", "inputs", "outputs") for item, used in self._list_items(section) if not used}
        self._groups = [group for group in (self._speeds_group(), self._axes_group(), self._pins_group("inputs", _INPUTS), self._pins_group("outputs", _OUTPUTS), self._port_group()) if group]

    def groups(self):
        return self._groups

    def pins(self):
        """The numbers of the chip's pins that a board file may name."""
        return [pin for pin in range(PIN[2], PIN[3] + 1) if self._has_pin(pin)]

    def _has_pin(self, pin):
        """Return True if the board's chip has the pin."""
        try:
            check_pin(self._board["chip"], pin, "", False)
        except BoardError:
            return False
        return True

    # --- what it shows

    def _add_field(self, key, what, kind, value):
        self._fields[key] = field = {"key": key, "what": what, "kind": kind, "value": value}
        return field

    def _speeds_group(self):
        """The group of speeds and of the pulses' form, a dict; None: the board file has none of them."""
        fields = []
        for section, key, what in _SPEEDS:
            if key in self._board.get(section, {}) and not (section == "speed" and (fields or self._first_link_speaks("grbl"))):
                unit = "_" + self._board["speed"]["unit"] if section == "speed" else ""
                fields.append(self._add_field(f"{section}.{key}", what + unit, "number", self._board[section][key]))
        if self._board["drive"]["kind"] == "step_dir":
            fields.append(self._add_field("drive.step_active", "step_inverted", "box", self._board["drive"].get("step_active", 1) == 0))
        if self._board["chip"] in CLOCKS_MHZ:  # others have one way to make pulses
            fields.append(self._add_field("player", "timer", "box", self._board.get("player") == "timer"))
        return {"what": "speeds", "rows": [{"name": "", "fields": fields}]} if fields else None

    def _first_link_speaks(self, protocol):
        return self._board["links"][0]["protocol"] == protocol

    def _axes_group(self):
        return {"what": "axes", "rows": [self._axis_row(item, used) for item, used in self._list_items("axes")]}

    def _list_items(self, section):
        """(thing, whether the machine has it) of a list, with those of the base that were taken away."""
        here = {item["name"]: item for item in self._board.get(section, [])}
        base = {item["name"]: item for item in self._base.get(section, [])}
        return [(here.get(name, item), name in here) for name, item in {**base, **here}.items()]

    def _axis_row(self, axis, used):
        """The row of an axis, a dict; `used`: the machine has it, else only its base."""
        name = axis["name"]
        start = f"axes.{name}"
        fields = [self._add_field(f"{start}.used", "used", "box", used)] if name in [item["name"] for item in self._base.get("axes", [])] else []
        fields.append(self._add_field(f"{start}.steps_per_m", "steps_degree" if name in _TURNING else "steps_mm", "thousandth", axis["steps_per_m"] / 1000))
        if "max_mm_min" in axis:
            fields.append(self._add_field(f"{start}.max_mm_min", "max_mm_min", "number", axis["max_mm_min"]))
        two = self._board["drive"]["kind"] == "step_dir" and len(axis["pins"]) == 2
        for at, pin in enumerate(axis["pins"]):
            fields.append(self._add_field(f"{start}.pins.{at}", ("step", "dir")[at] if two else f"pin_{at + 1}", "pin", pin))
        fields.append(self._add_field(f"{start}.reversed", "reversed", "box", bool(axis.get("reversed"))))
        return {"name": name.upper(), "fields": fields}

    def _pins_group(self, section, proposed):
        """The group of a section of pins, inputs or outputs; `proposed`: function names for a new pin."""
        rows = [self._pin_row(f"{section}.{item['name']}", item, used, True) for item, used in self._list_items(section)]
        if section == "outputs" and "tool" in self._board:
            rows.insert(0, self._pin_row("tool", {"name": "tool", **self._board["tool"]}, True, False))
        there = [row["name"] for row in rows]
        # A list that is empty cannot be added to by name.
        return {"what": section, "rows": rows, "new": section if self._board.get(section) else "", "names": [name for name in proposed if name not in there]}

    def _pin_row(self, start, item, used, may_lack):
        """The row of one input or output: its pin, and whether it is inverted; `may_lack`: it may be taken away."""
        fields = [
            self._add_field(f"{start}.pin", "pin", "pin", item["pin"] if used else _ABSENT),
            self._add_field(f"{start}.active", "inverted", "box", item.get("active", 1) == 0),
        ]
        fields[0]["lacks"] = may_lack
        return {"name": item["name"], "fields": fields}

    def _port_group(self):
        """The group of the parallel port: the bit of each function, and whether it is inverted; None: the machine has no such port."""
        program = self._board.get("step_program")
        if not program:
            return None
        bits, inverted = program.get("port_bits", "76543210"), program.get("port_invert", 0)
        rows = []
        for at, name in enumerate(_BITS):
            fields = [
                self._add_field(f"port.{at}.bit", "bit", "bit", bits[at]),
                self._add_field(f"port.{at}.inverted", "inverted", "box", bool(inverted >> 7 - at & 1)),
            ]
            fields[0]["lacks"] = True
            rows.append({"name": "", "what": name, "fields": fields})
        return {"what": "port", "rows": rows}

    # --- what is changed

    def path_values(self, changes):
        """{path: value} of a board file for changed fields {key: text, True or False}. Raises Failure."""
        items, found = {}, {}  # {path: None or {}} of removed and returning things; {path: value}
        port = [self._fields[f"port.{at}.{part}"]["value"] for part in ("bit", "inverted") for at in range(8)] if "port.0.bit" in self._fields else []
        for key, value in changes.items():
            field = self._field_of(key)
            if isinstance(value, bool) != (field["kind"] == "box"):
                raise Failure("{}: the page has no such field; load it anew", key)
            start, _, last = key.rpartition(".")
            if start.startswith("port."):
                port[int(start[5:]) + 8 * (last == "inverted")] = value
            elif value != field["value"] and (last == "used" or field.get("lacks") and _ABSENT in (value, field["value"])):
                items[start] = {} if value not in (False, _ABSENT) else None
            if last != "used" and not start.startswith("port."):
                found.update(self._value_of(found, key, field, value))
        if port and any(key.startswith("port.") for key in changes):
            found["step_program.port_bits"] = "".join(port[:8])
            found["step_program.port_invert"] = sum(bool(port[8 + at]) << 7 - at for at in range(8))
        absent = {start for start in self._absent if items.get(start) is None} | {start for start, item in items.items() if item is None}
        return items | {key: value for key, value in found.items() if not any(key.startswith(start + ".") for start in absent)}

    def _field_of(self, key):
        """The field of a key; for a new pin of inputs or outputs an empty field. Raises Failure for any other key."""
        if key in self._fields:
            return self._fields[key]
        if not _NEW.fullmatch(key):
            raise Failure("{}: the page has no such field; load it anew", key)
        return {"kind": "pin", "lacks": True, "value": _ABSENT}

    def _value_of(self, found, key, field, value):
        """{path: value} of one field; the pins of an axis are one list, of which `found` may have some already."""
        start, _, last = key.rpartition(".")
        if start.endswith(".pins"):
            axis = start.split(".")[1]
            pins = list(found.get(start) or next(item for item, _ in self._list_items("axes") if item["name"] == axis)["pins"])
            pins[int(last)] = _read_number(value)
            return {start: pins}
        if last == "player":
            return {key: "timer" if value else "pio"}
        if last in ("active", "step_active"):
            return {key: int(not value)}
        return {key: _read_number(value, 1000 if field["kind"] == "thousandth" else 1)}


def _read_number(value, factor=1):
    """The number in a text, an int if it is whole. Other texts are returned as they are: the firmware's check refuses them."""
    if isinstance(value, bool):
        return value
    try:
        number = float(value) * factor
        return round(number) if factor != 1 or number == round(number) else number
    except (ValueError, OverflowError):
        return value

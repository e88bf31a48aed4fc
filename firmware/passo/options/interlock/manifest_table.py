"""Compiles the interlock of a board file: its rows over the inputs become masks.

    masks = compile_rows(board)         # of a checked board; BoardError says which row is wrong, and why

A row is a sum of products: names joined by "&", with "!" before one that must not be active, the products joined by "|":

    "enm": "rc0 & !stop | !sel & !stop"

A name is an input (true while it is active), or a signal: another name of an input, what this board itself asks for
("x.step", "x.dir", "tool", an output), or one that comes from elsewhere. A row gates what its signals ask for. One named
"x+", "x-", "x", "tool" or as an output gates that. All others only say what else the machine's hardware does.

The masks are made with the board's request put in and nothing asked for elsewhere: for the direction X+ "x.step" and
"x.dir" are 1. Several rows for one thing must all allow it. Steps also need what the output "enable" needs.
"""

from passo.config.board_error import BoardError
from passo.options.interlock.steps_viper import INTERLOCK_OUTPUTS, INTERLOCK_TOOL


def parse_row(text, where="row"):
    """Return the products of a row, [{name: wanted}]. `where`: the row's path, for errors. Raises BoardError."""
    if not isinstance(text, str):
        raise BoardError("%s: a sum of products is wanted, not %r" % (where, text))
    products = []
    for part in text.split("|"):
        product = {}
        for literal in part.split("&"):
            name = literal.strip()
            wanted = name[:1] != "!"
            if not wanted:
                name = name[1:].strip()
            letters = name.replace("_", "")
            if not letters or any([letter in " !()~/*+" for letter in letters]):
                raise BoardError("%s: %r is no name; sums of products are written a & !b | c" % (where, literal.strip()))
            if product.get(name, wanted) != wanted:
                raise BoardError("%s: %s and not %s in one product: it is never true" % (where, name, name))
            product[name] = wanted
        products.append(product)
    return products


def gate_bits(board):
    """Return {name: bit} of all that may be gated: x+, x- …, tool, outputs."""
    bits = {}
    for number, axis in enumerate(board["axes"]):
        bits[axis["name"] + "+"] = 1 << 2 * number
        bits[axis["name"] + "-"] = 2 << 2 * number
    bits["tool"] = INTERLOCK_TOOL
    for number, output in enumerate(board["outputs"]):
        bits[output["name"]] = INTERLOCK_OUTPUTS << number
    return bits


class _Names:
    """The meanings of the names of rows."""

    def __init__(self, board):
        section = board["interlock"]
        self.inputs = [item["name"] for item in board["inputs"]]
        self.bits = gate_bits(board)
        self.axes = [axis["name"] for axis in board["axes"]]
        self.elsewhere = section["elsewhere"].split()
        self.signals = section["signals"]
        for name, meaning in self.signals.items():
            if self._request_of_meaning(meaning) is None and meaning not in self.inputs:
                raise BoardError("interlock.signals.%s: %r is no input, no output, and no axis's step or dir" % (name, meaning))

    def _request_of_meaning(self, meaning):
        """Return the request of a meaning: (kind, its name); None if it is an input's name."""
        axis, _, kind = meaning.partition(".")
        if axis in self.axes and kind in ("step", "dir"):
            return kind, axis
        return ("on", meaning) if meaning in self.bits and meaning[-1] not in "+-" else None

    def request_of(self, name):
        """Return the request that a name in a row means: (kind, its name); None if it means an input."""
        meaning = self.signals.get(name)
        return meaning and self._request_of_meaning(meaning)

    def input_number(self, name, where):
        """Return the number of the input that a name means. Raises BoardError."""
        name = self.signals.get(name, name)
        if name not in self.inputs:
            raise BoardError("%s: %s is neither an input nor one of interlock.signals or interlock.elsewhere" % (where, name))
        return self.inputs.index(name)


def _input_masks(products, names, wanted, where):
    """Return a row's products as [(care, value)] over the inputs; `wanted`: {(kind, name): bool}, the requests of the board."""
    found = []
    for product in products:
        care = value = 0
        possible = True
        for name in product:
            asked = names.request_of(name)
            if asked:
                possible = possible and wanted.get(asked, False) == product[name]
            elif name in names.elsewhere:
                possible = possible and not product[name]
            else:
                bit = 1 << names.input_number(name, where)
                care |= bit
                if product[name]:
                    value |= bit
        if possible:
            found.append((care, value))
    return _drop_covered(found)


def _both_allow(first, second):
    """Return the product of two sums of products."""
    found = []
    for care, value in first:
        found += [(care | other, value | wanted) for other, wanted in second if not (value ^ wanted) & care & other]
    return _drop_covered(found)


def _drop_covered(products):
    """Return the products without those that another one covers."""
    found = []
    for care, value in products:
        wider = [row for row in products if row != (care, value) and row[0] & care == row[0] and value & row[0] == row[1]]
        if not wider and (care, value) not in found:
            found.append((care, value))
    return found


def _gate_targets(name, products, names):
    """Return the bits that a row gates: [(its bit's name, {request: True})]."""
    asked = []
    for product in products:
        for each in product:
            request = names.request_of(each)
            if request and request not in asked:
                asked.append(request)
    steps = [axis for kind, axis in asked if kind == "step"]
    on = [output for kind, output in asked if kind == "on"]
    direct = [name] if name in names.bits else [name + "+", name + "-"] if name in names.axes else []
    if len(steps) + len(on) > 1 or direct and asked:
        raise BoardError("interlock.rows.%s: it asks for more than one thing" % name)
    if steps:
        axis = steps[0]
        forward = {("step", axis): True, ("dir", axis): True}
        return [(axis + "+", forward), (axis + "-", {("step", axis): True, ("dir", axis): False})]
    if on:
        return [(on[0], {("on", on[0]): True})]
    return [(target, {}) for target in direct]


def compile_rows(board):
    """Return {"table", "unasked", "rise", "fall", "limits"} of a board file's interlock. The tables: see steps_viper.py; `rise` and `fall`: masks of
    the inputs whose becoming active, or inactive, may forbid something; `limits`: mask of the inputs in interlock.limits. Raises BoardError."""
    section = board["interlock"]
    names = _Names(board)
    allowed = {}  # by name: when it may be
    unasked = {}  # by name: when it is on though the board does not ask
    for name, text in section["rows"].items():
        where = "interlock.rows." + name
        products = parse_row(text, where)
        _input_masks(products, names, {}, where)  # all names are known
        for target, wanted in _gate_targets(name, products, names):
            when = _input_masks(products, names, wanted, where)
            allowed[target] = _both_allow(allowed[target], when) if target in allowed else when
            if wanted and section["unasked_ms"] and target not in ("tool",) and target[-1] not in "+-":
                unasked[target] = _input_masks(products, names, {}, where)
    limits = 0
    for target, sensor in section["limits"].items():
        if target not in names.bits or target[-1] not in "+-":
            raise BoardError("interlock.limits: there is no direction %r; x+ is one" % target)
        bit = 1 << names.input_number(sensor, "interlock.limits." + target)
        limits |= bit
        allowed[target] = _both_allow(allowed.get(target, [(0, 0)]), [(bit, 0)])
    if "enable" in allowed:
        for target in names.bits:
            if target[-1] in "+-":
                allowed[target] = _both_allow(allowed.get(target, [(0, 0)]), allowed["enable"])
    for target, products in allowed.items():
        if not products:
            raise BoardError("interlock: no input lets %s be: it can never be on" % target)
    rise = fall = 0
    for products in allowed.values():
        for care, value in products:
            rise |= care & ~value
            fall |= value
    _check_inputs(board, rise | fall)
    return {
        "table": _make_table(allowed, names.bits),
        "unasked": _make_table({name: _both_allow(unasked[name], allowed[name]) for name in unasked}, names.bits),
        "rise": rise,
        "fall": fall,
        "limits": limits,
    }


def _check_inputs(board, used):
    """Raise BoardError if the rows gate nothing, or a filter is on an input that they do not name."""
    if not used:
        raise BoardError("interlock: its rows gate nothing")
    for number, item in enumerate(board["inputs"]):
        if item["filter_us"] and not used >> number & 1:
            raise BoardError("input %s: filter_us is for inputs that the interlock's rows name" % item["name"])
        if item["filter_us"] and item["halt"]:
            raise BoardError("input %s: it halts at once: filter_us and halt exclude each other" % item["name"])


def _make_table(sums, bits):
    """Return a table: how many products, mask of all bits, then care, value and bits of each."""
    products = {}
    every = 0
    for name, when in sums.items():
        every |= bits[name]
        for product in when:
            products[product] = products.get(product, 0) | bits[name]
    table = [len(products), every]
    for care, value in sorted(products):
        table += [care, value, products[(care, value)]]
    return table

"""Errors of a board file, values that no message could show, and the manifests' additions to it."""

import os

from micropython import const

from passo.commands import INPUTS

_DEPTH = const(12)  # of lists in dicts in lists …; the rules have fewer
OF_OUTPUT = "output_"  # how the option of outputs of a name is called
OF_INPUT = "input_"  # of inputs
# Keys whose values ask for options, such as player_timer, or spindle_pwm if True, and the value that asks for none.
VALUES = ("drive.kind", "step_dir"), ("player", "pio"), ("homing.latch", False), ("planning.s_curves", False), ("spindle.pwm", False)
_LIKE = const(50)  # percent of the pairs of letters in two names
_LONGEST = const(1000)  # characters of a text


class BoardError(Exception):
    """The board file is wrong: one line with the place, and the right value."""


class Additions:
    """The additions of options to a machine: their check() writes them into board["additions"], a key that a board file cannot have."""

    def __init__(self, before=None):
        """`before`: those of the same board, when it was checked before."""
        self.masks = before.masks if before else None  # of the option that forbids motion: made of rows that the first check drops, to save memory
        self.levels = before.levels if before else {}  # masks of a word's levels: "inverted" ones, and "muted" ones, which stay low
        self.limits = None  # {direction: name of the input at that end}, of the option that forbids motion
        self.features = {}  # (module, class) by the name of a feature, see machine_builder.rows()
        self.watchers = []  # names of those features that look at what others have done: they stand behind all
        self.file_links = []  # (feature, language) of a link that a feature brings, whose bytes come from a file: the feature has join(number, protocol)
        self.named_inputs = ()  # rows as commands.INPUTS has them, behind those
        self.settings = {}  # rules by number
        self.value = None  # Settings.value, once there are settings
        self.languages = []  # names of modules whose extend(protocol, board) adds to a protocol of the language that ends their name
        self.extensions = {}  # the same modules, loaded, by language: see load_languages()
        self.motion = self.queue = None  # modules with its Planner and its Queue
        self.ramp = None  # the module whose limit() has ramps keep to a jerk
        self.one_belt = False  # the first two axes have the same steps/mm
        self.ports = ()  # of links that are no cable
        self.lines = None  # the module that makes the lines of all links, where some are no cable: see machine_builder.lines_of()
        self.parts = {}  # modules for parts of the port beside its pins, see ports/parts.py
        self.more_motors = []  # those beside the axes' own
        self.drive_module = None  # the module that turns words of all motors into pins
        self.player_module = None  # it makes the player of the words, see ports/parts.py
        self.burn = None  # the module whose burn() marks rows of dots, of a tool that takes them
        self.motor_pins = 2  # of each motor: STEP and DIR, or coils
        self.stalls = ""  # names of the axes that home by stall
        self.drives = None  # the board file's section with `motors`, of chips that are set up over a wire
        self.box = None  # (module, arguments) of a save_left_box() that is called at the start, before memory that a reset has left is used anew

    def add_languages(self, start, languages):
        """Add a module for each of these languages; `start`: of their names."""
        self.languages += [start + language for language in languages]

    def load_languages(self):
        """Import the modules of `languages` into `extensions`. Raises ImportError."""
        for name in self.languages:
            language = name.rpartition("_")[2]
            self.extensions[language] = self.extensions.get(language, ()) + (__import__(name, None, None, ("extend",)),)


def inputs_of(board):
    """Return rows of the inputs whose names mean something: commands.INPUTS, and those of the board's options."""
    own = getattr(board.get("additions"), "named_inputs", ())
    return INPUTS + own if own else INPUTS


def want_input(board, who, name):
    """Raise BoardError if the board has no input `name`. `who`: the board-file key that refers to it."""
    if name not in [item["name"] for item in board["inputs"]]:
        raise BoardError("%s: there is no input %r" % (who, name))


def check_shape(value, depth=_DEPTH):
    """Raise BoardError if a value is nested too deep, or within itself, or has a text that is too long."""
    if isinstance(value, str) and len(value) > _LONGEST:
        raise BoardError("a text of %d characters, which begins with %r, is too long" % (len(value), value[:40]))
    if not isinstance(value, (dict, list, tuple)):
        return
    if not depth:
        raise BoardError("a list or dict is nested too deep")
    for each in value.values() if isinstance(value, dict) else value:
        check_shape(each, depth - 1)


def folders(package):
    """Return the names of the folders of a package, as far as they can be listed: not in a UF2."""
    path = __import__(package, None, None, ("__path__",)).__path__
    try:
        return [name for name in os.listdir(path if isinstance(path, str) else path[0]) if "." not in name and name[0] != "_"]
    except OSError:
        return []


def nearest(key, known):
    """Return ", nearest is 'axes'" if the key is written much like one of the known ones, else ""."""
    wanted = _letter_pairs(key)
    best, name = 0, ""
    for each in known:
        pairs = _letter_pairs(each)
        like = 200 * len([pair for pair in pairs if pair in wanted]) // (len(pairs) + len(wanted))
        if like > best:
            best, name = like, each
    return ", nearest is %r" % name if best >= _LIKE else ""


def _letter_pairs(key):
    """Return the pairs of neighbouring letters in a key, blanks at its ends included."""
    key = " " + str(key) + " "
    return [key[at : at + 2] for at in range(len(key) - 1)]


def names_of(items, part):
    """Return the name of each output (`part` 2) or input (0), once each: the last or the first word of its name, of `p0` the letter. Items may be anything."""
    found = []
    for item in items if isinstance(items, (list, tuple)) else ():
        name = item.get("name") if isinstance(item, dict) else None
        if isinstance(name, str):
            word = (name.rpartition("_") if part else name.partition("_"))[part]
            word = word[:1] if word[1:].isdigit() else word
            if word.isalpha() and word not in found:
                found.append(word)
    return found


def options_wanted(board):
    """Return {option: (the key that asks for it by its value, the value that asks for none)} of a raw board file; it cannot do without these. Values
    may be of any type."""
    found = {}
    for path, plain in VALUES:
        section, _, key = path.rpartition(".")
        part = board.get(section) if section else board
        value = part.get(key) if isinstance(part, dict) else None
        if value is True and plain is False:
            found[section + "_" + key] = path, plain
        elif isinstance(value, str) and plain and value != plain:
            found[(section or key) + "_" + value] = path, plain
    return found


def options_by_value(board):
    """Return the names of the options that a raw board file asks for by a value, not by a key: those of options_wanted(), and those of the names
    of its outputs and inputs, without which it does."""
    names = [OF_OUTPUT + name for name in names_of(board.get("outputs"), 2)] + [OF_INPUT + name for name in names_of(board.get("inputs"), 0)]
    return names + list(options_wanted(board))


def own_rules(board, rules):
    """Return the manifests of the options that the board file asks for, by their keys and by values. Adds their RULES to `rules`.
    Raises BoardError for one that it cannot do without and that is not here.

    A manifest may have rewrite(raw board), which returns (it, Additions.levels or None); extend(rules); prepare(board), called before pins
    are checked; claims(board), which returns [(pin, who)]; has_bit(pin), True if an output is on no pin of the chip; and check(board)."""
    own = []
    wanted = options_wanted(board)
    for key in sorted([key for key in board if isinstance(key, str)]) + options_by_value(board):
        if key not in rules and "." not in key:
            try:
                module = __import__("passo.options.%s.manifest" % key, None, None, ("RULES",))
            except ImportError:
                if key in wanted and key not in board:
                    path, plain = wanted[key]
                    if not plain:
                        raise BoardError("%s: it asks for the option %s, which is not on this board: flash it anew" % (path, key))
                    start = path.partition(".")[0] + "_"
                    known = [plain] + [name[len(start) :] for name in folders("passo.options") if name.startswith(start)]
                    raise BoardError("%s: %r is none of %s" % (path, key[len(start) :], ", ".join(known)))
                continue
            rules.update(module.RULES)
            own.append(module)
    return own


def rewritten(board, own):
    """Return (the raw board file as the manifests `own` rewrite it, masks of a word's levels or None)."""
    levels = None
    for module in own:
        if hasattr(module, "rewrite"):
            board, levels = module.rewrite(board)
    return board, levels


def by_options(board):
    """Return a raw board file with the pins that its options give it, such as those of a parallel port."""
    try:
        sections = {key: value for key, value in board.items() if isinstance(value, dict) and "port_pins" in value}
        if sections:
            return rewritten(board, own_rules(sections, {}))[0]
    except Exception:  # check() comes next, and says what is wrong
        pass
    return board

"""The machine builder: it makes the parts that a board file and its links' languages ask for, and no others: drive, speeds, features."""

from passo.config.board_error import BoardError, folders, inputs_of
from passo.config.setting_numbers import HOMING, SPEED, STEPS
from passo.motion.planner import Planner
from passo.steps import ring
from passo.steps.word import TICKS_PER_S, Layout, us_to_ticks


def _inputs_for(board, feature):
    """Return the names of the inputs that want this feature."""
    names = [item["name"] for item in board["inputs"]]
    return [name for name, _, _, wanted in inputs_of(board) if wanted == feature and name in names]


def _links_that(board, *ways):
    """Return the links that ask for one of these when their host is lost."""
    return [link for link in board["links"] if link["lost"] in ways]


_OF_ALL = ("steps.feeder", "control.state", "control.controller", "control.queue", "config.settings", "config.journal")
_OF_PROGRAM = ("motion.look_ahead_viper", "steps.segments_viper", "motion.ramp", "motion.circle", "control.stream_queue",
               "motion.arc", "motion.arc_speed", "motion.ellipse", "control.arcs")  # fmt: skip


# Every feature, in any order: its module of control, its class, and the rule by which a board file
# asks for it. A feature is also made if a language of the board's links names it in its NEEDS; all others are neither
# loaded nor, but for those with a rule, in the build.
FEATURES = (
    ("switches", "Switches", lambda board: board["inputs"]),
    ("homing", "Homing", lambda board: board["homing"]),
    ("drawing", "Drawing", None),
    ("changeover", "Changeover", lambda board: [item for item in board["outputs"] if item["role"] != "none"]),
    ("program", "Program", None),
    ("pauses", "Pauses", lambda board: _inputs_for(board, "pauses") or _links_that(board, "pause")),
    ("tools", "Tools", None),
    ("pins", "Pins", None),
    ("links", "Links", lambda board: True),
    ("host_watch", "HostWatch", lambda board: _links_that(board, "pause", "stop", "retract")),
    ("resets", "Resets", lambda board: True),
)


def load_all(board):
    """Import what App will ask for, so that all code is there before there is anything else."""
    additions = board.get("additions")
    spoken = languages(board)
    names = feature_names(board, spoken)
    homing = board["homing"]
    for asked, modules in (
        (True, _OF_ALL),
        ("program" in names, _OF_PROGRAM),
        (homing and "veto" not in getattr(additions, "parts", ()), ("ports.limit_watch",)),
    ):
        for module in modules if asked else ():
            __import__("passo." + module)
    for module in ("drive_module", "motion", "queue", "ramp", "burn"):  # options'
        module = getattr(additions, module, None)
        if module:
            __import__(module)
    make_drive(board)
    load(names, board, spoken)
    if [link for link in board["links"] if link["frames"]]:
        frame_line_class()
    own = lines_of(board)
    if own:
        own.load(board)


def languages(board):
    """Return the packages of the languages of the board file's links, in passo/protocols: NEEDS, OPTIONS, check() and create(). Only what is
    named is loaded, and early: machine code wants memory in one piece. Raises BoardError."""
    modules = []
    for link in board["links"]:
        name = link["protocol"]
        try:
            language = _load_package(name)
            language.NEEDS  # which what languages share has not
        except (AttributeError, ImportError) as missing:
            known = ", ".join([each for each in sorted(folders("passo.protocols")) if hasattr(_load_package(each), "NEEDS")])
            raise BoardError("link %s: unknown protocol %r (%s); known are %s: for another one flash the board anew" % (link["name"], name, missing, known))
        check = getattr(language, "check", None)
        why = check(board) if check else None
        if why:
            raise BoardError("link %s: %s" % (link["name"], why))
        modules.append(language)
    additions = board.get("additions")
    if additions:
        additions.load_languages()
    return modules


def _load_package(name):
    return __import__("passo.protocols." + name, None, None, ("create",))


def frame_line_class():
    """Return the class of lines that speak frames; only boards that have such a link load it. Raises BoardError."""
    try:
        return __import__("passo.protocols.frames", None, None, ("FramedLine",)).FramedLine
    except ImportError as missing:
        raise BoardError("frames are not on this board (%s): flash it anew" % missing)


def lines_of(board):
    """Return an option's module for links that are no cables, or None: load(board), serials(board, port), create(language, …), join(links, controller)."""
    name = getattr(board.get("additions"), "lines", None)
    return __import__(name, None, None, ("load",)) if name else None


def speaker(own, language, link, *more):
    """Make the protocol of a link; `language`: its package; `own`: as lines_of()."""
    return own.create(language, link, *more) if own else language.create(link, *more)


def serials(own, board, port):
    """Return the serial line of each link of the board file."""
    return own.make_serials(board, port) if own else [port.serial(link) for link in board["links"]]


def feature_names(board, languages):
    """Return the names of the features that the board file or one of the languages (modules) asks for, in order."""
    needed = []
    for language in languages:
        needed += language.NEEDS
    return [name for name, _, _, rule in rows(board, languages) if name in needed or rule and rule(board)]


def rows(board, languages):
    """Return [(name, module, class, rule)] of all features. An option's manifest writes those of its own into board["additions"], by name; the
    name of a feature above is that of the class it stands in for. A language has those of options that it wants in OPTIONS. All of these are
    made."""
    own = {}
    for language in languages:
        own.update(getattr(language, "OPTIONS", {}))
    own.update(getattr(board.get("additions"), "features", {}))
    found = []
    for name, kind, rule in FEATURES:
        rule = bool if name in own else rule
        module, kind = own.pop(name, ("passo.control." + name, kind))
        found.append((name, module, kind, rule))
    last = getattr(board.get("additions"), "watchers", ())
    own = [(name, own[name][0], own[name][1], bool) for name in sorted(own)]
    return [row for row in own if row[0] not in last] + found + [row for row in own if row[0] in last]


def load(names, board, languages):
    """Import the features `names` and return [(name, class)]. Raises BoardError if a module is not on this board."""
    try:
        return [
            (name, getattr(__import__(module, None, None, (kind,)), kind))
            for name, module, kind, _ in rows(board, languages) if name in names
        ]  # fmt: skip
    except ImportError as missing:
        raise BoardError("the board file asks for what is not on this board (%s): flash it anew" % missing)


def planner(board, axes, streamed):
    """Make the planner of a board's motors; it plans in steps of the axes. `streamed`: lines of G-code, with acceleration, and arcs."""
    additions = board.get("additions")
    name, ramp = getattr(additions, "motion", None), getattr(additions, "ramp", None)  # modules of options
    made = __import__(name, None, None, ("Planner",)).Planner(axes, board) if name else Planner(axes)
    if streamed:
        made.load(__import__(ramp, None, None, ("limit",)).limit if ramp else None)
    return made


def queue(board, streamed):
    """Return the class of a board's queue; `streamed`: lines of G-code queue in it, one behind the other."""
    name = getattr(board.get("additions"), "queue", None)  # an option's module
    if name:
        return __import__(name, None, None, ("Queue",)).Queue
    if streamed:
        from passo.control.stream_queue import StreamQueue as Queue
    else:
        from passo.control.queue import Queue
    return Queue


def more_settings(languages):
    """Return the languages' (modules) additions to the settings: functions (board, table)."""
    return [language.settings for language in languages if hasattr(language, "settings")]


def burner(board):
    """Return the function that marks rows of dots, an option's; None if the tool takes none."""
    name = getattr(board.get("additions"), "burn", None)
    return __import__(name, None, None, ("burn",)).burn if name else None


def guard_mask(board, languages, settings):
    """Return the mask of the links that move nothing from the start on, before the machine is homed or unlocked: with homing those of
    a language that is GUARDED."""
    guards = range(len(languages)) if settings.value(HOMING) else ()
    return sum([1 << number for number in guards if hasattr(languages[number], "GUARDED")])


def make_drive(board):
    """Return (layout, drive, levels without current) of the board's motors; drive is None if the step form will do."""
    kind = board["drive"]["kind"]
    names = [axis["name"] for axis in board["axes"]]
    count = len(names)
    name = getattr(board.get("additions"), "drive_module", None)  # an option's
    drive = __import__(name, None, None, ("create",)).create(board) if name else None
    if kind == "step_dir":
        motors = names + [motor["name"] for motor in getattr(board.get("additions"), "more_motors", ())]
        pins = [name + "_step" for name in motors] + [name + "_dir" for name in motors]
        return Layout(kind, count, len(pins), pins, (1 << len(motors)) - 1, len(motors)), drive, 0
    pins = [name + "_" + pin for name in names for pin in drive.pins]
    return Layout("coils", count, len(pins), pins, 0), drive, drive.levels_off()


def fastest(board, settings):
    """Return the steps a second of the fastest axis, as board file and settings limit it."""
    axes = range(len(board["axes"]))
    return ring.fastest(board["speed"], [(settings.value(STEPS + axis), settings.value(SPEED + axis)) for axis in axes])


def check_speed(board, least):
    """Raise BoardError if a speed that the board file allows needs words shorter than `least` ticks, the player's shortest."""
    speed = board["speed"]
    ticks = us_to_ticks(2 * speed["min"]) if speed["unit"] == "half_period_us" else TICKS_PER_S // speed["max"]
    if ticks < least:
        raise BoardError("speed: steps every %d ticks of 80 ns; the drive needs %d" % (ticks, least))

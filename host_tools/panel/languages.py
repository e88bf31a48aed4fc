"""The languages that a panel speaks: the machine behind the page, its teach-in, and how its jobs are read.

    spoken = create("pulses", board, port.write, tell)
    PanelOrders(spoken.machine, Store(folder, spoken.read), spoken.teach)
"""

from host_tools.clients import refusal, setting_names
from host_tools.panel import drawing_jobs, job_facts, hand_path
from host_tools.panel.recovery import RecoverableJobs
from host_tools.panel.store import gcode_lines
from passo.config.boardfile import check
from host_tools.page.grbl_machine import AXES, GrblMachine
from host_tools.page.teach import Teach

# The board file that is meant if none is named; its first link's language is the key.
BOARDS = {"grbl": "router_3axis", "pulses": "lpt_router", "torch": "torch_manipulator", "plotter": "plotter_2014", "keys": "two_motor_kit"}
BAUD = {"grbl": 115_200, "pulses": 115_200, "torch": 115_200, "plotter": 57_600, "keys": 9600}


class Spoken:
    """The parts of one language: `machine`; `teach`, or None; `read(path)`: a job's lines as its driver takes them, None: it knows no
    jobs; `about`: fields for the page's first message."""

    def __init__(self, machine, teach, read, about, join=None, made=None, facts=None):
        """`join(store)`: gives the machine its jobs; `made`, `facts`: as a Store takes them."""
        self.facts = facts
        self.made = made
        self.join = join or (lambda store: None)
        self.machine = machine
        self.teach = teach
        self.read = read
        self.about = about


def create(language, board, write, tell, guest=None):
    """Create the Spoken of a language. `board`: a board file's table; `write(bytes)`, `tell(event)`, `guest(bytes)` as a machine takes them."""
    board = check(board)
    if language == "grbl":
        return _create_grbl(board, write, tell, guest)
    about = {"scale": [axis["steps_per_m"] / 1000 for axis in board["axes"]]}
    return {"pulses": _create_pulses, "torch": _create_torch, "plotter": _create_plotter, "keys": _create_keys}[language](board, write, tell, about)


def _create_grbl(board, write, tell, guest):
    """Create the parts of a machine that speaks grbl: teach-in with arcs, jobs that can be resumed."""
    machine = GrblMachine(write, tell, guest)
    machine.cause = refusal.error_cause
    machine.can = (*machine.can, "place")
    teach = Teach(
        lambda points, ways: hand_path.fit_program(points, ways, [float(machine.settings[100 + axis]) for axis in range(len(points[0]))])
    )

    def record_state(state):
        teach.add_report(state)
        state["teaching"] = teach.count_positions()

    def join(store):
        machine.job = RecoverableJobs(machine, tell, store)
        machine.can = (*machine.can, "from")

    machine.watcher = record_state
    return Spoken(machine, teach, gcode_lines, {"rules": setting_names.all_rules(len(AXES))}, join, drawing_jobs.gcode_of(board, machine), job_facts.gcode_facts)


def _create_pulses(board, write, tell, about):
    """Create the parts of a machine of pulse codes; its fastest speed in mm/min follows from the least interval of steps."""
    from passo.options.step_program.control_orders import lengths_of
    from host_tools.page.pulses_machine import PulsesMachine

    machine = PulsesMachine(write, tell, board)
    about["bits"] = board["step_program"]["port_bits"]
    lengths = lengths_of([axis["steps_per_m"] for axis in board["axes"]])
    about["fastest"] = min(lengths[1 << axis] for axis in range(len(board["axes"]))) // board["step_program"]["interval_us"]
    return Spoken(machine, machine.teach, lambda path: path.read_bytes(), about)


def _create_torch(board, write, tell, about):
    from host_tools.page.torch_machine import TorchMachine

    return Spoken(TorchMachine(write, tell, board), None, None, about)


def _create_plotter(board, write, tell, about):
    """Create the parts of a plotter; drawings become jobs of packets."""
    from host_tools.drawings.packets import packet_lines
    from host_tools.page.plotter_machine import PlotterMachine

    speed = board["speed"]
    about["speed"] = {name: speed[name] for name in ("unit", "default", "min", "max")}
    machine = PlotterMachine(write, tell, board)
    machine.can = (*machine.can, "place")
    return Spoken(machine, None, packet_lines, about, made=drawing_jobs.words_of(board, machine), facts=job_facts.packets_of(board))


def _create_keys(board, write, tell, about):
    from host_tools.page.keys_machine import KeysMachine

    return Spoken(KeysMachine(write, tell, board), None, None, about)

"""Resumes a job of the panel that was interrupted, at the line in the board's journal: `passo resume` for the page.

    machine.job = RecoverableJobs(machine, tell, store)
    machine.state["recover"]        # {"name", "line", "known", "next"}: offered; "next": what the tool does when it goes down; "absent": there is
                                    # no such job here, it was begun by `passo stream` or by a panel with another folder
    machine.orders["recover"]({"do": "recover", "what": "begin"})   # tool up, over the place, outputs on; then it asks
    machine.orders["recover"]({"do": "recover", "what": "down"})    # the rest of the program; "drop": tool up, spindle and coolant off; "forget"
    machine.orders["recover"]({"do": "recover", "what": "from", "name": "part.gcode", "line": 120})     # offered: begin at a line, as passo stream --from

The offer's "held" shows the modal state at that line (see Replay.held) before anything moves.

The journal is asked once the machine is at rest: at the start, after homing, when a job has ended, and when a file has been added. Each job tells the board its
number before its first line goes, because the board writes down each line under the last number received. A job that does not
begin sends none, so the job that was interrupted before it is still offered.
"""

from host_tools.failure import Failure
from host_tools.programs import program_names, replay
from host_tools.programs.resume_line import end_position, number_of, plan_stages, resume_point
from host_tools.programs.job_record import Record
from host_tools.programs.replay_machine import Machine
from passo import errors
from passo.protocols.page import orders
from host_tools.page.stored_jobs import StoredJobs
from host_tools.clients.grbl_wire import LOST, PAGE

_REST = ("Idle", "Alarm")
_MOST_LINE = 100_000_000
_HOMING, _HOMING_WAYS = 22, 23  # settings: whether it homes, and which axes at their low ends


class RecoverableJobs(StoredJobs):
    def __init__(self, machine, tell, store):
        StoredJobs.__init__(self, machine, tell, store.pack_job)
        self._tell_all = tell
        self._files = store
        self._asked = False  # the journal is known, or has been asked for
        self._changed = store.changed
        self._announcing = False  # the board has not yet answered that it knows which job begins
        self._collects = None  # lines of answers, while they are wanted
        self._stage = ""  # "over": on its way, "ask": over the place, and the operator is asked
        self._rest = []
        self._left = None  # (name, line) of a forgotten offer, until a job begins
        self._position = None  # mm, at which the machine waits for the answer
        self._plan_number = 0  # counts searches beside the machine: the result of an older one is too late
        machine.state["recover"] = None
        machine.orders["recover"] = self._order_recovery

    def take_line(self, line):
        """Collect a line of an awaited answer, or take it as a stored job's. Returns True if no page shows it."""
        if self._collects is not None and line[:5] != "[MSG:":
            self._collects.append(line)
            return True
        return StoredJobs.take_line(self, line)

    def report(self, state):
        """Take a report; ask for the journal once the machine is at rest, if it is not known."""
        machine = self._machine
        if state == "Home" or self._changed != self._files.changed and not self._stage:
            self._changed = self._files.changed
            self._asked = False
        if not self._asked and self._collects is None and state in _REST and machine.settings and machine.options is not None and not self.is_running() and not machine.refusal():
            self._asked = "J" not in machine.options
            if not self._asked and machine.wire.has_room(len(b"$JR")):
                self._collects = []
                self._asked = machine.wire.send_line(PAGE, b"$JR", self._take_journal)
        StoredJobs.report(self, state)

    def fail(self, error):
        """End the job as failed; drop a search beside the machine, and an offer at which the operator was being asked."""
        self._plan_number += 1
        if self._stage == "ask":  # over the place it stands no more, or not for certain
            self._stage = ""
            self._machine.state["recover"] = None
            self._asked = False
        if error == errors.NO_ANSWER:
            self._asked = False
        StoredJobs.fail(self, error)

    # --- what is offered

    def _take_journal(self, error):
        """Take the answer to `$JR`, and look for the interrupted job beside the machine."""
        said, self._collects = self._collects or [], None
        offer = self._machine.state["recover"]
        if error == LOST or not error and not any(line.startswith("[JOURNAL:") for line in said):  # or an answer to who spoke here before
            self._asked = False
        elif not offer or "held" not in offer:
            self._plan_number += 1
            if error:
                self._set_offer(None)
            else:
                self._run_beside(lambda: self._find_offer(said), self._set_offer)

    def _run_beside(self, work, then):
        """Do `work` beside the machine and call then(result), unless meanwhile a job has begun, failed or stopped, or a newer search has begun."""
        number = self._plan_number

        def take_result(result):
            """Hand the result on if no job and no newer search has begun meanwhile."""
            if self._plan_number == number and not self.is_running():
                then(result)
            else:
                self._asked = False

        self._machine.beside(work, take_result)

    def _set_offer(self, offer):
        """Show an offer on the pages; None: there is none."""
        self._machine.state["recover"] = offer

    def _find_offer(self, said):
        """The offer for a journal's lines `said`, a dict; None: no job was interrupted."""
        for name, lines, crc in self._files.programs():
            try:
                number, _, known = resume_point(said, lines, crc)
            except Failure:
                continue
            left = b"".join(line.upper() for known, line in lines if known >= number)
            if (name, number) != self._left and number > lines[0][0] and any(letter in left for letter in b"XYZA"):  # else only outputs were left, and are off
                return {"name": name, "line": number, "known": known, "next": ""}
            return None
        return self._absent_offer(said)

    def _absent_offer(self, said):
        """The offer of a job that this PC has begun from another folder, a dict; None: there is none, or it is done. `said`: lines of the journal."""
        try:
            record = Record.of_answer(said)
        except Failure:
            return None
        name, last = program_names.name_of_number(record.job)
        if not name or not record.line or record.done and record.line >= last or (name, record.line) == self._left:
            return None
        return {"name": name, "line": record.line, "known": record.is_known, "next": "", "absent": True}

    # --- orders

    def _order_recovery(self, order):
        """Carry out an order: `what` is from, begin, down, drop or forget. Returns 0 or an error. Raises Wrong."""
        machine = self._machine
        what, offer = order.get("what"), machine.state["recover"]
        error = machine.refusal() or machine.busy_error()
        if error:
            return error
        if what == "from":
            return self._look_at(orders.text_field(order, "name", 64), int(orders.number_field(order, "line", 1, _MOST_LINE)))
        if offer is None:
            return errors.NO_SUCH_JOB
        if what == "drop" or what == "forget":
            return self._drop_job() if what == "drop" else self._forget_offer()
        if machine.state["state"] != "Idle":
            return errors.LOCKED
        if "absent" in offer:
            return errors.NO_SUCH_JOB
        if what == "begin":
            return self._begin_again(bool(order.get("unverified")) or offer["known"])
        if what == "down" and self._stage == "ask":
            return self._go_down()
        return errors.ORDER_FIELD

    def _drop_job(self):
        """Withdraw the offer, raise the tool if the position is known and homing ends at Z's top, switch spindle and coolant off. Returns 0 or an
        error."""
        machine = self._machine
        known = machine.state["recover"]["known"]
        self._forget_offer()
        homing, ways = (int(machine.settings.get(number, 0)) for number in (_HOMING, _HOMING_WAYS))
        rises = known and homing and not ways >> 2 & 1 and len(machine.axes) > 2 and machine.state["state"] == "Idle"
        return (machine.send_line(b"G53G0Z0") if rises else 0) or machine.send_line(b"M5") or machine.send_line(b"M9")

    def _forget_offer(self):
        """Withdraw the offer; nothing moves. If it was a chosen line, ask the journal for another offer. Returns 0."""
        offer = self._machine.state["recover"]
        if "held" in offer:
            self._asked = False
        else:
            self._left = offer["name"], offer["line"]
        self._stage = ""
        self._machine.state["recover"] = None
        return 0

    def _begin_again(self, sure):
        """Go to the line of the offer; `sure`: the position is known, or the person takes the risk. Returns 0 or an error."""
        if not sure:
            return errors.NOT_HOMED
        return self._ask_board(self._plan_from, "held" not in self._machine.state["recover"])

    def _ask_board(self, told, journal):
        """Ask the board for its offsets, and its journal if `journal`, and collect the lines; then call told(error). Returns 0 or BUSY."""
        machine = self._machine
        if self._collects is not None:
            return errors.BUSY
        self._collects = []
        if journal and not machine.wire.send_line(PAGE, b"$JR") or not machine.wire.send_line(PAGE, b"$#", told):
            self._collects = None
            return errors.BUSY
        return 0

    def _look_at(self, name, line):
        """Offer to begin at a line; a replay finds the modal state there, and nothing moves. Returns 0 or an error."""
        machine = self._machine
        if machine.state["state"] not in _REST or not machine.settings:
            return errors.LOCKED
        if isinstance(self._files.text_piece(name, 0), int):
            return errors.NO_SUCH_JOB

        def plan_offer(error):
            """Replay the job up to the line, beside the machine, from the board's answers; at an error do nothing."""
            said, self._collects = self._collects or [], None
            if not error:
                self._plan_number += 1
                self._run_beside(lambda: _or_failure(lambda: self._from_line(name, line, said)[0].held), set_offer)

        def set_offer(held):
            """Show the offer to begin at the line, or the failure of the replay."""
            if isinstance(held, Failure):
                self._tell_all({"t": "refused", "text": held.message()})
                return
            self._stage = ""
            machine.state["recover"] = {"name": name, "line": line, "known": False, "next": "", "held": held}

        return self._ask_board(plan_offer, False)

    def _from_line(self, name, line, said):
        """(Replay, stages, rest) of a line of a job. Raises Failure."""
        lines = self._files.program_lines(name)
        settings = [f"${key}={value}" for key, value in dict(self._machine.settings).items()]
        found = replay.Replay(Machine.of_answers(settings, said, [self._machine.rotary]), lines)
        return (found, *found.from_line(line))

    def _plan_from(self, error):
        """Take the board's answers, and plan the way to the line beside the machine."""
        said, self._collects = self._collects or [], None
        offer = self._machine.state["recover"]
        if not error and offer is not None:
            self._plan_number += 1
            self._run_beside(lambda: _or_failure(lambda: self._plan_recovery(offer, said)), lambda planned: self._go_over(offer, planned))

    def _go_over(self, offer, planned):
        """Run the lead-in up to the question to the operator. `planned`: of _plan_recovery(), or a Failure."""
        if isinstance(planned, Failure):
            self._tell_all({"t": "refused", "text": planned.message()})
            return
        lead, self._rest, self._next = planned
        if self._machine.state["recover"] is not offer or self._machine.refusal():
            return
        if not StoredJobs.run(self, offer["name"], lead, 1, False):
            self._stage = "over"

    def _plan_recovery(self, offer, said):
        """(lines up to the question to the operator, lines behind it, text of the move that comes next). Raises Failure."""
        name = offer["name"]
        if "held" in offer:
            number, lines = offer["line"], self._files.program_lines(name)
            _, stages, rest = self._from_line(name, number, said)
        else:
            program = [(lines, crc) for found, lines, crc in self._files.programs() if found == name]
            if not program:
                raise Failure("{} has gone", name)
            lines, crc = program[0]
            number, place, _ = resume_point(said, lines, crc)
            settings = [f"${key}={value}" for key, value in dict(self._machine.settings).items()]
            stages, rest, _dot = plan_stages(Machine.of_answers(settings, said, [self._machine.rotary]), lines, number, place, end_position(said))
        asks = replay.DOWN if any(what == replay.DOWN for what, _ in stages) else replay.GO
        parts, next_ = ([], []), ""
        for what, sent in stages:
            if what == asks:
                next_ = " ".join(_as_text(line) for line in sent)
            parts[bool(next_)].extend((number, _as_text(line).encode()) for line in [*sent, "G4P0"])
        return parts[0], parts[1] + self._files.number_lines(rest), next_

    def _go_down(self):
        """Run the rest of the program, if the machine has not moved since the question. Returns 0 or an error."""
        if self._machine.position != self._position:
            return errors.COMMANDED_ELSEWHERE  # it has been moved since
        offer = self._machine.state["recover"]
        run = StoredJobs.run if "held" not in offer else RecoverableJobs.run  # a line that was chosen begins the job anew, also to the journal
        error = run(self, offer["name"], self._rest, 1, False)
        if not error:
            self._stage = ""
            self._machine.state["recover"] = None
        return error

    # --- jobs

    def run(self, name, lines, passes, checked, single=False):
        """Run a job; first send the board its number for the journal. Returns 0 or an error."""
        machine = self._machine
        said = b"" if checked or not self._has_journal() else b"$JR=%08x" % self._job_number(name, lines)
        error = machine.busy_error() or (0 if machine.wire.has_room(len(said)) else errors.BUSY) or StoredJobs.run(self, name, lines, passes, checked, single)
        if error:
            return error
        self._stage = ""
        self._left = None
        machine.state["recover"] = None
        self._announcing = bool(said)
        if said:
            machine.wire.send_line(PAGE, said, self._note_announcement)
        return 0

    def _has_journal(self):
        """True if the board has a journal, or its options are not known yet."""
        return self._machine.options is None or "J" in self._machine.options

    def _job_number(self, name, lines):
        """The number by which the journal knows a job. A job that is not among the programs read gets one by which it is not found later."""
        return next((program_names.remember_program(text, name) for found, text, _ in self._files.programs() if found == name), None) or number_of(lines)

    def _note_announcement(self, error):
        """Take the answer to the job's number: its lines may go, or the job fails."""
        self._announcing = False
        if error and error != LOST and "J" in (self._machine.options or "") and self.is_running():
            self.fail(error)  # its lines would be taken for those of the job before

    def _begin_job(self, name, what):
        if what == "run":
            self._left = None
        StoredJobs._begin_job(self, name, what)

    def poll(self):
        if not self._announcing:
            StoredJobs.poll(self)

    def _end_job(self, how, error):
        """End the job; behind a lead-in ask the operator, else ask for the journal anew."""
        StoredJobs._end_job(self, how, error)
        offer = self._machine.state["recover"]
        if self._stage == "over" and offer and how == "done":
            self._stage = "ask"
            self._position = list(self._machine.position)
            self._machine.state["recover"] = {**offer, "next": self._next}
        else:
            self._stage = ""
            self._asked = False


def _or_failure(work):
    """Return work()'s result, or the Failure that it raises."""
    try:
        return work()
    except Failure as failure:
        return failure


def _as_text(line):
    return line if isinstance(line, str) else line.decode()

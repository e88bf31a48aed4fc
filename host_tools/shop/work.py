"""A machine's part in the shop's queue: somebody at the machine releases it for one job; the board's journal says how far a job has come.

    work = Work(key, "plotter-3", {"kind": "corexy_plotter"}, machine, tell, parcel)
    work.act("release")         # "paper is in"; "withdraw", "go", "give up". Returns "", or why not
    work.take_order(text)       # of the shop, signed
    work.poll(now_s)
    work.message_for(nonce)     # the message to the shop, signed for its nonce; "": the nonce is not known yet

The agent keeps nothing of a job: the shop's book knows which machine has it, the board's journal, which is announced the job's number before its first
line, whether it was begun, and which line is done. A job is begun without a question only for the release that asked for it. After
anything else (the agent or the board has begun anew, a stop, an alarm) the machine says what stands where, and waits for "go".

`how` of it: REST; FREE, released; FETCH, the job's file comes; RUN; WAITS, `text` says for what; GOES, it is made ready to go on.
"""

import re
import tempfile
import time
from pathlib import Path

from host_tools.failure import Failure, reason
from host_tools.language import _, error_text
from host_tools.panel.recovery import RecoverableJobs
from host_tools.panel.store import Store
from host_tools.programs import gcode_file
from host_tools.programs.job_record import Record
from host_tools.shop.job_table import DONE
from host_tools.shop.signed import MACHINE, SHOP, Opener, sign_message
from passo import errors
from passo.web.guard import make_nonce

REST, FREE, FETCH, RUN, WAITS, GOES = "rest", "free", "fetch", "run", "waits", "goes"
GIVEN_UP, REFUSED = "given up", "refused"  # how a job has ended; or DONE
_RELEASED_S = 1800  # a release lapses: the person may have gone
_SETTLE_S = 0.6  # a report has come by then
_TRIES = 4  # to unlock, to home
_ORDER = {"id": re.compile("[0-9a-fA-F]{1,8}"), "sha": re.compile("[0-9a-f]{64}"), "name": re.compile(r"[^\x00-\x1f]{1,200}")}
_MOST_PARTS = 4096  # of a job's file
_MOST_COUNT = 10**11  # beyond the year 2100; a count has twelve digits at most
_COUNTS_S = 20  # counts of messages a second, so that those of an agent that begins anew are higher


class _Files:
    """The program of the job, by the job's number: the methods of a panel's Store that RecoverableJobs calls."""

    number_lines = staticmethod(Store.number_lines)

    def __init__(self):
        self.changed = 0
        self._programs = []

    def keep_program(self, *program):
        """Keep one program: name, lines of gcode_file.read(), number of its job; without arguments forget it."""
        self._programs = [program] if program else []
        self.changed += 1

    def programs(self):
        """The kept program, [(name, lines, number)], or []."""
        return self._programs

    def program_lines(self, name):
        """The lines of the program `name`. Raises Failure if it is another one."""
        for known, lines, _number in self._programs:
            if known == name:
                return lines
        raise Failure("{} has gone", name)

    def pack_job(self, name):
        return errors.NO_SUCH_JOB


class _Job(RecoverableJobs):
    """It is announced to the board's journal by the job's number, not by that of its lines: a copy is another job."""

    def __init__(self, machine, tell, files):
        RecoverableJobs.__init__(self, machine, tell, files)
        self.files = files
        self.record = None  # of the board's journal; None: not known since the last change

    def keep_program(self, *program):
        self.record = None
        self.files.keep_program(*program)

    def take_line(self, line):
        """Take a line of the journal's answer. Lines of the log do not belong to it: the agent asked for them before."""
        return line[:4] != "[LOG" and RecoverableJobs.take_line(self, line)

    def fail(self, error):
        self.ask_again()
        RecoverableJobs.fail(self, error)

    def ask_again(self):
        """Read the journal anew: homing may have ended before a report showed it."""
        self._asked = False
        self.record = None

    def _take_journal(self, error):
        RecoverableJobs._take_journal(self, error)
        self._asked = self._asked and self.record is not None  # without it no job begins or goes on

    def run(self, name, lines, passes, checked, single=False):
        self.record = None
        return RecoverableJobs.run(self, name, lines, passes, checked, single)

    def waits_to_go_down(self):
        return self._stage == "ask"

    def busy(self):
        """True if the job runs, or the board is being asked how it would go on."""
        return self.is_running() or self._collects is not None

    def _job_number(self, name, lines):
        return self.files.programs()[0][2]

    def _find_offer(self, said):
        """Note the journal's record, and return the offer to resume; None: no job of this agent was interrupted."""
        try:
            self.record = Record.of_answer(said)
        except Failure:
            return None
        offer = RecoverableJobs._find_offer(self, said)
        return None if offer and "absent" in offer else offer


class Work:
    def __init__(self, key, name, about, machine, tell, parcel):
        """`about`: {"kind": board file, "tool": text}; `machine`: a GrblMachine; `tell`: as it takes it; `parcel`: fetches a file: ask(sha, parts),
        data() its bytes or None, drop()."""
        self._key, self._name, self._about = key, name, about
        self._machine, self._parcel = machine, parcel
        machine.job = self._job = _Job(machine, tell, _Files())
        self.how, self.text, self.line = REST, "", 0
        self._order = None  # the shop's, of the job
        self._ended = None  # [id, how, line, text] of the last one
        self._released = False  # for the job whose file comes
        self._begun = False  # the job, as the shop says
        self._yields = ""  # why it takes no orders
        self._held_up = ""  # why it waits if it is not
        self._tries = 0
        self._quiet_s = self._since_s = 0.0
        self._said = ("", None, "")
        self._why = ""
        self._count = 0
        self._renew_nonce()

    def _renew_nonce(self):
        """Choose another nonce: orders signed for the old one are void."""
        self._nonce = make_nonce()
        self._opener = Opener(self._key, SHOP, self._nonce)

    # --- the shop

    def message_for(self, shop):
        """The message to the shop, signed for its nonce `shop`; "" if that is not known. Counted anew if it has changed."""
        body = {
            "how": self.how, "job": self._order["id"] if self._order else "", "nonce": self._nonce, "line": self.line, "text": self.text,
            "ended": self._ended, "area": self._travel_mm(), **self._about,
        }  # fmt: skip
        if not shop:
            return ""
        if (shop, body) != self._said[:2]:
            self._count = max(self._count + 1, int(time.time() * _COUNTS_S) % _MOST_COUNT)
            self._said = shop, body, sign_message(self._key, MACHINE, f"{shop} {self._name}", self._count, body)
        return self._said[2]

    def page_row(self):
        """The job's fields of the page at the machine."""
        name = self._order["name"] if self._order else ""
        return {"how": self.how, "file": name, "line": self.line, "text": self.text or self._yields, "ended": self._ended, "down": self._job.waits_to_go_down()}

    def _travel_mm(self):
        """The travel of X and Y in mm, from settings $130 and $131."""
        settings = self._machine.settings
        return [round(float(settings.get(number, 0)), 3) for number in (130, 131)]

    def take_order(self, text):
        """Take an order of the shop. Ignores one that is not signed for this nonce, or has come before."""
        order = self._opener.open(text)
        if order is None or self._yields or self._order or self.how not in (REST, FREE) or not _is_order(order):
            return
        self._parcel.ask_file(order["sha"], order["parts"])
        self._released, self._held_up = self.how == FREE and not order["again"], _("the agent has begun anew")
        self._begun = order.get("begun") is True
        self._order = order
        self._change_state(FETCH)

    # --- who stands at the machine

    def act(self, what):
        """Carry out an order of the person at the machine: "release", "withdraw", "go" or "give up". Returns "", or why not."""
        return {"release": self._release_machine, "withdraw": self._withdraw_release, "go": self._go_ahead, "give up": self._give_up}.get(what, lambda: _("no such order"))()

    def press_button(self):
        """The machine's button: go on if a job waits, else release the machine."""
        return self._go_ahead() if self.how == WAITS else self._release_machine()

    def _release_machine(self):
        """Release the machine for one job: "paper is in". Returns "", or a sentence that says why not."""
        machine = self._machine
        if self._yields:
            return self._yields
        if self.how != REST:
            return _("the machine has a job, or is released already")
        if not machine.state["link"] or not machine.options:
            return _("the board does not answer")
        if "J" not in machine.options:
            return _("the board keeps no journal (key journal of its board file): it takes no jobs of the shop")
        if machine.busy_error() or machine.state["state"] not in ("Idle", "Alarm"):
            return _("the machine is at work")
        self._tries = 0
        self._released = True
        self._change_state(GOES)
        return ""

    def _withdraw_release(self):
        """Withdraw the release, or refuse a job that has not begun. Returns "", or a sentence that says why not."""
        if self.how == FETCH:
            self._end_job(REFUSED, _("taken back at the machine before it began"))
        elif self.how in (FREE, GOES) and not self._order:
            self._renew_nonce()
            self._change_state(REST)
        else:
            return _("nothing is released")
        return ""

    def _go_ahead(self):
        """Go on with the job that waits. Returns "", or a sentence that says why not."""
        if self._yields:
            return self._yields
        if self.how != WAITS:
            return _("nothing waits")
        if self._machine.state["state"] not in ("Idle", "Alarm"):
            return _("the machine is at work")
        self._tries = 0
        self._change_state(GOES)
        return ""

    def _give_up(self):
        """Give up the job that waits, and switch the tool off. Returns "", or a sentence that says why not."""
        if self.how != WAITS:
            return _("nothing waits")
        if self._machine.state["state"] == "Idle":
            self._machine.send_line(b"M5")
        self._end_job(GIVEN_UP, self.text)
        return ""

    def note_stop(self):
        """Note a STOP: a release or a "go" given before it starts no motion any more."""
        text = _("it was stopped")
        if self.how == FETCH:
            self._released, self._held_up = False, text
        elif self.how in (FREE, GOES):
            self._fall_back(text)

    def yield_machine(self, text):
        """Take no more orders, because another agent speaks for the machine. A job that has not begun does not begin here; one that runs goes on."""
        self._yields = text
        if self.how == FETCH or not self._order and self.how in (FREE, GOES):
            if self._order:
                self._parcel.drop()
            self._order = None
            self._job.keep_program()
            self._renew_nonce()
            self._change_state(REST)
        elif self.how == GOES:
            self._fall_back(text)

    def note_refusal(self, text):
        """Keep the sentence that says why a job does not go on."""
        self._why = text

    # --- as time goes on

    def poll(self, now_s):
        """Do what is due in the present state: fetch a file, judge a stop, go on, let an old release lapse."""
        machine, state = self._machine, self._machine.state
        if machine.wire.count_lines(0) or machine.said:
            self._quiet_s = now_s
        if self.how == FREE and (not state["link"] or state["state"] != "Idle" or now_s - self._since_s > _RELEASED_S):
            self._renew_nonce()
            self._change_state(REST)
        elif self.how == FETCH:
            self._fetch_file()
        elif self.how == RUN and not self._job.busy():
            self._judge_stop()
        elif self.how == GOES and not self._job.busy() and now_s - self._quiet_s > _SETTLE_S:
            self._go_on()
        elif self.how == WAITS:
            self._look_at_journal()
        if not self._since_s:
            self._since_s = now_s

    def _change_state(self, how, text="", line=0):
        """Change to the state `how`, with the text for people and the job's line."""
        self.how, self.text, self.line = how, text, line
        self._since_s = 0.0
        self._quiet_s = time.monotonic()

    def _fetch_file(self):
        """Take the job's file once it is complete and the journal is known: begin the job, or wait for "go" with the reason."""
        if self._job.record is None:
            return
        data = self._parcel.file_data()
        if self._parcel.wrong:
            self.text = _("the file at the broker is not the one that the shop has signed")
        if data is None:
            return
        try:
            lines = _lines_of(data)
        except Failure as failure:
            self._end_job(REFUSED, failure.message())
            return
        except OSError as error:  # its disk is full
            self._end_job(REFUSED, _("the PC beside the machine cannot keep the job's file: {}", reason(error)))
            return
        known = self._job.record.job
        number = int(self._order["id"], 16)
        self._job.keep_program(self._order["name"], lines, number)
        if not self._released or known == number:
            strange = self._begun and known != number
            self._change_state(WAITS, _("this job was begun, but this board's journal does not know it: look whether another machine draws it. Go on begins at its first line") if strange else self._held_up)
        elif self._machine.state["state"] != "Idle" or self._begin_job():
            self._change_state(WAITS, _("the machine was not ready"))

    def _begin_job(self):
        """Run the job from its first line. Returns 0 or an error."""
        name, lines, _number = self._job.files.programs()[0]
        error = self._machine.run(name, Store.number_lines(lines), 1, False, False)
        if not error:
            self._change_state(RUN)
        return error

    def _judge_stop(self):
        """Decide why the job runs no more: it is done, waits for the operator, or waits with the reason."""
        job = self._machine.state["job"]
        if self._job.waits_to_go_down():
            self._change_state(WAITS, _("over the place where it stopped: next the tool goes down"), self.line)
        elif job and job["how"] == "done":
            self._end_job(DONE)
        else:
            why, self._why = self._why, ""
            self._change_state(WAITS, why or (error_text(job["error"]) if job and job["error"] else _("it was stopped")), self.line)

    def _look_at_journal(self):
        """See where the job stands, once the board's journal has told. Returns True if it is done."""
        record, number = self._job.record, int(self._order["id"], 16)
        if record is None or record.job != number or self._job.waits_to_go_down():
            return False
        self.line = record.line
        done = record.line >= self._last_line() and record.done
        if done:
            self._end_job(DONE)
        return done

    def _last_line(self):
        """The number of the last line that moves an axis. Searches from the end, because a waiting machine asks again and again."""
        lines = self._job.files.programs()[0][1]
        return next((number for number, line in reversed(lines) if any(letter in line.upper() for letter in b"XYZ")), 0)

    def _go_on(self):
        """Do the next step behind a release or "go": home or unlock the machine if it wants that, then free it, or begin or resume the job."""
        machine, state = self._machine, self._machine.state
        offer = state["recover"]
        if not state["link"] or self._job.record is None:
            if not state["link"]:
                self._fall_back(_("the board does not answer"))
            return
        if state["state"] == "Alarm":
            self._make_ready(machine.unlock if offer and offer["known"] and not self._tries else machine.home)
        elif state["state"] != "Idle":
            self._fall_back(_("the machine is at work"))
        elif not self._order:
            self._renew_nonce()
            self._change_state(FREE)
        elif self._look_at_journal():
            pass
        elif self._job.waits_to_go_down():
            self._recover_step("down")
        elif offer:
            if offer["known"]:
                self._recover_step("begin")
            else:
                self._make_ready(machine.home)
        elif self._begin_job():
            self._fall_back(_("the machine was not ready"))

    def _make_ready(self, order):
        """Call `order` (home or unlock), _TRIES times at most, and read the journal anew."""
        self._tries += 1
        if self._tries > _TRIES:
            self._fall_back(_("the machine is in alarm"))
        else:
            order()
            self._job.ask_again()
        self._quiet_s = time.monotonic()

    def _recover_step(self, what):
        """Give the order `what` to resume the job: "begin" or "down"."""
        machine = self._machine
        machine.state["job"] = None  # how the one before ended
        error = machine.orders["recover"]({"do": "recover", "what": what})
        if error:
            self._fall_back(error_text(error))
        else:
            self._change_state(RUN, "", self.line)

    def _fall_back(self, text):
        """Wait for "go" with a job, rest without one; `text`: the reason."""
        if self._order:
            self._change_state(WAITS, text, self.line)
        else:
            self._renew_nonce()
            self._change_state(REST, text)

    def _end_job(self, how, text=""):
        """End the job as `how` with `text`, for the next message to the shop, and rest under a new nonce."""
        self._ended = [self._order["id"], how, self.line, text]
        self._order = None
        self._parcel.drop()
        self._job.keep_program()
        self._renew_nonce()
        self._change_state(REST)


def _is_order(order):
    """True if an order has all its fields, each within its bounds."""
    texts = [(order.get(name), pattern) for name, pattern in _ORDER.items()]
    parts = order.get("parts")
    right = all(isinstance(value, str) and pattern.fullmatch(value) for value, pattern in texts) and isinstance(order.get("again"), bool)
    return right and isinstance(parts, int) and not isinstance(parts, bool) and 0 <= parts <= _MOST_PARTS and int(order["id"], 16) > 0


def _lines_of(data):
    """Return the lines of a job's bytes, as gcode_file.read() has them."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "job.gcode"
        path.write_bytes(data)
        return gcode_file.read(path, job=True)


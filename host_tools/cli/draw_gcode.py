"""`passo draw` on machines that speak grbl: the drawing as lines of G-code, written to a file or sent, and gone on with by line, or as a
stored job amid one."""

import hashlib
from dataclasses import fields, replace

from host_tools.cli import resume_gcode, stream
from host_tools.cli.draw_options import continue_advice, pen_of
from host_tools.clients.refusal import Refused
from host_tools.drawings import gcode
from host_tools.drawings.gcode import TOOLS, Cut
from host_tools.failure import Failure, reason
from host_tools.language import _, count_text, line_text
from host_tools.programs import gcode_file, gcode_time, stored_job
from host_tools.programs.gcode_time import Limits
from host_tools.programs.job_record import Record
from host_tools.programs.program_lines import program_lines

_BAUD = 115200
_LEAST_TIMEOUT_S = 5.0


def cuts_of_parts(machine, plan, said):
    """Return {number of a part: its Cut} by the options of the command. Raises Failure if a tool, a layer or a value is wrong."""
    given = {each.name: getattr(said, each.name) for each in fields(Cut) if getattr(said, each.name) is not None}
    if given.get("tool", TOOLS[0]) not in TOOLS:
        raise Failure("--tool takes {}, not {!r}", ", ".join(TOOLS), given["tool"])
    usual = replace(gcode.usual_cut(machine, given.get("tool")), **given).validate()
    found = {part.number: usual for part in plan.parts}
    for text in said.layers or ():
        number, colon, changes = text.partition(":")
        if not colon or not number.isdigit():
            raise Failure("--for wants LAYER:NAME=NUMBER, as in 2:feed=300,depth=1, not {!r}", text)
        if int(number) not in plan.layers:
            raise Failure("--for {}: there is no layer {}; it has {}", text, number, ", ".join(map(str, plan.layers)))
        if int(number) in found:
            found[int(number)] = found[int(number)].with_values(changes)
    return found


class Written:
    """A drawing as G-code. `digest`: of its lines; `seconds`: that they take, about."""

    def __init__(self, machine, plan, said):
        """Make the lines, and estimate their time. Raises Failure if an option is wrong."""
        self._plan, self._cuts = plan, cuts_of_parts(machine, plan, said)
        change = None if said.pens == "none" else [line.strip() for line in (said.change or "M0").split(";")]
        self.lines = gcode.lines_of(plan, self._cuts, change)
        self._pens = gcode.pens_at(self.lines, plan) if change else {}
        self.digest = hashlib.sha256("\n".join(self.lines).encode()).hexdigest()
        self._rows = list(program_lines(line.encode() for line in self.lines))
        limits = Limits.of_board(machine)
        self.seconds = sum(gcode_time.estimate_seconds(self._rows, limits))
        self._rapid_mm_s = min(limits.speeds[:2])

    def travel_s(self, length_mm):
        """Return the seconds that a way of `length_mm` takes with the tool up."""
        return length_mm / self._rapid_mm_s

    def tool_lines(self):
        """Yield a line for each layer: tool, feed in mm/min, depth in mm or power, passes."""
        for part in self._plan.parts:
            cut = self._cuts[part.number]
            if cut.tool == "z":
                yield _("layer {}: tool on Z, F{:g}, {:g} mm deep in {}", part.number, cut.feed, cut.depth, count_text(cut.passes, "pass"))
            elif cut.tool == "laser":
                yield _("layer {}: laser, F{:g}, S{:g}, {}", part.number, cut.feed, cut.power, count_text(cut.passes, "pass"))
            else:
                yield _("layer {}: tool by M3 S{:g} and M5, F{:g}, {}", part.number, cut.power, cut.feed, count_text(cut.passes, "pass"))

    def write(self, console, path):
        """Write the G-code to a file. Raises Failure if it cannot be written."""
        try:
            path.write_text("\n".join([self._head_line(), *self.lines, ""]), encoding="ascii")
        except OSError as error:
            raise Failure("cannot write {}: {}", path, reason(error)) from error
        console.print(_("  {0}: {1}; passo check {0} shows what the machine makes of it", path, count_text(len(self.lines), "line")))

    def _head_line(self):
        """Return the first line of the file: a comment with the drawing's name."""
        name = "".join(each for each in self._plan.name if each.isascii() and each not in "()")
        return f"(passo draw {name})"

    def _continue_stored_job(self, client, said):
        """If the board's journal says that it ran these lines as a stored job, go on with that and return True; else False. Raises Failure."""
        resume_gcode.wait_until_settled(client)
        try:
            found = Record.of_answer(client.command("$JR"))
        except Refused:
            return False  # no journal
        rows = [(number + 1, line) for number, line in self._rows]
        number = stored_job.crc_of(stored_job.gcode_lines(rows))
        if found.job != number:
            return False
        resume_gcode.go_on(client, rows, self._plan.name, number, said.home and not said.unlock, said.unlock, said.yes)
        return True

    def run(self, console, record, said):
        """Send the G-code from its start, or with --continue from the line that was interrupted. Raises Failure, also if the operator aborts."""
        from host_tools.cli import ports
        from host_tools.clients.grbl import GrblClient

        first = None
        with GrblClient(said.port or ports.only_port(), said.baud or _BAUD, max(said.timeout, _LEAST_TIMEOUT_S), said.log) as client:
            if said.resume:
                if self._continue_stored_job(client, said):
                    return
                record.resume_from_file()
                first = record.object
                pens = [part for line, part in self._pens.items() if line < first]
                if pens and first not in self._pens:
                    console.print(_("  pen {} draws on", pen_of(pens[-1])))
            stream.make_ready(client, said.home and not said.unlock, said.unlock)
            try:
                seconds, _count = stream.send(client, self._rows, self._plan.name, True, first, said.yes, self._line_name, record.save_progress)
            except stream.Aborted as aborted:
                raise Failure("{}; {}", aborted, continue_advice(record)) from None
        record.remove_file()
        console.print(_("drawn in {}: {}", gcode_file.clock_text(seconds), count_text(len(self._rows), "line")))

    def _line_name(self, number):
        """Return the name of line `number` for people; at a change of pens with the next pen."""
        part = self._pens.get(number)
        return _("{}: put in pen {}", line_text(number), pen_of(part)) if part else line_text(number)

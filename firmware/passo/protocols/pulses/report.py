"""The status line of the language of pulse codes, and the image of the parallel port in it.

    status(report, board["step_program"])      # "<state:run at:34 of:100 …>"
    status_from(line)["at"]             # "34": the host's end of it
"""

from passo.commands import STATUS_WORDS


def port_byte(step, tool, drives, config):
    """Return the image of the parallel port while `step` (a byte of CODES, 0: none) is made; `config`: the section `step_program`."""
    image = (0x80 if drives else 0) | (1 if tool else 0)
    for axis in range(3):
        if step >> axis & 1:
            image |= 4 << 2 * axis
            if not step >> 4 + axis & 1:
                image |= 2 << 2 * axis
    shown = 0
    for bit in range(8):
        position = config["port_bits"][7 - bit]
        if position != "-" and (image ^ config["port_invert"]) >> bit & 1:
            shown |= 1 << int(position)
    return shown


def status(report, config):
    """Return the line that answers {?}: `<state:run at:34 of:100 pass:1/5 going:+ speed:1000.2 wait:0 place:1,2,3 …>`.

    at, of: commands of the file played, and in all; going: - backward; speed: mm/min, as the whole microseconds of a period make it; wait:
    ms to go; place: steps; manual: units of manual moves; port: the port's image in hex, its directions those of the step being made; ask: 1 if
    the operator's speed is wanted; ours: 0 while another controller has the motors. Behind these the words of commands.STATUS_WORDS."""
    program = report["step_program"]
    speed = program["speed"]
    fields = (
        ("state", report["state"]),
        ("at", program["index"]),
        ("of", program["total"]),
        ("pass", "%d/%d" % (program["pass"], program["passes"])),
        ("going", "-" if program["backward"] else "+"),
        ("speed", "%d.%d" % (speed // 10, speed % 10)),
        ("wait", program["wait_ms"]),
        ("ask", 1 if program["asked"] else 0),
        ("place", ",".join([str(steps) for steps in report["position"]])),
        ("manual", program["manual"]),
        ("tool", 1 if program["tool"] else 0),
        ("drives", 1 if program["drives"] else 0),
        ("port", "%02X" % port_byte(program["moving"] | program["negative"] << 4, program["tool"], program["drives"], config)),
        ("room", program["room"]),
        ("ours", 1 if report.get("ours", True) else 0),
        ("error", report["error"]),
    )
    more = [(word, report[key]) for key, word in STATUS_WORDS if report.get(key) is not None]
    return "<" + " ".join(["%s:%s" % field for field in list(fields) + more]) + ">\n"


def status_from(line):
    """Return the fields of a status line as a dict of texts. Raises ValueError if it is none."""
    line = line.strip()
    if not (line.startswith("<state:") and line.endswith(">")):
        raise ValueError("not a status line")
    fields = {}
    for field in line[1:-1].split(" "):
        name, colon, value = field.partition(":")
        fields[name] = value
    return fields


def log_lines(log):
    """Return the lines that answer {log}, the oldest first: milliseconds, number, who; then ok."""
    return "".join(["log:%d,%d,%s\n" % (ms, number, who or "") for ms, number, who in log.entries]) + "ok\n"

"""The lines of stored jobs in packets of the plotter's language."""

from check_plotter import GAP_MS, feed_all
from passo.commands import ACCEPTED, HELLO, REFUSED, Event
from passo.options.jobs.commands import JOB
from passo.options.jobs.language_grbl import teach_lines
from passo.protocols.plotter.host import COMMANDS, Plotter, packet
from passo.protocols.plotter.words import PacketWords


def packets_of(line, first=0):
    """The packets of a line of text, numbered from `first`."""
    data = line.encode() + b"\n"
    data += b" \n"[: -len(data) % 3]
    parts = [data[at : at + 3] for at in range(0, len(data), 3)]
    return [packet(COMMANDS["WORDS"], first + number << 8 | part[0], part[1] << 8 | part[2]) for number, part in enumerate(parts)]


def check_lines_in_packets():
    """A line in packets, one of which comes twice; one that does not follow; one that is no line."""
    made = Plotter(GAP_MS)
    teach_lines(PacketWords.words_of(made))
    first, second, last = packets_of("$FD=PART")
    for data in (first, second, second):
        command = feed_all(made, data, 0)[0]
        assert command.kind == HELLO and made.reply(Event(ACCEPTED, command)) == b"k"
    command = feed_all(made, last, 0)[0]
    assert command.kind == JOB and command.target == "PART"
    assert made.reply(Event(ACCEPTED, command)) == b"ok\n" and made.reply(Event(REFUSED, command, 150)) == b"error:150\n"
    for data, answer in ((packets_of("$F", 1)[0], b"r"), (packets_of("$X")[0], b"error:3\n"), (packets_of("$JR")[0], b"k"), (packets_of("$JR")[1], b"error:3\n")):
        command = feed_all(made, data, 0)[0]
        event = Event(ACCEPTED, command) if command.kind == HELLO else Event(REFUSED, command, command.error)
        assert made.reply(event) == answer, (data, answer)

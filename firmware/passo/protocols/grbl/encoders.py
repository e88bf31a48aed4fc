"""What the grbl language says of encoders: a board without any does not load this."""


def told(encoders):
    """The lines of $ENC, one an encoder: motor, counts, steps that it has turned beyond what was stepped, the largest such
    error so far."""
    lines = []
    for number in range(len(encoders.names)):
        values = encoders.names[number], encoders.count(number), encoders.steps(number), encoders.most(number)
        lines.append("[ENC:%s,%d,%d,%d]\r\n" % values)
    return "".join(lines)

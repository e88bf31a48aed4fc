"""What `$ENC` says."""


def text(encoders):
    """A line an encoder: motor, counts, steps turned beyond those stepped, the largest such error so far."""
    rows = [(name, encoders.count(number), encoders.steps(number), encoders.most(number)) for number, name in enumerate(encoders.names)]
    return "".join(["[ENC:%s,%d,%d,%d]\r\n" % row for row in rows])

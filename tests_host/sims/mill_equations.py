"""The logic of the mill's CPLD, written down anew from its document (section 5.2), as functions of named signals.

    EQUATIONS["hx"](bxa=0, bxb=0, …)

The document's text ends in the middle of the last equation, sz: its second product is that of sx and sy.
"""


def pulse(blocked_forward, blocked_back, good, request, direction, port, port_direction, sel):
    """A step pulse, from this board (sel) or from the parallel port."""
    asked, forward = (request, direction) if sel else (port, port_direction)
    return bool(asked and good and not (blocked_forward if forward else blocked_back))


EQUATIONS = {
    "bxp": lambda bxa, bxb, sel: (bxa or bxb) and not sel,
    "byp": lambda bya, byb, sel: (bya or byb) and not sel,
    "bzp": lambda bza, bzb, sel: (bza or bzb) and not sel,
    "dfp": lambda sel, urg: urg and not sel,
    "pap": lambda pal, sel: pal and not sel,
    "enm": lambda rc0, sel, urg: not urg and (rc0 or not sel),
    "s_tvt": lambda rc1, sel, urg: not urg and (rc1 or not sel),
    "s_asp": lambda rc2, sel, asp: rc2 if sel else asp,
    "sx": lambda sel, sxc, sxp: sxc if sel else sxp,
    "sx2": lambda sel, sx2c: sel and sx2c,
    "sy": lambda sel, syc, syp: syc if sel else syp,
    "sz": lambda sel, szc, szp: szc if sel else szp,
    "hx": lambda bxa, bxb, dx1, dx2, hxc, hxp, sel, sxc, sxp: pulse(bxb, bxa, dx1 and dx2, hxc, sxc, hxp, sxp, sel),
    "hx2": lambda bxa, bxb, dx1, dx2, hx2c, sel, sx2c: pulse(bxb, bxa, dx1 and dx2, hx2c, sx2c, 0, 0, sel),
    "hy": lambda bya, byb, dy, hyc, hyp, sel, syc, syp: pulse(byb, bya, dy, hyc, syc, hyp, syp, sel),
    "hz": lambda bza, bzb, dz, hzc, hzp, pal, sel, szc, szp: pulse(bza, bzb or pal, dz, hzc, szc, hzp, szp, sel),
    "ra3": lambda ra0, ra1, ra2, bya, bzb, dy, syn: multiplexed(ra0, ra1, ra2, bya, bzb, 0, syn, not dy, 0),
    "ra4": lambda ra0, ra1, ra2, bxb, bza, dx2, dninosx2, tvt: multiplexed(
        ra0, ra1, ra2, bxb, bza, 0, tvt, not dx2, not dninosx2
    ),
    "ra5": lambda ra0, ra1, ra2, bxa, byb, pal, dx1, dz, urg: multiplexed(ra0, ra1, ra2, bxa, byb, pal, urg, not dx1, not dz),
}  # fmt: skip


def multiplexed(ra0, ra1, ra2, *channels):
    """One of the status multiplexer's outputs: `channels` of the addresses 0 … 5, ra0 its lowest bit."""
    address = ra0 + 2 * ra1 + 4 * ra2
    return channels[address] if address < len(channels) else 0


def allowed(axis, forward, states):
    """Whether the mill's pulses may step now, by the equations: `states` of its inputs by their names of then."""
    inputs = {**states, "sel": states["sel"]}
    if axis == "x":
        common = {name: inputs[name] for name in ("bxa", "bxb", "dx1", "dx2", "sel")}
        both = EQUATIONS["hx"](**common, hxc=1, sxc=forward, hxp=0, sxp=0)
        return both and EQUATIONS["hx2"](**common, hx2c=1, sx2c=forward)
    if axis == "y":
        common = {name: inputs[name] for name in ("bya", "byb", "dy", "sel")}
        return EQUATIONS["hy"](**common, hyc=1, syc=forward, hyp=0, syp=0)
    common = {name: inputs[name] for name in ("bza", "bzb", "dz", "pal", "sel")}
    return EQUATIONS["hz"](**common, hzc=1, szc=forward, hzp=0, szp=0)

"""The largest arrays and buffers of a machine, made before code is loaded."""

import gc

from passo.ports.rp2.fields import LEAD_TICKS
from passo.ports.rp2.stock import pieces
from passo.records import ARCS, ARC_FIELDS, LINES_BYTES, QUEUE_SIZE, ROW_STEPS
from passo.steps.power import power_items
from passo.steps.ring import fastest, mark_items, power_room, ring_size


def sizes(board):
    """Return ((type code, items), …) of the largest arrays that the machine of a checked board will ask of passo.arrays."""
    rates = [(axis["steps_per_m"], 1000 * axis["max_mm_min"]) for axis in board["axes"]]
    queue = ("i", QUEUE_SIZE * (ROW_STEPS + len(rates)))
    marks = ("i", mark_items(len(rates)))
    ring = ("I", ring_size(fastest(board["speed"], rates), LEAD_TICKS))
    found = queue, ("i", power_items(*power_room(board))), marks, ring
    if "grbl" in [link["protocol"] for link in board["links"]]:  # no other language has arcs
        found += (("i", ARC_FIELDS * ARCS),)
    return found


def reserve(board):
    """Make the largest arrays, and the buffers of links and files. Returns the first of the arrays."""
    languages = [link["protocol"] for link in board["links"]]
    gc.collect()
    made = [(kind, (pieces.numbers if kind == "I" else pieces.zeros)(count)) for kind, count in sizes(board)]
    jobs = getattr(board.get("additions"), "file_links", ())
    if jobs:
        from passo.ports.rp2.stock import streams

        streams.hold()
    languages += [language for _, language in jobs]
    pieces.offer(made + [("b", bytearray(LINES_BYTES)) for language in languages if language == "grbl"], 1 + len(jobs))
    return made[0][1]

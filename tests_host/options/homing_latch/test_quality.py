"""How homing is judged: by the edges that it has found."""

from types import SimpleNamespace

import pytest

from passo.options.homing_latch.control import Quality
from passo.protocols.grbl.homing import homing_lines


class Edges:
    """A seeker as Quality reads it: its sensors' edges, the start of its run, the distance of its end from the edge."""

    def __init__(self, start, edge):
        self.axis, self.sensors, self.away = 0, [None], 1
        self.start, self.edges, self.ends = start, [edge], [100]


@pytest.mark.quick
def test_the_judgement_is_of_the_edges_themselves():
    """Each run begins at the end of the one before: the judgement is of the edges' places, not of the distances run."""
    for edges, wanted in (
        ([7, 10, 11, 10, 11, 10, 11], "[HOM:x,6,1,0.55,good]"),
        ([7, 10, 14, 9, 13, 10, 12], "[HOM:x,6,5,1.97,scatters: lower $24, raise $26, or clean the switch]"),
        ([7, 10, 12, 14, 16, 18, 20], "[HOM:x,6,10,3.74,drifts +8: steps are lost: lower $25, or acceleration]"),
    ):
        quality = Quality(None, SimpleNamespace(), None)
        quality.begin(len(edges) - 1)
        start = 5000
        for number, edge in enumerate(edges):
            assert quality.again([[Edges(start, edge)]]) == (number < len(edges) - 1)
            start = edge + 100
        assert homing_lines(quality.rows()) == wanted + "\r\n"

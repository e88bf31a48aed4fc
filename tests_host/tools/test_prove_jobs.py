"""The golden jobs of `passo prove`: every packet of a plotter's is answered, and its words are those of the digests' own port."""

import copy
import io

import pytest
from digest import checked, digest

from host_tools import boards
from host_tools.prove import board_words
from host_tools.prove.digests import jobs_of
from passo.app import App

JOBS = jobs_of("plotter")


@pytest.mark.parametrize("name", JOBS)
def test_a_drawing_of_packets(name):
    board = boards.load("plotter_2014")
    port = board_words.Words()
    app = App(checked(copy.deepcopy(board)), port)
    assert board_words.draw_packets(app, port, JOBS[name]) == 0
    board_words.run_until_still(app)
    sink = digest(board, io.BytesIO(b"".join(JOBS[name])))
    assert (port.digest(), port.count) == (sink.hexdigest(), sink.words) and sink.stepping

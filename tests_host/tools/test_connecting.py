"""A program that connects to a machine at work does nothing to it: no reset, no entry in its log."""

import pytest
from running_router import Running

from host_tools.clients.grbl import GrblClient, Refused


@pytest.fixture
def board():
    running = Running()
    yield running
    running.close()


def under_way(board):
    """A line of some seconds, which another program has sent, and left."""
    with GrblClient(board.line.name) as client:
        client.connect()
        client.command("$X")
        client.command("G91G1X40F600")
    board.until(lambda: board.app.controller.state == "run")
    return list(board.app.controller.machine.log.entries)


def test_a_machine_that_moves_is_left_alone(board):
    before = under_way(board)
    with GrblClient(board.line.name) as client:
        with pytest.raises(Refused, match=r"at work \(Run\)"):
            client.connect()
    assert board.app.controller.state == "run" and list(board.app.controller.machine.log.entries) == before
    with GrblClient(board.line.name) as client:
        client.real_time(b"!")
        board.until(lambda: client.ask_status()["state"] == "Hold:0")
        with pytest.raises(Refused, match=r"at work \(Hold"):
            client.connect()
    assert list(board.app.controller.machine.log.entries) == before


def test_a_machine_that_stands_is_reset(board):
    with GrblClient(board.line.name) as client:
        client.connect()
        assert client.banners >= 1
        client.command("$X")
        client.connect()
        assert client.ask_status()["state"] in ("Idle", "Alarm")

"""No axis leaves its travel, and no axis or motor is faster than it may be, over random programs on whole virtual boards.

    PYTHONPATH=tests_host/sims:. python tests_host/sims/soak_travel.py 0 100 corexy_plotter      # of BOARDS

A program is some lines, arcs, helices and jogs; one in five wants to leave the travel. Refused lines move nothing, and are exactly those that would leave it;
for arcs the machine's own steps decide.
"""

import copy
import random
import sys

from asked import Asked

from host_tools import boards

BOARDS = ("corexy_plotter", "router_4axis", "router_ballscrew")
LINES = 12
WINDOW_US = 20_000
PLAY = {"x": 13, "y": 16, "z": 6}  # steps of router_ballscrew's backlash


class Travelled(Asked):
    """A homed machine with soft limits; places in steps."""

    def __init__(self, name):
        self.board = board = copy.deepcopy(boards.load(name))
        board["journal"] = None
        for link in board["links"]:
            link.pop("lost")
        board.get("spindle", {}).update(spin_up_ms=0)
        high = board["homing"].get("high_end", "")
        self.axes = board["axes"]
        self.endless = [axis["name"] not in board["homing"]["sensors"] for axis in self.axes]
        self.reach = [(-axis["travel_steps"], 0) if axis["name"] in high else (0, axis["travel_steps"]) for axis in self.axes]
        start = [0 if free else -500 if axis["name"] in high else 500 for axis, free in zip(self.axes, self.endless)]  # A is 0 where it stands
        Asked.__init__(self, board, start=start, **({"play": PLAY} if board.get("backlash") else {}))
        self.refused = 0
        self.do("$H", "$20=1", "G21G90G17")
        self.stand()
        self.begun = len(self.machine.trace.rows())

    def inside(self, places):
        return all(free or low <= place <= high for place, (low, high), free in zip(places, self.reach, self.endless))

    def mm(self, axis, place):
        return "%.6f" % (place * 1000 / self.axes[axis]["steps_per_m"])

    def goal(self, chance, place):
        """Near or far, in the travel or beyond it by a step or more."""
        goal = []
        for (low, high), here, free in zip(self.reach, place, self.endless):
            far = chance.choice((3, 300, 3000))
            to = here + chance.randint(-far, far)
            if not free:
                to = min(max(to, low), high)
                if chance.random() < 0.05:
                    beyond = chance.choice((1, 2, 40, 5000))
                    to = chance.choice((low - beyond, high + beyond))
                elif chance.random() < 0.1:
                    to = chance.choice((low, high))
            goal.append(to)
        return goal

    def line(self, chance):
        place = list(self.plant.position)
        goal = self.goal(chance, place)
        words = "".join(axis["name"].upper() + self.mm(n, goal[n]) for n, axis in enumerate(self.axes))
        kind = chance.choice(("G0", "G1", "G1", "$J=G90"))
        said = self.ask(f"{kind}{words}F{chance.randint(2000, 20000)}")
        if self.inside(goal):
            assert said.endswith("ok"), (said, words)
            self.stand()
            assert list(self.plant.position) == goal, (kind, words, list(self.plant.position), goal, place)
            return
        assert said.startswith("error:15" if kind[0] == "$" else "ALARM:2"), (said, words, place)
        self.recover()
        assert list(self.plant.position) == place

    def arc(self, chance):
        where = [place + chance.randint(-1500, 1500) for place in self.plant.position[:2]]
        ends = f"X{self.mm(0, where[0])}Y{self.mm(1, where[1])}R{chance.choice((5, 8, 14, -14))}F{chance.randint(2000, 9000)}"
        said = self.ask(chance.choice(("G2", "G3")) + ends)
        if "ok" in said:
            self.stand()
        else:
            assert said.startswith(("ALARM:2", "error:15", "error:33", "error:34")), said
            self.recover()

    def recover(self):
        self.refused += 1
        self.machine.send(b"\x18")
        self.machine.run_ms(100)
        self.do("$X", "G21G90G17")
        self.stand()

    def hold(self):
        """The travel and the speeds, over all that was done since the last time."""
        rows = self.machine.trace.rows()[self.begun :]
        self.begun += len(rows)
        count = len(self.axes)
        for row in rows:
            assert self.inside(row[1 : 1 + count]), row
        speeds = [(axis["max_mm_min"] / 60 * axis["steps_per_m"] / 1000) for axis in self.axes]
        ways = [[row[1 + axis] for row in rows] for axis in range(count)]
        if self.board.get("kinematics") == "corexy":
            ways += [[row[1] + row[2] for row in rows], [row[1] - row[2] for row in rows]]
            speeds += [speeds[0], speeds[0]]
        grains = [1] * len(ways) if len(ways) == count else [2] * len(ways)  # a step of a motor is half a step of two axes
        for places, speed, grain in zip(ways, speeds, grains):
            first = 0
            for last, row in enumerate(rows):
                while row[0] - rows[first][0] >= WINDOW_US:
                    first += 1
                assert abs(places[last] - places[first]) <= speed * WINDOW_US / 1e6 * 1.01 + grain, (row, places[first], places[last])


def run(name, first, last):
    """Programs of seeds `first` to `last` − 1. Returns (lines refused, places of the trace looked at)."""
    machine = Travelled(name)
    begun = machine.begun
    for seed in range(first, last):
        chance = random.Random(seed)
        for _ in range(LINES):
            (machine.arc if chance.random() < 0.3 else machine.line)(chance)
        machine.hold()
    return machine.refused, machine.begun - begun


if __name__ == "__main__":
    print(*run(sys.argv[3], int(sys.argv[1]), int(sys.argv[2])))
